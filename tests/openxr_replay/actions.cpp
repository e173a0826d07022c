// Actions of scripted controllers, and a log of their vibrations.
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

// Kinds of controllers, and what each has below a hand.
const std::map<std::string, std::set<std::string>>& profiles()
{
    static const std::set<std::string> simple{"input/select/click", "input/menu/click",
                                              "input/grip/pose", "input/aim/pose", "output/haptic"};
    static const std::set<std::string> touch{"input/trigger/value", "input/squeeze/value",
                                             "input/grip/pose", "input/aim/pose", "output/haptic"};
    static const std::set<std::string> click{"input/trigger/value", "input/squeeze/click",
                                             "input/grip/pose", "input/aim/pose", "output/haptic"};
    static const std::set<std::string> hands{"input/pinch_ext/value", "input/grasp_ext/value",
                                             "input/grip/pose",       "input/aim/pose",
                                             "input/pinch_ext/pose",  "input/poke_ext/pose"};
    static const std::map<std::string, std::set<std::string>> all{
        {"/interaction_profiles/khr/simple_controller", simple},
        {"/interaction_profiles/oculus/touch_controller", touch},
        {"/interaction_profiles/valve/index_controller", touch},
        {"/interaction_profiles/htc/vive_controller", click},
        {"/interaction_profiles/microsoft/motion_controller", click},
        {"/interaction_profiles/ext/hand_interaction_ext", hands},
    };
    return all;
}

XrResult XRAPI_CALL create_set(XrInstance handle, const XrActionSetCreateInfo* info,
                               XrActionSet* to)
{
    return answered("xrCreateActionSet", [&](Runtime& r) {
        instance_of(handle);
        check_struct(info, XR_TYPE_ACTION_SET_CREATE_INFO);
        refuse_if(!is_name(info->actionSetName), XR_ERROR_NAME_INVALID, info->actionSetName);
        refuse_if(info->localizedActionSetName[0] == 0, XR_ERROR_LOCALIZED_NAME_INVALID,
                  "no name for people");
        auto made = std::make_unique<ActionSetObject>();
        made->name = info->actionSetName;
        *to = r.add<XrActionSet>(std::move(made), number_of(handle));
    });
}

XrResult XRAPI_CALL destroy_set(XrActionSet handle)
{
    return answered("xrDestroyActionSet", [&](Runtime& r) {
        r.get<ActionSetObject>(handle);
        // Its actions end with it, by the specification; that is no leak.
        std::vector<std::uint64_t> actions;
        for (const auto& [number, object] : r.objects)
            if (object->parent == number_of(handle)) actions.push_back(number);
        for (const std::uint64_t action : actions) r.remove(action);
        r.remove(number_of(handle));
    });
}

XrResult XRAPI_CALL create(XrActionSet handle, const XrActionCreateInfo* info, XrAction* to)
{
    return answered("xrCreateAction", [&](Runtime& r) {
        r.get<ActionSetObject>(handle);
        check_struct(info, XR_TYPE_ACTION_CREATE_INFO);
        refuse_if(!is_name(info->actionName), XR_ERROR_NAME_INVALID, info->actionName);
        refuse_if(info->localizedActionName[0] == 0, XR_ERROR_LOCALIZED_NAME_INVALID,
                  "no name for people");
        if (const SessionObject* session = r.live_session())
            refuse_if(session->attached.count(number_of(handle)) > 0,
                      XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "its set is attached already");
        auto made = std::make_unique<ActionObject>();
        made->name = info->actionName;
        made->type = info->actionType;
        for (std::uint32_t i = 0; i < info->countSubactionPaths; ++i)
            made->sides.insert(info->subactionPaths[i]);
        *to = r.add<XrAction>(std::move(made), number_of(handle));
    });
}

XrResult XRAPI_CALL destroy(XrAction handle)
{
    return answered("xrDestroyAction", [&](Runtime& r) {
        r.get<ActionObject>(handle);
        r.remove(number_of(handle));
    });
}

XrResult XRAPI_CALL suggest(XrInstance handle, const XrInteractionProfileSuggestedBinding* info)
{
    return answered("xrSuggestInteractionProfileBindings", [&](Runtime& r) {
        InstanceObject& instance = instance_of(handle);
        check_struct(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
        const std::string profile = r.text_of(info->interactionProfile);
        const auto known = profiles().find(profile);
        if (known == profiles().end()) throw Answer{XR_ERROR_PATH_UNSUPPORTED};
        if (profile.ends_with("_ext")) check_enabled("XR_EXT_hand_interaction");
        const SessionObject* session = r.live_session();
        refuse_if(session && session->attached_once, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
                  "suggested after action sets were attached");
        refuse_if(info->countSuggestedBindings == 0, XR_ERROR_VALIDATION_FAILURE, "no bindings");
        std::vector<XrActionSuggestedBinding> all;
        for (std::uint32_t i = 0; i < info->countSuggestedBindings; ++i) {
            const XrActionSuggestedBinding& binding = info->suggestedBindings[i];
            r.get<ActionObject>(binding.action);
            const std::string path = r.text_of(binding.binding);
            const bool left_hand = path.starts_with("/user/hand/left/");
            const std::size_t start = left_hand ? 16 : 17;
            refuse_if((!left_hand && !path.starts_with("/user/hand/right/")) ||
                          known->second.count(path.substr(start)) == 0,
                      XR_ERROR_PATH_UNSUPPORTED, profile + " has no " + path);
            all.push_back(binding);
        }
        instance.suggested[profile] = all;
    });
}

XrResult XRAPI_CALL attach(XrSession handle, const XrSessionActionSetsAttachInfo* info)
{
    return answered("xrAttachSessionActionSets", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
        refuse_if(session.attached_once, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "attached twice");
        session.attached_once = true;
        for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
            r.get<ActionSetObject>(info->actionSets[i]);
            session.attached.insert(number_of(info->actionSets[i]));
        }
    });
}

XrResult XRAPI_CALL sync(XrSession handle, const XrActionsSyncInfo* info)
{
    return answered("xrSyncActions", [&](Runtime&) -> XrResult {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_ACTIONS_SYNC_INFO);
        for (std::uint32_t i = 0; i < info->countActiveActionSets; ++i)
            refuse_if(session.attached.count(number_of(info->activeActionSets[i].actionSet)) == 0,
                      XR_ERROR_ACTIONSET_NOT_ATTACHED, "a set that is not attached");
        session.synced = session.flow.focused();
        return session.synced ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
    });
}

// The controller that an action of a hand is of now; null: none.
const Controller* held_by(XrSession handle, const XrActionStateGetInfo* info, XrActionType type)
{
    Runtime& r = runtime();
    SessionObject& session = session_of(handle);
    check_struct(info, XR_TYPE_ACTION_STATE_GET_INFO);
    const ActionObject& action = r.get<ActionObject>(info->action);
    refuse_if(session.attached.count(action.parent) == 0, XR_ERROR_ACTIONSET_NOT_ATTACHED,
              "its set is not attached");
    refuse_if(action.type != type, XR_ERROR_ACTION_TYPE_MISMATCH, action.name);
    refuse_if(action.sides.count(info->subactionPath) == 0, XR_ERROR_PATH_UNSUPPORTED,
              "a hand that the action was not made for");
    if (!session.synced) return nullptr;
    const Side side = r.text_of(info->subactionPath) == "/user/hand/left" ? left : right;
    return controller_at(r.script, side, r.script_time(session.waited));
}

XrResult XRAPI_CALL float_state(XrSession handle, const XrActionStateGetInfo* info,
                                XrActionStateFloat* to)
{
    return answered("xrGetActionStateFloat", [&](Runtime& r) {
        check_struct(to, XR_TYPE_ACTION_STATE_FLOAT);
        const Controller* held = held_by(handle, info, XR_ACTION_TYPE_FLOAT_INPUT);
        to->isActive = held != nullptr;
        const bool grasps = r.get<ActionObject>(info->action).name == "grasp";
        to->currentState = held ? float(grasps ? held->squeeze : held->trigger) : 0;
        to->changedSinceLastSync = XR_FALSE;
        to->lastChangeTime = 0;
    });
}

XrResult XRAPI_CALL pose_state(XrSession handle, const XrActionStateGetInfo* info,
                               XrActionStatePose* to)
{
    return answered("xrGetActionStatePose", [&](Runtime&) {
        check_struct(to, XR_TYPE_ACTION_STATE_POSE);
        to->isActive = held_by(handle, info, XR_ACTION_TYPE_POSE_INPUT) != nullptr;
    });
}

XrResult XRAPI_CALL vibrate(XrSession handle, const XrHapticActionInfo* info,
                            const XrHapticBaseHeader* how)
{
    return answered("xrApplyHapticFeedback", [&](Runtime& r) -> XrResult {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_HAPTIC_ACTION_INFO);
        check_struct(how, XR_TYPE_HAPTIC_VIBRATION);
        const ActionObject& action = r.get<ActionObject>(info->action);
        refuse_if(action.type != XR_ACTION_TYPE_VIBRATION_OUTPUT, XR_ERROR_ACTION_TYPE_MISMATCH,
                  action.name);
        const auto& shake = *reinterpret_cast<const XrHapticVibration*>(how);
        refuse_if(!(shake.amplitude >= 0 && shake.amplitude <= 1), XR_ERROR_VALIDATION_FAILURE,
                  "an amplitude beyond [0, 1]");
        r.note({{"haptic", r.text_of(info->subactionPath)},
                {"strength", shake.amplitude},
                {"frame", r.frame}});
        return session.flow.focused() ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
    });
}

XrResult XRAPI_CALL stop(XrSession handle, const XrHapticActionInfo* info)
{
    return answered("xrStopHapticFeedback", [&](Runtime&) {
        session_of(handle);
        check_struct(info, XR_TYPE_HAPTIC_ACTION_INFO);
    });
}

XrResult XRAPI_CALL profile_of(XrSession handle, XrPath, XrInteractionProfileState* to)
{
    return answered("xrGetCurrentInteractionProfile", [&](Runtime&) {
        session_of(handle);
        check_struct(to, XR_TYPE_INTERACTION_PROFILE_STATE);
        to->interactionProfile = XR_NULL_PATH;
    });
}

}  // namespace

void add_action_functions(Table& to)
{
    to["xrCreateActionSet"] = entry(create_set);
    to["xrDestroyActionSet"] = entry(destroy_set);
    to["xrCreateAction"] = entry(create);
    to["xrDestroyAction"] = entry(destroy);
    to["xrSuggestInteractionProfileBindings"] = entry(suggest);
    to["xrAttachSessionActionSets"] = entry(attach);
    to["xrSyncActions"] = entry(sync);
    to["xrGetActionStateFloat"] = entry(float_state);
    to["xrGetActionStatePose"] = entry(pose_state);
    to["xrApplyHapticFeedback"] = entry(vibrate);
    to["xrStopHapticFeedback"] = entry(stop);
    to["xrGetCurrentInteractionProfile"] = entry(profile_of);
}

}  // namespace knead::replay
