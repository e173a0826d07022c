// Negotiation with the loader, the instance, its system, paths and events.
#include <algorithm>
#include <cstring>

#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

struct Known {
    const char* name;
    std::uint32_t version;
};
constexpr Known extensions[] = {
    {"XR_KHR_opengl_enable", 10},
    {"XR_MNDX_egl_enable", 1},
    {"XR_EXT_hand_tracking", 4},
    {"XR_EXT_hand_interaction", 1},
    {"XR_EXT_hand_tracking_data_source", 1},
    {"XR_KHR_composition_layer_depth", 5},
    {"XR_KHR_visibility_mask", 2},
    {"XR_FB_display_refresh_rate", 1},
    {"XR_EXT_user_presence", 1},
    {"XR_KHR_convert_timespec_time", 1},
};

// XrSystemUserPresencePropertiesEXT, which is newer than the headers.
struct UserPresence {
    XrStructureType type;
    void* next;
    XrBool32 supported;
};

const Table& table()
{
    static const Table all = [] {
        Table made;
        add_instance_functions(made), add_session_functions(made), add_frame_functions(made);
        add_swapchain_functions(made), add_space_functions(made), add_action_functions(made);
        add_state_functions(made), add_name_functions(made);
        add_hand_functions(made), add_extension_functions(made);
        return made;
    }();
    return all;
}

XrResult XRAPI_CALL address(XrInstance handle, const char* name, PFN_xrVoidFunction* function)
{
    return answered("xrGetInstanceProcAddr", [&](Runtime& r) {
        refuse_if(!function, XR_ERROR_VALIDATION_FAILURE, "no place for the function");
        *function = nullptr;
        refuse_if(!name, XR_ERROR_VALIDATION_FAILURE, "no name");
        const auto found = table().find(name);
        if (found == table().end()) throw Answer{XR_ERROR_FUNCTION_UNSUPPORTED};
        const bool early = std::string(name) == "xrEnumerateInstanceExtensionProperties" ||
                           std::string(name) == "xrCreateInstance";
        if (!early) {
            const InstanceObject& instance = r.get<InstanceObject>(handle);
            const std::string extension = extension_of(name);
            if (!extension.empty() && instance.enabled.count(extension) == 0)
                throw Answer{XR_ERROR_FUNCTION_UNSUPPORTED};
        }
        *function = found->second;
    });
}

XrResult XRAPI_CALL list_extensions(const char* layer, std::uint32_t capacity, std::uint32_t* count,
                                    XrExtensionProperties* to)
{
    return answered("xrEnumerateInstanceExtensionProperties", [&](Runtime& r) {
        refuse_if(layer && *layer, XR_ERROR_API_LAYER_NOT_PRESENT, "no layer is here");
        if (r.absent > 0 && !r.headset_absent && --r.absent >= 0) {
            r.note({{"absent", r.absent}});
            throw Answer{XR_ERROR_RUNTIME_FAILURE};
        }
        for (std::uint32_t i = 0; to && i < capacity; ++i)
            check_struct(&to[i], XR_TYPE_EXTENSION_PROPERTIES);
        return give(offered(), capacity, count, to);
    });
}

// Refuses a name that does not end within its place.
template <std::size_t size>
void check_ends(const char (&name)[size])
{
    refuse_if(!std::memchr(name, 0, size), XR_ERROR_NAME_INVALID, "a name without an end");
}

XrResult XRAPI_CALL create_instance(const XrInstanceCreateInfo* info, XrInstance* to)
{
    return answered("xrCreateInstance", [&](Runtime& r) {
        check_struct(info, XR_TYPE_INSTANCE_CREATE_INFO,
                     {XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT});
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the handle");
        refuse_if(info->createFlags != 0, XR_ERROR_VALIDATION_FAILURE, "there are no such flags");
        refuse_if(XR_VERSION_MAJOR(info->applicationInfo.apiVersion) != 1,
                  XR_ERROR_API_VERSION_UNSUPPORTED, "not version 1 of OpenXR");
        refuse_if(info->applicationInfo.applicationName[0] == 0, XR_ERROR_NAME_INVALID,
                  "the application has no name");
        check_ends(info->applicationInfo.applicationName);
        check_ends(info->applicationInfo.engineName);
        if (!r.script.service) throw Answer{XR_ERROR_RUNTIME_UNAVAILABLE};
        auto made = std::make_unique<InstanceObject>();
        const auto there = offered();
        for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
            const std::string name = info->enabledExtensionNames[i];
            const bool known = std::any_of(there.begin(), there.end(),
                                           [&](const auto& e) { return name == e.extensionName; });
            refuse_if(!known && name != "XR_EXT_debug_utils", XR_ERROR_EXTENSION_NOT_PRESENT, name);
            made->enabled.insert(name);
        }
        r.events.clear();
        r.note({{"instance", made->enabled}});
        *to = r.add<XrInstance>(std::move(made), 0);
    });
}

XrResult XRAPI_CALL destroy_instance(XrInstance handle)
{
    return answered("xrDestroyInstance", [&](Runtime& r) {
        r.get<InstanceObject>(handle);
        r.remove(number_of(handle));
        r.events.clear();
    });
}

XrResult XRAPI_CALL properties(XrInstance handle, XrInstanceProperties* to)
{
    return answered("xrGetInstanceProperties", [&](Runtime&) {
        instance_of(handle);
        check_struct(to, XR_TYPE_INSTANCE_PROPERTIES);
        to->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
        std::strcpy(to->runtimeName, "Knead replay");
    });
}

XrResult XRAPI_CALL poll(XrInstance handle, XrEventDataBuffer* to)
{
    return answered("xrPollEvent", [&](Runtime& r) -> XrResult {
        instance_of(handle);
        check_struct(to, XR_TYPE_EVENT_DATA_BUFFER);
        r.post_states();
        if (r.events.empty()) {
            if (SessionObject* session = r.live_session()) session->flow.polled_empty();
            r.post_states();
            return XR_EVENT_UNAVAILABLE;
        }
        *to = r.events.front();
        r.events.pop_front();
        return XR_SUCCESS;
    });
}

XrResult XRAPI_CALL to_path(XrInstance handle, const char* text, XrPath* to)
{
    return answered("xrStringToPath", [&](Runtime&) {
        std::vector<std::string>& paths = instance_of(handle).paths;
        refuse_if(!text || !to, XR_ERROR_VALIDATION_FAILURE, "no text, or no place for the path");
        refuse_if(!is_path(text), XR_ERROR_PATH_FORMAT_INVALID, text);
        const auto found = std::find(paths.begin(), paths.end(), text);
        *to = XrPath(found - paths.begin());
        if (found == paths.end()) paths.push_back(text);
    });
}

XrResult XRAPI_CALL to_text(XrInstance handle, XrPath path, std::uint32_t capacity,
                            std::uint32_t* count, char* to)
{
    return answered("xrPathToString", [&](Runtime& r) {
        instance_of(handle);
        const std::string& text = r.text_of(path);
        return give(std::vector<char>(text.c_str(), text.c_str() + text.size() + 1), capacity,
                    count, to);
    });
}

XrResult XRAPI_CALL get_system(XrInstance handle, const XrSystemGetInfo* info, XrSystemId* to)
{
    return answered("xrGetSystem", [&](Runtime& r) {
        check_struct(info, XR_TYPE_SYSTEM_GET_INFO);
        InstanceObject& instance = instance_of(handle);
        refuse_if(info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY,
                  XR_ERROR_FORM_FACTOR_UNSUPPORTED, "only headsets are here");
        if (!r.script.headset) throw Answer{XR_ERROR_FORM_FACTOR_UNAVAILABLE};
        if (r.headset_absent && r.absent > 0 && --r.absent >= 0)
            throw Answer{XR_ERROR_FORM_FACTOR_UNAVAILABLE};
        r.headset_absent = false;
        instance.asked_system = true;
        *to = the_system;
    });
}

XrResult XRAPI_CALL system_properties(XrInstance handle, XrSystemId id, XrSystemProperties* to)
{
    return answered("xrGetSystemProperties", [&](Runtime&) {
        instance_of(handle);
        refuse_if(id != the_system, XR_ERROR_SYSTEM_INVALID, "not the system");
        check_struct(to, XR_TYPE_SYSTEM_PROPERTIES,
                     {XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT,
                      XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT});
        std::strcpy(to->systemName, "Scripted headset");
        to->systemId = id;
        to->graphicsProperties = {8192, 8192, 16};
        to->trackingProperties = {XR_TRUE, XR_TRUE};
        if (void* presence = in_chain(to, XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT)) {
            check_enabled("XR_EXT_user_presence");
            static_cast<UserPresence*>(presence)->supported = XR_TRUE;
        }
        if (void* hands = in_chain(to, XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT)) {
            check_enabled("XR_EXT_hand_tracking");
            static_cast<XrSystemHandTrackingPropertiesEXT*>(hands)->supportsHandTracking = XR_TRUE;
        }
    });
}

}  // namespace

std::vector<XrExtensionProperties> offered()
{
    std::vector<XrExtensionProperties> all;
    const auto& without = runtime().script.without;
    for (const Known& one : extensions) {
        if (std::find(without.begin(), without.end(), one.name) != without.end()) continue;
        XrExtensionProperties property{XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, one.version};
        std::strcpy(property.extensionName, one.name);
        all.push_back(property);
    }
    return all;
}

std::string extension_of(const std::string& function)
{
    static const std::map<std::string, std::string> of{
        {"xrGetOpenGLGraphicsRequirementsKHR", "XR_KHR_opengl_enable"},
        {"xrCreateHandTrackerEXT", "XR_EXT_hand_tracking"},
        {"xrDestroyHandTrackerEXT", "XR_EXT_hand_tracking"},
        {"xrLocateHandJointsEXT", "XR_EXT_hand_tracking"},
        {"xrGetVisibilityMaskKHR", "XR_KHR_visibility_mask"},
        {"xrEnumerateDisplayRefreshRatesFB", "XR_FB_display_refresh_rate"},
        {"xrGetDisplayRefreshRateFB", "XR_FB_display_refresh_rate"},
        {"xrRequestDisplayRefreshRateFB", "XR_FB_display_refresh_rate"},
        {"xrConvertTimespecTimeToTimeKHR", "XR_KHR_convert_timespec_time"},
        {"xrConvertTimeToTimespecTimeKHR", "XR_KHR_convert_timespec_time"},
    };
    const auto found = of.find(function);
    return found == of.end() ? "" : found->second;
}

void add_instance_functions(Table& to)
{
    to["xrGetInstanceProcAddr"] = entry(address);
    to["xrEnumerateInstanceExtensionProperties"] = entry(list_extensions);
    to["xrCreateInstance"] = entry(create_instance);
    to["xrDestroyInstance"] = entry(destroy_instance);
    to["xrGetInstanceProperties"] = entry(properties);
    to["xrPollEvent"] = entry(poll);
    to["xrStringToPath"] = entry(to_path);
    to["xrPathToString"] = entry(to_text);
    to["xrGetSystem"] = entry(get_system);
    to["xrGetSystemProperties"] = entry(system_properties);
}

// Debian ships no header for what loader and runtime say to each other first.
struct LoaderInfo {
    std::uint32_t type, version;
    std::size_t size;
    std::uint32_t lowest_interface, highest_interface;
    XrVersion lowest_api, highest_api;
};
struct RuntimeRequest {
    std::uint32_t type, version;
    std::size_t size;
    std::uint32_t interface_version;
    XrVersion api_version;
    PFN_xrGetInstanceProcAddr address;
};

extern "C" __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderRuntimeInterface(const LoaderInfo* loader, RuntimeRequest* runtime_request)
{
    constexpr std::uint32_t loader_info = 1, request = 3, interface_version = 1;
    if (!loader || !runtime_request || loader->type != loader_info ||
        runtime_request->type != request || loader->size != sizeof *loader ||
        runtime_request->size != sizeof *runtime_request ||
        loader->lowest_interface > interface_version ||
        loader->highest_interface < interface_version)
        return XR_ERROR_INITIALIZATION_FAILED;
    runtime_request->interface_version = interface_version;
    runtime_request->api_version = XR_MAKE_VERSION(1, 0, 0);
    runtime_request->address = address;
    return XR_SUCCESS;
}

}  // namespace knead::replay
