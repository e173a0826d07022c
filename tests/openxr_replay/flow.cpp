#include "tests/openxr_replay/flow.h"

namespace knead::replay {

using xr::XrState;

Refused SessionFlow::begin()
{
    if (begun) return "XR_ERROR_SESSION_RUNNING";
    if (state != XrState::ready) return "XR_ERROR_SESSION_NOT_READY";
    begun = true;
    return {};
}

Refused SessionFlow::end()
{
    if (!begun) return "XR_ERROR_SESSION_NOT_RUNNING";
    if (state != XrState::stopping) return "XR_ERROR_SESSION_NOT_STOPPING";
    begun = shown = false;
    enter(XrState::idle);
    if (exiting) enter(XrState::exiting);
    return {};
}

void SessionFlow::stop()
{
    if (state == XrState::ready) enter(XrState::synchronized);
    if (state == XrState::focused) enter(XrState::visible);
    if (state == XrState::visible) enter(XrState::synchronized);
    enter(XrState::stopping);
}

Refused SessionFlow::request_exit()
{
    if (!begun) return "XR_ERROR_SESSION_NOT_RUNNING";
    exiting = true;
    stop();
    return {};
}

void SessionFlow::frame_ended()
{
    if (shown || state != XrState::ready) return;
    shown = true;
    enter(XrState::synchronized), enter(XrState::visible), enter(XrState::focused);
}

void SessionFlow::take_off(int polls)
{
    if (!begun || asleep > 0) return;
    asleep = polls;
    stop();
}

void SessionFlow::polled_empty()
{
    if (begun || asleep == 0 || state != XrState::idle) return;
    if (--asleep == 0) enter(XrState::ready);
}

Refused FrameOrder::begin(bool& discarded)
{
    if (begun == waited) return "XR_ERROR_CALL_ORDER_INVALID";
    discarded = begun > ended;
    if (discarded) ended = begun;
    ++begun;
    return {};
}

Refused FrameOrder::may_end() const { return ended == begun ? "XR_ERROR_CALL_ORDER_INVALID" : ""; }

Refused FrameOrder::end()
{
    const Refused refused = may_end();
    if (refused.empty()) ended = begun;
    return refused;
}

Refused ImageOrder::acquire(int& index)
{
    if (acquired - released == count) return "XR_ERROR_CALL_ORDER_INVALID";
    index = acquired++ % count;
    return {};
}

Refused ImageOrder::wait()
{
    if (waited == acquired || waited > released) return "XR_ERROR_CALL_ORDER_INVALID";
    ++waited;
    return {};
}

Refused ImageOrder::release()
{
    if (released == waited) return "XR_ERROR_CALL_ORDER_INVALID";
    ++released;
    return {};
}

bool is_name(const std::string& name)
{
    return !name.empty() &&
           name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_.") == name.npos;
}

bool is_path(const std::string& path)
{
    constexpr std::size_t longest = 255;  // XR_MAX_PATH_LENGTH counts the end, too
    if (path.size() < 2 || path.size() > longest || path[0] != '/' || path.back() == '/')
        return false;
    for (std::size_t from = 1; from < path.size();) {
        const std::size_t to = std::min(path.find('/', from), path.size());
        const std::string name = path.substr(from, to - from);
        if (!is_name(name) || name.find_first_not_of('.') == name.npos) return false;
        from = to + 1;
    }
    return true;
}

}  // namespace knead::replay
