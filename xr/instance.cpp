#include "xr/instance.h"

#include <cstdio>
#include <cstring>
#include <mutex>
#include <utility>

#include "xr/advice.h"
#include "xr/two_call.h"

namespace knead::xr {
namespace {

template <std::size_t N>
void copy(char (&to)[N], const std::string& text)
{
    std::snprintf(to, N, "%s", text.c_str());
}

[[noreturn]] void no_headset(const Instance& of, XrResult result)
{
    const bool later = result == XR_ERROR_FORM_FACTOR_UNAVAILABLE;
    throw HeadsetError("the OpenXR runtime " + of.runtime_name + " sees no headset" +
                       (later ? ": switch it on, or connect it" : " of a kind that is worn") +
                       " (" + result_name(result) + ")");
}

}  // namespace

struct Instance::Messages {
    std::mutex lock;
    std::vector<std::string> all;
};

PFN_xrGetInstanceProcAddr loader()
{
#ifdef _WIN32
    const char* names = "openxr_loader.dll";
#else
    const char* names = "libopenxr_loader.so.1";
#endif
    std::string reason;
    void* found = function_of_library(names, "xrGetInstanceProcAddr", reason);
    if (!found)
        throw HeadsetError("no OpenXR loader: " + reason +
                           "; on Debian and Ubuntu it is the package libopenxr-loader1");
    return reinterpret_cast<PFN_xrGetInstanceProcAddr>(found);
}

std::vector<std::string> offered_extensions(PFN_xrGetInstanceProcAddr loader)
{
    Api before(Source{loader, XR_NULL_HANDLE});
    XrExtensionProperties blank{XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0};
    std::vector<std::string> names;
    try {
        for (const XrExtensionProperties& one :
             listed(before.extensions, blank, static_cast<const char*>(nullptr)))
            names.push_back(one.extensionName);
    } catch (const XrFailure& e) {
        throw HeadsetError(std::string("no OpenXR runtime answers (") + e.what() +
                           "): " + start_advice(e.code) +
                           "; XR_LOADER_DEBUG=all says where it was looked for");
    }
    return names;
}

Instance::Instance(PFN_xrGetInstanceProcAddr loader, const std::vector<std::string>& offered,
                   const std::string& binding)
    : api(Source{loader, XR_NULL_HANDLE}),
      has(enabled_of(offered)),
      messages(std::make_shared<Messages>())
{
    for (int e = 0; e < extension_count; ++e) {
        const ExtensionRow& row = extension_table[std::size_t(e)];
        if (row.needed && !has[Extension(e)])
            throw HeadsetError(std::string("the OpenXR runtime lacks ") + row.name + " (" +
                               row.gives + ")");
    }
    std::vector<std::string> names = has.names();
    if (!binding.empty()) names.push_back(binding);
    create(names);
    try {
        listen();
        query_system();
    } catch (...) {
        api.destroy_instance.raw(api.instance);
        throw;
    }
}

void Instance::create(const std::vector<std::string>& names)
{
    std::vector<const char*> texts;
    texts.reserve(names.size());
    for (const std::string& name : names) texts.push_back(name.c_str());
    auto about = typed<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    copy(about.applicationInfo.applicationName, "Knead");
    copy(about.applicationInfo.engineName, "Knead");
    about.applicationInfo.applicationVersion = about.applicationInfo.engineVersion = 1;
    about.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    about.enabledExtensionCount = std::uint32_t(texts.size());
    about.enabledExtensionNames = texts.data();
    XrInstance made = XR_NULL_HANDLE;
    try {
        api.create_instance(&about, &made);
    } catch (const XrFailure& e) {
        throw HeadsetError(std::string("the OpenXR runtime does not start (") + e.what() +
                           "): " + start_advice(e.code));
    }
    api.instance = made;
    auto properties = typed<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
    api.instance_properties(made, &properties);
    runtime_name = properties.runtimeName;
    const XrVersion v = properties.runtimeVersion;
    runtime_name += " " + std::to_string(XR_VERSION_MAJOR(v)) + "." +
                    std::to_string(XR_VERSION_MINOR(v)) + "." + std::to_string(XR_VERSION_PATCH(v));
}

Instance::~Instance()
{
    if (messenger) api.destroy_messenger.raw(messenger);
    api.destroy_instance.raw(api.instance);
}

void Instance::listen()
{
    if (!has[debug_messages]) return;
    auto about =
        typed<XrDebugUtilsMessengerCreateInfoEXT>(XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    about.messageSeverities = XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                              XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    about.messageTypes = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                         XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                         XR_DEBUG_UTILS_MESSAGE_TYPE_CONFORMANCE_BIT_EXT;
    about.userCallback = keep_message;
    about.userData = messages.get();
    if (XR_FAILED(api.create_messenger.raw(api.instance, &about, &messenger)))
        messenger = XR_NULL_HANDLE;
}

XrBool32 XRAPI_CALL Instance::keep_message(XrDebugUtilsMessageSeverityFlagsEXT,
                                           XrDebugUtilsMessageTypeFlagsEXT,
                                           const XrDebugUtilsMessengerCallbackDataEXT* what,
                                           void* self)
{
    Messages& to = *static_cast<Messages*>(self);
    const std::lock_guard held(to.lock);
    const auto text = [](const char* t) { return std::string(t ? t : "").substr(0, 500); };
    if (to.all.size() < 1000)
        to.all.push_back(text(what->functionName) + " " + text(what->messageId) + ": " +
                         text(what->message));
    return XR_FALSE;
}

std::vector<std::string> Instance::take_messages()
{
    const std::lock_guard held(messages->lock);
    return std::exchange(messages->all, {});
}

bool Instance::find_system()
{
    auto about = typed<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
    about.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    const XrResult result = api.system.raw(api.instance, &about, &system);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE) return false;
    if (result == XR_ERROR_INSTANCE_LOST) throw XrFailure("xrGetSystem", result);
    if (XR_FAILED(result)) no_headset(*this, result);
    return true;
}

void Instance::query_system()
{
    if (!find_system()) no_headset(*this, XR_ERROR_FORM_FACTOR_UNAVAILABLE);
    auto hands =
        typed<XrSystemHandTrackingPropertiesEXT>(XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
    auto properties = typed<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    if (has[hand_tracking]) properties.next = &hands;
    api.system_properties(api.instance, system, &properties);
    system_name = properties.systemName;
    tracks_hands = has[hand_tracking] && hands.supportsHandTracking;
    const XrViewConfigurationView blank{XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0};
    const auto found =
        listed(api.views, blank, api.instance, system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO);
    if (found.size() != 2)
        throw HeadsetError("the headset " + system_name + " does not have two views");
    views[0] = found[0], views[1] = found[1];
}

XrEnvironmentBlendMode Instance::blend_mode(bool see_through)
{
    const auto modes = listed(api.blend_modes, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, api.instance,
                              system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO);
    if (modes.empty()) return XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    const auto there = [&](XrEnvironmentBlendMode wanted) {
        for (const XrEnvironmentBlendMode mode : modes)
            if (mode == wanted) return true;
        return false;
    };
    if (see_through && there(XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND))
        return XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
    // modes[0] is the mode that the runtime prefers: additive on optical see-through displays.
    return there(XR_ENVIRONMENT_BLEND_MODE_OPAQUE) ? XR_ENVIRONMENT_BLEND_MODE_OPAQUE : modes[0];
}

XrPath Instance::path(const char* text)
{
    XrPath made = XR_NULL_PATH;
    api.path(api.instance, text, &made);
    return made;
}

bool Instance::next_event(XrEventDataBuffer& event)
{
    event = typed<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    return api.poll_event(api.instance, &event) == XR_SUCCESS;
}

}  // namespace knead::xr
