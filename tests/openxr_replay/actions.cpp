// Actions: their sets, what they are bound to, and what that is called.
#include "tests/openxr_replay/actions.h"

#include <algorithm>

#include "tests/openxr_replay/profiles.h"

namespace knead::replay {
namespace {

void check_names(const std::string& name, const std::string& shown)
{
    refuse_if(name.empty(), XR_ERROR_NAME_INVALID, "no name");
    refuse_if(!is_name(name), XR_ERROR_PATH_FORMAT_INVALID, name);
    refuse_if(shown.empty(), XR_ERROR_LOCALIZED_NAME_INVALID, "no name for people");
}

// Refuses names that another object of its kind has, below the same parent.
template <class Kind>
void check_other_names(const std::string& name, const std::string& shown, std::uint64_t parent)
{
    for (const auto& [number, object] : runtime().objects) {
        const auto* other = dynamic_cast<const Kind*>(object.get());
        if (!other || other->parent != parent) continue;
        refuse_if(other->name == name, XR_ERROR_NAME_DUPLICATED, name);
        refuse_if(other->shown == shown, XR_ERROR_LOCALIZED_NAME_DUPLICATED, shown);
    }
}

XrResult XRAPI_CALL create_set(XrInstance handle, const XrActionSetCreateInfo* info,
                               XrActionSet* to)
{
    return answered("xrCreateActionSet", [&](Runtime& r) {
        instance_of(handle);
        check_struct(info, XR_TYPE_ACTION_SET_CREATE_INFO);
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the handle");
        auto made = std::make_unique<ActionSetObject>();
        made->name = info->actionSetName, made->shown = info->localizedActionSetName;
        check_names(made->name, made->shown);
        check_other_names<ActionSetObject>(made->name, made->shown, number_of(handle));
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

void check_type(XrActionType type)
{
    for (const XrActionType known :
         {XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT, XR_ACTION_TYPE_VECTOR2F_INPUT,
          XR_ACTION_TYPE_POSE_INPUT, XR_ACTION_TYPE_VIBRATION_OUTPUT})
        if (type == known) return;
    throw Refusal{XR_ERROR_VALIDATION_FAILURE, "not a type of actions"};
}

XrResult XRAPI_CALL create(XrActionSet handle, const XrActionCreateInfo* info, XrAction* to)
{
    return answered("xrCreateAction", [&](Runtime& r) {
        const ActionSetObject& set = r.get<ActionSetObject>(handle);
        check_struct(info, XR_TYPE_ACTION_CREATE_INFO);
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the handle");
        refuse_if(set.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "its set was attached");
        auto made = std::make_unique<ActionObject>();
        made->name = info->actionName, made->shown = info->localizedActionName;
        made->type = info->actionType;
        check_names(made->name, made->shown);
        check_other_names<ActionObject>(made->name, made->shown, number_of(handle));
        check_type(made->type);
        for (std::uint32_t i = 0; i < info->countSubactionPaths; ++i) {
            const std::string& path = r.text_of(info->subactionPaths[i]);
            refuse_if(user_of(path) != path, XR_ERROR_PATH_UNSUPPORTED, "not a user: " + path);
            refuse_if(!made->sides.insert(info->subactionPaths[i]).second,
                      XR_ERROR_PATH_UNSUPPORTED, "twice the same: " + path);
        }
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
        const Profile* known = profile_named(profile);
        if (!known) throw Answer{XR_ERROR_PATH_UNSUPPORTED};
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
            refuse_if(!offers(*known, path), XR_ERROR_PATH_UNSUPPORTED,
                      profile + " has no " + path);
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
        refuse_if(info->countActionSets == 0, XR_ERROR_VALIDATION_FAILURE, "no action sets");
        refuse_if(session.attached_once, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "attached twice");
        for (std::uint32_t i = 0; i < info->countActionSets; ++i)
            r.get<ActionSetObject>(info->actionSets[i]);
        for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
            r.get<ActionSetObject>(info->actionSets[i]).attached = true;
            session.attached.insert(number_of(info->actionSets[i]));
        }
        session.attached_once = true;
    });
}

// Words for people: the hand, the kind of controller, the part of it.
std::string words_of(const SessionObject& session, const std::string& path,
                     XrInputSourceLocalizedNameFlags which)
{
    const std::string user = user_of(path);
    refuse_if(user.empty(), XR_ERROR_PATH_UNSUPPORTED, "not the source of an input: " + path);
    std::vector<std::string> parts;
    if (which & XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT) parts.push_back(user.substr(6));
    const auto profile = session.profiles.find(user);
    if (which & XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT)
        parts.push_back(profile == session.profiles.end()
                            ? "controller"
                            : profile->second.substr(profile->second.rfind('/') + 1));
    if (which & XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT && path.size() > user.size())
        parts.push_back(path.substr(user.size() + 1));
    std::string all;
    for (const std::string& part : parts) all += (all.empty() ? "" : " ") + part;
    std::replace_if(
        all.begin(), all.end(), [](char c) { return c == '/' || c == '_'; }, ' ');
    return all;
}

XrResult XRAPI_CALL sources(XrSession handle, const XrBoundSourcesForActionEnumerateInfo* info,
                            std::uint32_t capacity, std::uint32_t* count, XrPath* to)
{
    return answered("xrEnumerateBoundSourcesForAction", [&](Runtime&) {
        const SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO);
        attached_action(session, info->action);
        const std::vector<std::string>& paths = the_instance().paths;
        std::vector<XrPath> all;
        for (const std::string& path : sources_of(session, info->action, ""))
            all.push_back(XrPath(std::find(paths.begin(), paths.end(), path) - paths.begin()));
        return give(all, capacity, count, to);
    });
}

XrResult XRAPI_CALL source_name(XrSession handle, const XrInputSourceLocalizedNameGetInfo* info,
                                std::uint32_t capacity, std::uint32_t* count, char* to)
{
    return answered("xrGetInputSourceLocalizedName", [&](Runtime& r) {
        const SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO);
        refuse_if(!session.attached_once, XR_ERROR_ACTIONSET_NOT_ATTACHED, "nothing is attached");
        refuse_if(info->whichComponents == 0 || info->whichComponents > 7,
                  XR_ERROR_VALIDATION_FAILURE, "not parts of a name");
        const std::string words =
            words_of(session, r.text_of(info->sourcePath), info->whichComponents);
        return give(std::vector<char>(words.c_str(), words.c_str() + words.size() + 1), capacity,
                    count, to);
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
    to["xrEnumerateBoundSourcesForAction"] = entry(sources);
    to["xrGetInputSourceLocalizedName"] = entry(source_name);
}

}  // namespace knead::replay
