#include "xr/actions.h"

#include <cstdio>

#include "xr/hands.h"

namespace knead::xr {
namespace {

// Interaction profiles: component paths of trigger, grasp, haptic output, and of the two buttons of
// the left and the right hand; "": none.
struct Profile {
    const char *name, *trigger, *grasp, *motor;
    const char *lower[side_count], *upper[side_count];
};
constexpr const char* motor = "output/haptic";
constexpr Profile profiles[] = {
    {"/interaction_profiles/khr/simple_controller",
     "input/select/click",
     "",
     motor,
     {"input/menu/click", "input/menu/click"},
     {"", ""}},
    {"/interaction_profiles/oculus/touch_controller",
     "input/trigger/value",
     "input/squeeze/value",
     motor,
     {"input/x/click", "input/a/click"},
     {"input/y/click", "input/b/click"}},
    {"/interaction_profiles/valve/index_controller",
     "input/trigger/value",
     "input/squeeze/value",
     motor,
     {"input/a/click", "input/a/click"},
     {"input/b/click", "input/b/click"}},
    {"/interaction_profiles/htc/vive_controller",
     "input/trigger/value",
     "input/squeeze/click",
     motor,
     {"input/menu/click", "input/menu/click"},
     {"input/trackpad/click", "input/trackpad/click"}},
    {"/interaction_profiles/microsoft/motion_controller",
     "input/trigger/value",
     "input/squeeze/click",
     motor,
     {"input/menu/click", "input/menu/click"},
     {"input/trackpad/click", "input/trackpad/click"}},
    {"/interaction_profiles/ext/hand_interaction_ext",
     "input/pinch_ext/value",
     "input/grasp_ext/value",
     "",
     {"", ""},
     {"", ""}},
};
constexpr const char* sides[side_count] = {"/user/hand/left", "/user/hand/right"};
constexpr XrDuration buzz_time = 20'000'000;  // [ns]

bool is_lost(XrResult result)
{
    return result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST;
}

}  // namespace

XrAction Actions::action(XrActionType type, const char* name, const char* shown)
{
    auto about = typed<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    about.actionType = type;
    std::snprintf(about.actionName, sizeof about.actionName, "%s", name);
    std::snprintf(about.localizedActionName, sizeof about.localizedActionName, "%s", shown);
    about.countSubactionPaths = side_count;
    about.subactionPaths = hand;
    XrAction made = XR_NULL_HANDLE;
    instance.api.create_action(set, &about, &made);
    return made;
}

Actions::Actions(Instance& of, XrSession in) : instance(of), session(in)
{
    for (int side = 0; side < side_count; ++side) hand[side] = instance.path(sides[side]);
    auto about = typed<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::snprintf(about.actionSetName, sizeof about.actionSetName, "clay");
    std::snprintf(about.localizedActionSetName, sizeof about.localizedActionSetName, "Clay");
    instance.api.create_action_set(instance.api.instance, &about, &set);
    try {
        grip = action(XR_ACTION_TYPE_POSE_INPUT, "grip", "Hand");
        aim = action(XR_ACTION_TYPE_POSE_INPUT, "aim", "Point");
        trigger = action(XR_ACTION_TYPE_FLOAT_INPUT, "pinch", "Pinch");
        grasp = action(XR_ACTION_TYPE_FLOAT_INPUT, "grasp", "Grasp");
        lower = action(XR_ACTION_TYPE_FLOAT_INPUT, "lower", "Undo; choose and move");
        upper = action(XR_ACTION_TYPE_FLOAT_INPUT, "upper", "Redo; lay clay");
        buzz = action(XR_ACTION_TYPE_VIBRATION_OUTPUT, "touch", "Touch");
        suggest();
        auto attach = typed<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
        attach.countActionSets = 1;
        attach.actionSets = &set;
        instance.api.attach_action_sets(session, &attach);
        for (int side = 0; side < side_count; ++side) {
            auto pose_of = typed<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
            pose_of.action = grip;
            pose_of.subactionPath = hand[side];
            pose_of.poseInActionSpace.orientation.w = 1;
            instance.api.create_action_space(session, &pose_of, &grips[side]);
            pose_of.action = aim;
            instance.api.create_action_space(session, &pose_of, &aims[side]);
        }
    } catch (...) {
        instance.api.destroy_action_set.raw(set);
        throw;
    }
}

Actions::~Actions()
{
    for (const auto& spaces : {grips, aims})
        for (int side = 0; side < side_count; ++side)
            if (spaces[side]) instance.api.destroy_space.raw(spaces[side]);
    instance.api.destroy_action_set.raw(set);
}

// Suggests bindings for each profile; a profile that the runtime does not support is skipped.
void Actions::suggest()
{
    for (const Profile& profile : profiles) {
        const bool of_hands = profile.motor[0] == 0;
        if (of_hands && !instance.has[hand_interaction]) continue;
        std::vector<XrActionSuggestedBinding> all;
        for (int side = 0; side < side_count; ++side) {
            const auto bind = [&](XrAction to, const char* what) {
                if (*what)
                    all.push_back(
                        {to, instance.path((std::string(sides[side]) + "/" + what).c_str())});
            };
            bind(grip, "input/grip/pose");
            bind(aim, "input/aim/pose");
            bind(lower, profile.lower[side]);
            bind(upper, profile.upper[side]);
            bind(trigger, profile.trigger);
            bind(grasp, profile.grasp);
            bind(buzz, profile.motor);
        }
        auto about = typed<XrInteractionProfileSuggestedBinding>(
            XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
        about.interactionProfile = instance.path(profile.name);
        about.countSuggestedBindings = std::uint32_t(all.size());
        about.suggestedBindings = all.data();
        const XrResult result = instance.api.suggest_bindings.raw(instance.api.instance, &about);
        if (is_lost(result)) throw XrFailure("xrSuggestInteractionProfileBindings", result);
    }
}

void Actions::sync()
{
    const XrActiveActionSet active{set, XR_NULL_PATH};
    auto about = typed<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
    about.countActiveActionSets = 1;
    about.activeActionSets = &active;
    instance.api.sync_actions(session, &about);
}

float Actions::value(XrAction of, Side side)
{
    auto about = typed<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    about.action = of;
    about.subactionPath = hand[side];
    auto state = typed<XrActionStateFloat>(XR_TYPE_ACTION_STATE_FLOAT);
    instance.api.float_state(session, &about, &state);
    return state.isActive ? state.currentState : 0;
}

std::optional<Joint<float>> Actions::pose(XrAction of, const XrSpace (&spaces)[side_count],
                                          Side side, XrSpace base, XrTime time)
{
    auto about = typed<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    about.action = of;
    about.subactionPath = hand[side];
    auto state = typed<XrActionStatePose>(XR_TYPE_ACTION_STATE_POSE);
    instance.api.pose_state(session, &about, &state);
    if (!state.isActive) return {};
    auto at = typed<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    instance.api.locate_space(spaces[side], base, time, &at);
    constexpr XrSpaceLocationFlags both =
        XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    if ((at.locationFlags & both) != both) return {};
    return joint_of(at.pose);
}

HeldButtons Actions::held(Side side, XrSpace base, XrTime time)
{
    HeldButtons all;
    const auto at = pose(grip, grips, side, base, time);
    if (!at) return all;
    all.active = true;
    all.grip = *at;
    all.aim = pose(aim, aims, side, base, time);
    all.trigger = value(trigger, side);
    all.grasp = value(grasp, side);
    all.lower = value(lower, side) > 0.5f;
    all.upper = value(upper, side) > 0.5f;
    return all;
}

void Actions::vibrate(Side side, float strength)
{
    auto about = typed<XrHapticActionInfo>(XR_TYPE_HAPTIC_ACTION_INFO);
    about.action = buzz;
    about.subactionPath = hand[side];
    auto how = typed<XrHapticVibration>(XR_TYPE_HAPTIC_VIBRATION);
    how.duration = buzz_time;
    how.frequency = XR_FREQUENCY_UNSPECIFIED;
    how.amplitude = clamp(strength, 0.f, 1.f);
    instance.api.vibrate(session, &about, reinterpret_cast<const XrHapticBaseHeader*>(&how));
}

}  // namespace knead::xr
