#include "tests/openxr_replay/runtime.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "xr/check.h"

namespace knead::replay {
namespace {

constexpr int failed_by_wrong_calls = 86;  // what the process ends with

// The results that the state machines refuse with.
XrResult code_of(const Refused& refused)
{
    for (const XrResult code :
         {XR_ERROR_CALL_ORDER_INVALID, XR_ERROR_SESSION_RUNNING, XR_ERROR_SESSION_NOT_RUNNING,
          XR_ERROR_SESSION_NOT_READY, XR_ERROR_SESSION_NOT_STOPPING})
        if (xr::result_name(code) == refused) return code;
    return XR_ERROR_RUNTIME_FAILURE;
}

}  // namespace

Runtime::Runtime()
{
    if (const char* file = std::getenv("KNEAD_REPLAY_SCRIPT")) {
        script = Script::read(file);
    } else {
        script.head.push_back({});
    }
    clock = FrameClock(script.rate, zero);
    if (!script.log.empty()) std::ofstream(script.log, std::ios::trunc);
}

// The library stays loaded as long as the process: this is its end.
Runtime::~Runtime()
{
    for (const auto& [handle, object] : objects)
        refuse("the end of the process", std::string("a leaked ") + object->kind());
    note({{"end", true}, {"frames", frame + 1}, {"wrong", wrong}, {"imported", imported}});
    if (wrong == 0) return;
    std::fprintf(stderr, "replay: %ld wrong calls\n", wrong);
    std::fflush(nullptr);
    std::_Exit(failed_by_wrong_calls);
}

Runtime& runtime()
{
    static Runtime one;
    return one;
}

void Runtime::note(nlohmann::json line)
{
    if (!script.log.empty()) std::ofstream(script.log, std::ios::app) << line.dump() << "\n";
}

void Runtime::refuse(const char* call, const std::string& why)
{
    ++wrong;
    std::fprintf(stderr, "replay: WRONG: %s: %s\n", call, why.c_str());
    note({{"wrong", call}, {"why", why}, {"frame", frame}});
}

std::uint64_t number_of(const void* handle) { return reinterpret_cast<std::uint64_t>(handle); }

void Runtime::remove(std::uint64_t handle, bool leaked)
{
    std::vector<std::uint64_t> children;
    for (const auto& [number, object] : objects)
        if (object->parent == handle) children.push_back(number);
    for (const std::uint64_t child : children) remove(child, true);
    const auto found = objects.find(handle);
    if (found == objects.end()) return;
    if (leaked)
        refuse("a handle destroyed with its parent",
               std::string("a leaked ") + found->second->kind());
    objects.erase(found);
}

SessionObject* Runtime::live_session(XrSession* handle)
{
    for (auto& [number, object] : objects)
        if (auto* session = dynamic_cast<SessionObject*>(object.get())) {
            if (handle) *handle = reinterpret_cast<XrSession>(number);
            return session;
        }
    return nullptr;
}

const std::string& Runtime::text_of(XrPath path)
{
    const std::vector<std::string>& paths = the_instance().paths;
    refuse_if(path == XR_NULL_PATH || path >= paths.size(), XR_ERROR_PATH_INVALID, "not a path");
    return paths[std::size_t(path)];
}

void Runtime::post_states()
{
    XrSession handle = XR_NULL_HANDLE;
    SessionObject* session = live_session(&handle);
    if (!session) return;
    for (; !session->flow.news.empty(); session->flow.news.pop_front()) {
        XrEventDataSessionStateChanged event{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr,
                                             handle, XrSessionState(session->flow.news.front()),
                                             zero};
        post(event);
        note({{"state", int(session->flow.news.front())}, {"frame", frame}});
    }
}

void refuse_if(bool wrong, XrResult code, const std::string& why)
{
    if (wrong) throw Refusal{code, why};
}

void complain_if(bool wrong, const std::string& why)
{
    if (wrong) runtime().refuse(runtime().answering, why);
}

void allowed(const Refused& refused)
{
    if (!refused.empty()) throw Refusal{code_of(refused), refused};
}

void check_struct(const void* given, XrStructureType type,
                  const std::vector<XrStructureType>& known)
{
    refuse_if(!given, XR_ERROR_VALIDATION_FAILURE, "a struct is missing");
    const auto* base = static_cast<const XrBaseInStructure*>(given);
    refuse_if(base->type != type, XR_ERROR_VALIDATION_FAILURE,
              "a struct of type " + std::to_string(int(base->type)) + " instead of " +
                  std::to_string(int(type)));
    for (const XrBaseInStructure* next = base->next; next; next = next->next)
        complain_if(std::find(known.begin(), known.end(), next->type) == known.end(),
                    "a struct of type " + std::to_string(int(next->type)) + " chained to it");
}

void* in_chain(const void* given, XrStructureType type)
{
    auto* at = static_cast<XrBaseOutStructure*>(const_cast<void*>(given));
    while (at && at->type != type) at = at->next;
    return at;
}

InstanceObject& the_instance()
{
    for (auto& [number, object] : runtime().objects)
        if (auto* instance = dynamic_cast<InstanceObject*>(object.get())) return *instance;
    throw Refusal{XR_ERROR_HANDLE_INVALID, "there is no instance"};
}

void check_enabled(const char* extension)
{
    refuse_if(the_instance().enabled.count(extension) == 0, XR_ERROR_VALIDATION_FAILURE,
              std::string(extension) + " is not enabled");
}

InstanceObject& instance_of(XrInstance handle)
{
    InstanceObject& instance = runtime().get<InstanceObject>(handle);
    if (instance.lost) throw Answer{XR_ERROR_INSTANCE_LOST};
    return instance;
}

SessionObject& session_of(XrSession handle)
{
    SessionObject& session = runtime().get<SessionObject>(handle);
    if (the_instance().lost) throw Answer{XR_ERROR_INSTANCE_LOST};
    if (session.lost) throw Answer{XR_ERROR_SESSION_LOST};
    return session;
}

XrPosef pose_of(const Joint<double>& joint)
{
    const auto& [q, p] = joint;
    return {{float(q.x), float(q.y), float(q.z), float(q.w)}, {float(p.x), float(p.y), float(p.z)}};
}

void check_pose(const XrPosef& pose)
{
    const XrQuaternionf& q = pose.orientation;
    const float square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    refuse_if(!(std::abs(square - 1) < 0.02f), XR_ERROR_POSE_INVALID, "not a unit quaternion");
    const XrVector3f& p = pose.position;
    refuse_if(!std::isfinite(p.x + p.y + p.z), XR_ERROR_POSE_INVALID, "not a finite position");
}

// A process that hangs holds no lock of ours: the end of this one needs it.
void hang_if_due(const char* call)
{
    Runtime& r = runtime();
    for (std::size_t i = 0; i < r.script.faults.size(); ++i) {
        const Fault& fault = r.script.faults[i];
        // A call may come before the first frame, or lead to the next one.
        if (fault.kind != FaultKind::hang || fault.call != call || r.frame + 1 < fault.frame ||
            !r.fired.insert(i).second)
            continue;
        r.note({{"hang", call}, {"frame", r.frame}});
        do std::this_thread::sleep_for(std::chrono::duration<double>(std::max(fault.value, 0.1)));
        while (fault.value == 0);
    }
}

void play_faults(SessionObject& session)
{
    Runtime& r = runtime();
    XrSession handle = XR_NULL_HANDLE;
    r.live_session(&handle);
    for (std::size_t i = 0; i < r.script.faults.size(); ++i) {
        const Fault& fault = r.script.faults[i];
        const bool ends = r.frame >= fault.frame + fault.count;
        if (fault.kind == FaultKind::unworn && ends && r.fired.insert(1000 + i).second)
            r.post(XrEventDataUserPresenceChangedEXT{XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT,
                                                     nullptr, handle, XR_TRUE});
        if (fault.kind == FaultKind::hang) continue;  // strikes by itself
        if (r.frame < fault.frame || !r.fired.insert(i).second) continue;
        r.note({{"fault", int(fault.kind)}, {"frame", r.frame}});
        switch (fault.kind) {
            case FaultKind::lose_session:
                session.lost = true;
                break;
            case FaultKind::session_loss:
                session.flow.loss_pending();
                r.post_states();
                break;
            case FaultKind::lose_instance: {
                the_instance().lost = true;
                r.absent = fault.count;
                break;
            }
            case FaultKind::lose_headset:
                session.lost = true;
                r.absent = fault.count, r.headset_absent = true;
                break;
            case FaultKind::take_off:
                session.flow.take_off(fault.count);
                break;
            case FaultKind::unworn:
                r.post(XrEventDataUserPresenceChangedEXT{
                    XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT, nullptr, handle, XR_FALSE});
                break;
            case FaultKind::refresh:
                r.post(XrEventDataDisplayRefreshRateChangedFB{
                    XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB, nullptr,
                    float(r.script.rate), float(fault.value)});
                r.clock.change(fault.value);
                break;
            case FaultKind::recentre:
                r.post(XrEventDataReferenceSpaceChangePending{
                    XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING,
                    nullptr,
                    handle,
                    XR_REFERENCE_SPACE_TYPE_LOCAL,
                    Runtime::zero,
                    XR_FALSE,
                    {}});
                break;
            case FaultKind::steal_context:
                r.context_stolen = true;
                break;
            case FaultKind::exit:
                session.flow.request_exit();
                break;
            default:
                break;  // asked for by frame or time, where they matter
        }
    }
    r.post_states();
}

}  // namespace knead::replay
