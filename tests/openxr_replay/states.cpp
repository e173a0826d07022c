// What actions say: the state of scripted controllers at the last xrSyncActions, and their motors.
#include <algorithm>

#include "tests/openxr_replay/actions.h"
#include "tests/openxr_replay/profiles.h"

namespace knead::replay {
namespace {

constexpr const char* hand_users[side_count] = {"/user/hand/left", "/user/hand/right"};

const Controller* controller_of(const std::string& user, XrTime time)
{
    const Runtime& r = runtime();
    for (const Side side : {left, right})
        if (user == hand_users[side]) return controller_at(r.script, side, r.script_time(time));
    return nullptr;
}

// A scripted controller is of the first kind that bindings were suggested for.
void find_profiles(SessionObject& session, XrSession handle)
{
    Runtime& r = runtime();
    const auto& suggested = the_instance().suggested;
    std::map<std::string, std::string> found;
    for (const char* user : hand_users) {
        if (!controller_of(user, session.waited)) continue;
        for (const Profile& profile : profiles())
            if (profile.of_hands() && suggested.count(profile.name) > 0) {
                found[user] = profile.name;
                break;
            }
    }
    if (found != session.profiles)
        r.post(XrEventDataInteractionProfileChanged{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED,
                                                    nullptr, handle});
    session.profiles = found;
}

// From 0 to 1; what is not scripted is 0. A click is none or all.
float value_of(const Controller& held, const std::string& source)
{
    const auto has = [&](const char* name) { return source.find(name) != source.npos; };
    double value = 0;
    if (has("/trigger") || has("/select") || has("/pinch_ext")) value = held.trigger;
    if (has("/squeeze") || has("/grasp_ext")) value = held.squeeze;
    if (has("/a/") || has("/x/") || has("/menu/")) value = held.lower;
    if (has("/b/") || has("/y/") || has("/trackpad/click")) value = held.upper;
    if (source.ends_with("/click")) value = value > 0.5 ? 1 : 0;
    return float(value);
}

// Of the sources below one top level path, or any, the one that is furthest from rest.
void find_state(const SessionObject& session, std::uint64_t action, XrPath of, ActionState& state)
{
    const auto handle = reinterpret_cast<XrAction>(action);
    const ActionState before = state;
    state = {};
    const std::string user = of == XR_NULL_PATH ? "" : runtime().text_of(of);
    for (const std::string& source : sources_of(session, handle, user)) {
        const Controller* held = controller_of(user_of(source), session.waited);
        if (!held) continue;
        state.active = true;
        state.value = std::max(state.value, value_of(*held, source));
    }
    state.changed = before.active && state.active && state.value != before.value;
    state.when = state.changed ? session.waited : state.active ? before.when : 0;
}

// Whether an active set of the call, by itself or below that top level path, has the action.
bool is_active(const XrActionsSyncInfo& info, const ActionObject& action, XrPath of)
{
    return std::any_of(info.activeActionSets, info.activeActionSets + info.countActiveActionSets,
                       [&](const XrActiveActionSet& set) {
                           return number_of(set.actionSet) == action.parent &&
                                  (set.subactionPath == XR_NULL_PATH || of == XR_NULL_PATH ||
                                   set.subactionPath == of);
                       });
}

void find_states(SessionObject& session, const XrActionsSyncInfo& info)
{
    for (const auto& [number, object] : runtime().objects) {
        const auto* action = dynamic_cast<const ActionObject*>(object.get());
        if (!action) continue;
        std::set<XrPath> all = action->sides;
        all.insert(XR_NULL_PATH);
        for (const XrPath of : all) {
            ActionState& state = session.states[{number, of}];
            if (is_active(info, *action, of))
                find_state(session, number, of, state);
            else
                state = {};
        }
    }
}

void check_active_set(const SessionObject& session, const XrActiveActionSet& set)
{
    Runtime& r = runtime();
    r.get<ActionSetObject>(set.actionSet);
    refuse_if(session.attached.count(number_of(set.actionSet)) == 0,
              XR_ERROR_ACTIONSET_NOT_ATTACHED, "a set that is not attached");
    if (set.subactionPath == XR_NULL_PATH) return;
    r.text_of(set.subactionPath);
    const bool known = std::any_of(r.objects.begin(), r.objects.end(), [&](const auto& one) {
        const auto* action = dynamic_cast<const ActionObject*>(one.second.get());
        return action && action->parent == number_of(set.actionSet) &&
               action->sides.count(set.subactionPath) > 0;
    });
    refuse_if(!known, XR_ERROR_PATH_UNSUPPORTED, "a hand that no action of the set was made for");
}

XrResult XRAPI_CALL sync(XrSession handle, const XrActionsSyncInfo* info)
{
    return answered("xrSyncActions", [&](Runtime&) -> XrResult {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_ACTIONS_SYNC_INFO);
        refuse_if(info->countActiveActionSets > 0 && !info->activeActionSets,
                  XR_ERROR_VALIDATION_FAILURE, "a list is missing");
        for (std::uint32_t i = 0; i < info->countActiveActionSets; ++i)
            check_active_set(session, info->activeActionSets[i]);
        if (!session.flow.focused()) {
            session.states.clear();
            return XR_SESSION_NOT_FOCUSED;
        }
        find_profiles(session, handle);
        find_states(session, *info);
        return XR_SUCCESS;
    });
}

ActionState state_of(XrSession handle, const XrActionStateGetInfo* info, XrActionType type)
{
    const SessionObject& session = session_of(handle);
    check_struct(info, XR_TYPE_ACTION_STATE_GET_INFO);
    const ActionObject& action = attached_action(session, info->action);
    refuse_if(action.type != type, XR_ERROR_ACTION_TYPE_MISMATCH, action.name);
    check_subaction(action, info->subactionPath);
    const auto found = session.states.find({number_of(info->action), info->subactionPath});
    return found == session.states.end() ? ActionState{} : found->second;
}

template <class State, class Value>
void fill(State& to, const ActionState& from, Value value)
{
    to.currentState = value;
    to.changedSinceLastSync = from.changed;
    to.lastChangeTime = from.when;
    to.isActive = from.active;
}

XrResult XRAPI_CALL bool_state(XrSession handle, const XrActionStateGetInfo* info,
                               XrActionStateBoolean* to)
{
    return answered("xrGetActionStateBoolean", [&](Runtime&) {
        check_struct(to, XR_TYPE_ACTION_STATE_BOOLEAN);
        const ActionState state = state_of(handle, info, XR_ACTION_TYPE_BOOLEAN_INPUT);
        fill(*to, state, XrBool32(state.value > 0.5f));
    });
}

XrResult XRAPI_CALL float_state(XrSession handle, const XrActionStateGetInfo* info,
                                XrActionStateFloat* to)
{
    return answered("xrGetActionStateFloat", [&](Runtime&) {
        check_struct(to, XR_TYPE_ACTION_STATE_FLOAT);
        const ActionState state = state_of(handle, info, XR_ACTION_TYPE_FLOAT_INPUT);
        fill(*to, state, state.value);
    });
}

XrResult XRAPI_CALL vector_state(XrSession handle, const XrActionStateGetInfo* info,
                                 XrActionStateVector2f* to)
{
    return answered("xrGetActionStateVector2f", [&](Runtime&) {
        check_struct(to, XR_TYPE_ACTION_STATE_VECTOR2F);
        ActionState state = state_of(handle, info, XR_ACTION_TYPE_VECTOR2F_INPUT);
        state.changed = false, state.when = 0;
        fill(*to, state, XrVector2f{0, 0});  // sticks and pads are not scripted
    });
}

XrResult XRAPI_CALL pose_state(XrSession handle, const XrActionStateGetInfo* info,
                               XrActionStatePose* to)
{
    return answered("xrGetActionStatePose", [&](Runtime&) {
        check_struct(to, XR_TYPE_ACTION_STATE_POSE);
        to->isActive = state_of(handle, info, XR_ACTION_TYPE_POSE_INPUT).active;
    });
}

// Refuses what has no motor.
void check_motor(const SessionObject& session, const XrHapticActionInfo* info)
{
    check_struct(info, XR_TYPE_HAPTIC_ACTION_INFO);
    const ActionObject& action = attached_action(session, info->action);
    refuse_if(action.type != XR_ACTION_TYPE_VIBRATION_OUTPUT, XR_ERROR_ACTION_TYPE_MISMATCH,
              action.name);
    check_subaction(action, info->subactionPath);
}

XrResult XRAPI_CALL vibrate(XrSession handle, const XrHapticActionInfo* info,
                            const XrHapticBaseHeader* how)
{
    return answered("xrApplyHapticFeedback", [&](Runtime& r) -> XrResult {
        const SessionObject& session = session_of(handle);
        check_motor(session, info);
        check_struct(how, XR_TYPE_HAPTIC_VIBRATION);
        const auto& shake = *reinterpret_cast<const XrHapticVibration*>(how);
        refuse_if(!(shake.amplitude >= 0 && shake.amplitude <= 1), XR_ERROR_VALIDATION_FAILURE,
                  "an amplitude beyond [0, 1]");
        r.note({{"haptic", info->subactionPath ? r.text_of(info->subactionPath) : "any"},
                {"strength", shake.amplitude},
                {"frame", r.frame}});
        return session.flow.focused() ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
    });
}

XrResult XRAPI_CALL stop(XrSession handle, const XrHapticActionInfo* info)
{
    return answered("xrStopHapticFeedback", [&](Runtime&) -> XrResult {
        const SessionObject& session = session_of(handle);
        check_motor(session, info);
        return session.flow.focused() ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
    });
}

XrResult XRAPI_CALL profile_of(XrSession handle, XrPath of, XrInteractionProfileState* to)
{
    return answered("xrGetCurrentInteractionProfile", [&](Runtime& r) {
        const SessionObject& session = session_of(handle);
        check_struct(to, XR_TYPE_INTERACTION_PROFILE_STATE);
        const std::string& user = r.text_of(of);
        refuse_if(user_of(user) != user, XR_ERROR_PATH_UNSUPPORTED, "not a user: " + user);
        refuse_if(!session.attached_once, XR_ERROR_ACTIONSET_NOT_ATTACHED, "nothing is attached");
        const auto found = session.profiles.find(user);
        const std::vector<std::string>& paths = the_instance().paths;
        to->interactionProfile =
            found == session.profiles.end()
                ? XR_NULL_PATH
                : XrPath(std::find(paths.begin(), paths.end(), found->second) - paths.begin());
    });
}

}  // namespace

void check_subaction(const ActionObject& action, XrPath of)
{
    if (of == XR_NULL_PATH) return;
    runtime().text_of(of);
    refuse_if(action.sides.count(of) == 0, XR_ERROR_PATH_UNSUPPORTED,
              "a hand that the action was not made for");
}

const ActionObject& attached_action(const SessionObject& session, XrAction handle)
{
    const ActionObject& action = runtime().get<ActionObject>(handle);
    refuse_if(session.attached.count(action.parent) == 0, XR_ERROR_ACTIONSET_NOT_ATTACHED,
              "its set is not attached");
    return action;
}

std::vector<std::string> sources_of(const SessionObject& session, XrAction handle,
                                    const std::string& user)
{
    std::set<std::string> all;
    for (const auto& [of, profile] : session.profiles) {
        if (!user.empty() && of != user) continue;
        for (const XrActionSuggestedBinding& binding : the_instance().suggested.at(profile)) {
            const std::string& path = runtime().text_of(binding.binding);
            if (binding.action == handle && user_of(path) == of) all.insert(path);
        }
    }
    return {all.begin(), all.end()};
}

const Controller* pointed_by(const SpaceObject& space, double time)
{
    const Runtime& r = runtime();
    const auto* session = dynamic_cast<const SessionObject*>(r.objects.at(space.parent).get());
    const auto found = session->states.find({number_of(space.action), space.of});
    if (found == session->states.end() || !found->second.active) return nullptr;
    for (const Side side : {left, right}) {
        const bool bound = !sources_of(*session, space.action, hand_users[side]).empty();
        const bool meant =
            space.of == XR_NULL_PATH || runtime().text_of(space.of) == hand_users[side];
        const Controller* held = controller_at(r.script, side, time);
        if (bound && meant && held) return held;
    }
    return nullptr;
}

void add_state_functions(Table& to)
{
    to["xrSyncActions"] = entry(sync);
    to["xrGetActionStateBoolean"] = entry(bool_state);
    to["xrGetActionStateFloat"] = entry(float_state);
    to["xrGetActionStateVector2f"] = entry(vector_state);
    to["xrGetActionStatePose"] = entry(pose_state);
    to["xrApplyHapticFeedback"] = entry(vibrate);
    to["xrStopHapticFeedback"] = entry(stop);
    to["xrGetCurrentInteractionProfile"] = entry(profile_of);
}

}  // namespace knead::replay
