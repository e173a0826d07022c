// The replay runtime: its objects, its one lock, and what every function of it goes through.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/openxr_replay/clock.h"
#include "tests/openxr_replay/flow.h"
#include "tests/openxr_replay/gl_guard.h"
#include "tests/openxr_replay/imported.h"
#include "tests/openxr_replay/script.h"
#include "xr/openxr.h"

namespace knead::replay {

// A call that breaks the rules: it answers `code`, and is counted and told.
struct Refusal {
    XrResult code;
    std::string why;
};
// An answer that is no success and breaks no rule: a loss, or what is not offered.
struct Answer {
    XrResult code;
};

struct Object {
    std::uint64_t parent = 0;  // handle; 0: none
    virtual ~Object() = default;
    virtual const char* kind() const = 0;
};

struct InstanceObject : Object {
    const char* kind() const override { return "instance"; }
    std::set<std::string> enabled;
    bool asked_system = false, asked_gl = false;
    bool lost = false;
    std::map<std::string, std::vector<XrActionSuggestedBinding>> suggested;  // by profile
    std::vector<std::string> paths{""};                                      // by XrPath
};
// An action of one top level path, or of any, as the last xrSyncActions found it.
struct ActionState {
    bool active = false, changed = false;
    float value = 0;
    XrTime when = 0;  // it changed
};
struct SessionObject : Object {
    const char* kind() const override { return "session"; }
    std::unique_ptr<GlGuardSource> gl;
    SessionFlow flow;
    FrameOrder order;
    std::set<std::uint64_t> attached;
    bool attached_once = false, lost = false;
    std::map<std::pair<std::uint64_t, XrPath>, ActionState> states;  // by action
    std::map<std::string, std::string> profiles;  // of controllers, by top level path
    XrTime waited = 0, begun = 0;                 // the display times
    int begun_frame = 0;
    bool will_render = true, begun_to_render = true;  // the frame waited for, the one begun
};
struct SpaceObject : Object {
    const char* kind() const override { return "space"; }
    XrReferenceSpaceType reference = XR_REFERENCE_SPACE_TYPE_LOCAL;
    XrAction action = XR_NULL_HANDLE;  // of an action space
    XrPath of = XR_NULL_PATH;          // the action's, of an action space; null: any
    XrPosef pose{};
};
constexpr double floor_below = 1.2;  // the origin of LOCAL above that of STAGE [m]
// LOCAL or STAGE without a pose of its own.
bool is_plain(const SpaceObject& space);
// How much higher a place of LOCAL is in a plain space [m].
inline double higher_in(const SpaceObject& space)
{
    return space.reference == XR_REFERENCE_SPACE_TYPE_STAGE ? floor_below : 0;
}
struct SwapchainObject : Object {
    explicit SwapchainObject(int images) : order(images) {}
    const char* kind() const override { return "swapchain"; }
    ImageOrder order;
    std::vector<unsigned> textures;
    std::vector<void*> drawn;  // GLsync of each, behind its last drawing; null: none
    ImportedMemory memory;     // of the textures, where they can be of such
    int width = 0, height = 0;
    std::uint32_t layers = 1;
    bool depth = false, once = false;  // once: of static images
};
struct ActionSetObject : Object {
    const char* kind() const override { return "action set"; }
    std::string name, shown;
    bool attached = false;  // once, to any session
};
struct ActionObject : Object {
    const char* kind() const override { return "action"; }
    std::string name, shown;
    XrActionType type{};
    std::set<XrPath> sides;
};
struct HandObject : Object {
    const char* kind() const override { return "hand tracker"; }
    Side side = left;
    bool sources = false;
};

struct Runtime {
    Runtime();
    ~Runtime();

    Script script;
    std::mutex lock;
    std::condition_variable frame_begun;
    FrameClock clock{90, 1'000'000'000};
    static constexpr XrTime zero = 1'000'000'000;  // of the script [ns]
    std::map<std::uint64_t, std::unique_ptr<Object>> objects;
    std::uint64_t next_handle = 0x1000;
    std::deque<XrEventDataBuffer> events;
    int frame = -1;  // of the runtime, over all sessions
    int absent = 0;  // tries that will find no runtime, or no headset
    bool headset_absent = false;
    bool context_stolen = false;
    int imported = 0;             // textures, of memory that is unmapped with them
    std::set<std::size_t> fired;  // faults that have begun
    long wrong = 0;
    const char* answering = "";  // the call

    double script_time(XrTime at) const { return 1e-9 * double(at - zero); }
    // A line of the log, and of standard error where it is a wrong call.
    void note(nlohmann::json line);
    void refuse(const char* call, const std::string& why);
    template <class T, class Handle>
    T& get(Handle handle);
    template <class Handle>
    Handle add(std::unique_ptr<Object> object, std::uint64_t parent);
    // Destroys it and all that hangs on it; what hung on it was leaked.
    void remove(std::uint64_t handle, bool leaked = false);
    template <class Event>
    void post(const Event& event)
    {
        XrEventDataBuffer buffer{};
        static_assert(sizeof(Event) <= sizeof buffer);
        std::memcpy(static_cast<void*>(&buffer), &event, sizeof event);
        events.push_back(buffer);
    }
    SessionObject* live_session(XrSession* handle = nullptr);
    const std::string& text_of(XrPath path);
    void post_states();
};
Runtime& runtime();

std::uint64_t number_of(const void* handle);

template <class T, class Handle>
T& Runtime::get(Handle handle)
{
    const auto found = objects.find(number_of(handle));
    T* object = found == objects.end() ? nullptr : dynamic_cast<T*>(found->second.get());
    if (!object) throw Refusal{XR_ERROR_HANDLE_INVALID, "not a live handle of its kind"};
    return *object;
}

template <class Handle>
Handle Runtime::add(std::unique_ptr<Object> object, std::uint64_t parent)
{
    object->parent = parent;
    const std::uint64_t number = next_handle += 0x10;
    objects.emplace(number, std::move(object));
    return reinterpret_cast<Handle>(number);
}

void refuse_if(bool wrong, XrResult code, const std::string& why);
// Counts and tells what breaks a rule and is to be answered as if it had not.
void complain_if(bool wrong, const std::string& why);
// Refuses what a state machine has refused.
void allowed(const Refused& refused);
// Refuses a struct that is missing or has another type. A `next` that is not among `known` is
// wrong, too, but a runtime has to overlook it.
void check_struct(const void* given, XrStructureType type,
                  const std::vector<XrStructureType>& known = {});
// The struct of that type in the chain, or null.
void* in_chain(const void* given, XrStructureType type);
void check_enabled(const char* extension);
InstanceObject& instance_of(XrInstance handle);
// Of a live session that is not lost; throws Answer otherwise.
SessionObject& session_of(XrSession handle);
InstanceObject& the_instance();
XrPosef pose_of(const Joint<double>& joint);
// A place of LOCAL as it is in a space at a time of the script; false where that is not known.
bool in_space(const SpaceObject& space, double time, Joint<double>& place);
void check_pose(const XrPosef& pose);

// Does not return for as long as a fault of the script says of this call.
void hang_if_due(const char* call);

// Does what a function does, under the lock, and turns what it throws into its answer.
template <class Body>
XrResult answered(const char* call, const Body& body)
{
    Runtime& r = runtime();
    hang_if_due(call);
    const std::lock_guard held(r.lock);
    r.answering = call;
    try {
        if constexpr (std::is_void_v<decltype(body(r))>) {
            body(r);
            return XR_SUCCESS;
        } else {
            return body(r);
        }
    } catch (const Refusal& e) {
        r.refuse(call, e.why);
        return e.code;
    } catch (const Answer& e) {
        return e.code;
    } catch (const std::exception& e) {
        r.refuse(call, e.what());
        return XR_ERROR_RUNTIME_FAILURE;
    }
}

// The two-call idiom.
template <class T>
XrResult give(const std::vector<T>& all, std::uint32_t capacity, std::uint32_t* count, T* to)
{
    refuse_if(!count, XR_ERROR_VALIDATION_FAILURE, "no place for the count");
    *count = std::uint32_t(all.size());
    if (capacity == 0) return XR_SUCCESS;
    refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the list");
    refuse_if(capacity < all.size(), XR_ERROR_SIZE_INSUFFICIENT, "too small a place for the list");
    for (std::size_t i = 0; i < all.size(); ++i) {
        T one = all[i];
        if constexpr (requires { one.next; }) one.next = to[i].next;  // the chain stays
        to[i] = one;
    }
    return XR_SUCCESS;
}

// Tables of the functions, one a file.
using Table = std::map<std::string, PFN_xrVoidFunction>;
template <class Function>
PFN_xrVoidFunction entry(Function* function)
{
    return reinterpret_cast<PFN_xrVoidFunction>(function);
}
void add_instance_functions(Table& to);
void add_session_functions(Table& to);
void add_frame_functions(Table& to);
void add_swapchain_functions(Table& to);
void add_space_functions(Table& to);
void add_action_functions(Table& to);
void add_state_functions(Table& to);
void add_name_functions(Table& to);
void add_hand_functions(Table& to);
void add_extension_functions(Table& to);

// What is offered, the script's `without` left out.
std::vector<XrExtensionProperties> offered();
// The extension that a function belongs to; "": to none.
std::string extension_of(const std::string& function);

// Starts the faults that are due at this frame.
void play_faults(SessionObject& session);
void check_layers(const SessionObject& session, const XrFrameEndInfo& end);
void log_layers(SessionObject& session, const XrFrameEndInfo& end);
XrFovf fov_of(int eye);
// What CLOCK_MONOTONIC says more than the runtime's clock [ns]; 0 in virtual time.
std::int64_t clock_offset(const Runtime& r);
void check_view_type(XrViewConfigurationType type);
constexpr XrSystemId the_system = 7;

}  // namespace knead::replay
