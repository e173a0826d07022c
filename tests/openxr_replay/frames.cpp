// Frames: waiting, beginning, ending, and where the eyes are.
#include <chrono>
#include <thread>

#include "render/gl.h"
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

// Of the left eye; the right one's is its mirror image. Inwards less than outwards, as lenses have.
constexpr float outwards = 0.82f, inwards = 0.70f, upwards = 0.76f, downwards = 0.84f;  // [rad]

std::int64_t monotonic()  // [ns]
{
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Of the runtime's clock; 0 in virtual time.
std::int64_t now_of(const Runtime& r)
{
    return r.script.real_time ? monotonic() - clock_offset(r) : 0;
}

// Blocks while another thread has to begin the frame before. A frame that is not begun in time
// never will be: xrWaitFrame then refuses.
void wait_for_begin(XrSession handle)
{
    constexpr std::chrono::seconds patience{5};
    Runtime& r = runtime();
    std::unique_lock held(r.lock);
    r.frame_begun.wait_for(held, patience, [&] {
        const auto found = r.objects.find(number_of(handle));
        if (found == r.objects.end()) return true;
        const auto* session = dynamic_cast<const SessionObject*>(found->second.get());
        return !session || !session->flow.running() || session->order.may_wait();
    });
}

XrResult XRAPI_CALL wait(XrSession handle, const XrFrameWaitInfo* info, XrFrameState* to)
{
    std::int64_t sleep = 0;
    wait_for_begin(handle);
    const XrResult result = answered("xrWaitFrame", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        if (info) check_struct(info, XR_TYPE_FRAME_WAIT_INFO);
        check_struct(to, XR_TYPE_FRAME_STATE);
        refuse_if(!session.flow.running(), XR_ERROR_SESSION_NOT_RUNNING, "it is not running");
        refuse_if(!session.order.may_wait(), XR_ERROR_CALL_ORDER_INVALID,
                  "waited for twice without a beginning: this would block");
        ++r.frame;
        play_faults(session);
        session_of(handle);  // may be lost by now
        session.order.wait();
        const std::int64_t now = now_of(r);
        session.waited = r.clock.next(now);
        session.will_render = session.flow.visible() && r.frame % r.script.render_every == 0 &&
                              !r.script.has(FaultKind::no_render, r.frame);
        to->predictedDisplayTime = session.waited;
        to->predictedDisplayPeriod = r.clock.period();
        to->shouldRender = session.will_render;
        if (now > 0) sleep = session.waited - r.clock.lead() - now;
    });
    if (sleep > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(sleep));
    return result;
}

// Some runtimes fail where an error was left before the call.
void check_no_gl_error(SessionObject& session)
{
    const auto held = session.gl->bind();
    const unsigned error = glGetError();
    refuse_if(error != 0, XR_ERROR_RUNTIME_FAILURE,
              "called with a GL error pending: " + std::to_string(error));
}

XrResult XRAPI_CALL begin(XrSession handle, const XrFrameBeginInfo* info)
{
    return answered("xrBeginFrame", [&](Runtime& r) -> XrResult {
        SessionObject& session = session_of(handle);
        if (info) check_struct(info, XR_TYPE_FRAME_BEGIN_INFO);
        refuse_if(!session.flow.running(), XR_ERROR_SESSION_NOT_RUNNING, "it is not running");
        check_no_gl_error(session);
        bool discarded = false;
        allowed(session.order.begin(discarded));
        session.begun = session.waited, session.begun_frame = r.frame;
        session.begun_to_render = session.will_render;
        r.frame_begun.notify_all();
        refuse_if(discarded, XR_FRAME_DISCARDED, "a frame was begun and never ended");
        return XR_SUCCESS;
    });
}

XrResult XRAPI_CALL end(XrSession handle, const XrFrameEndInfo* info)
{
    return answered("xrEndFrame", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_FRAME_END_INFO);
        check_no_gl_error(session);
        allowed(session.order.may_end());
        refuse_if(info->displayTime <= 0, XR_ERROR_TIME_INVALID, "not a time");
        complain_if(info->displayTime != session.begun, "another display time than the frame's");
        const bool opaque = info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
        const bool alpha = info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
        refuse_if(!opaque && !(alpha && r.script.passthrough),
                  XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "a mode that is not offered");
        check_layers(session, *info);
        session.order.end();
        log_layers(session, *info);
        session.flow.frame_ended();
        if (r.script.has(FaultKind::gl_error, session.begun_frame)) {
            const auto held = session.gl->bind();
            glEnable(0xffff);
        }
        if (r.context_stolen) session.gl->steal();
    });
}

XrResult XRAPI_CALL locate(XrSession handle, const XrViewLocateInfo* info, XrViewState* state,
                           std::uint32_t capacity, std::uint32_t* count, XrView* to)
{
    return answered("xrLocateViews", [&](Runtime& r) {
        session_of(handle);
        check_struct(info, XR_TYPE_VIEW_LOCATE_INFO);
        check_struct(state, XR_TYPE_VIEW_STATE);
        const SpaceObject& base = r.get<SpaceObject>(info->space);
        check_view_type(info->viewConfigurationType);
        refuse_if(info->displayTime <= 0, XR_ERROR_TIME_INVALID, "not a time");
        for (std::uint32_t i = 0; to && i < capacity; ++i) check_struct(&to[i], XR_TYPE_VIEW);
        state->viewStateFlags =
            XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT |
            XR_VIEW_STATE_POSITION_TRACKED_BIT | XR_VIEW_STATE_ORIENTATION_TRACKED_BIT;
        std::vector<XrView> all;
        const double time = r.script_time(info->displayTime);
        for (int eye = 0; eye < 2; ++eye) {
            Joint<double> pose = eye_at(r.script, time, eye);
            if (!in_space(base, time, pose)) state->viewStateFlags = 0;
            all.push_back({XR_TYPE_VIEW, nullptr, pose_of(pose), fov_of(eye)});
        }
        return give(all, capacity, count, to);
    });
}

}  // namespace

XrFovf fov_of(int eye)
{
    return eye == 0 ? XrFovf{-outwards, inwards, upwards, -downwards}
                    : XrFovf{-inwards, outwards, upwards, -downwards};
}

// In real time the script's clock begins when it is first asked for.
std::int64_t clock_offset(const Runtime& r)
{
    static const std::int64_t began = monotonic();
    return r.script.real_time ? began - Runtime::zero : 0;
}

void add_frame_functions(Table& to)
{
    to["xrWaitFrame"] = entry(wait);
    to["xrBeginFrame"] = entry(begin);
    to["xrEndFrame"] = entry(end);
    to["xrLocateViews"] = entry(locate);
}

}  // namespace knead::replay
