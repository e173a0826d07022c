// An OpenXR instance and the headset found by it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "xr/api.h"
#include "xr/extensions.h"
#include "xr/platform.h"

namespace knead::xr {

// The loader's entry. Throws HeadsetError where there is no loader.
PFN_xrGetInstanceProcAddr loader();

// What the runtime offers. Throws HeadsetError where there is no runtime.
std::vector<std::string> offered_extensions(PFN_xrGetInstanceProcAddr loader);

class Instance {
  public:
    // `binding`: the extension that its graphics binding needs; "": none more. Throws HeadsetError
    // where the runtime lacks what is needed or sees no headset.
    Instance(PFN_xrGetInstanceProcAddr loader, const std::vector<std::string>& offered,
             const std::string& binding);
    ~Instance();
    Instance(const Instance&) = delete;

    // The next event; false: there is none.
    bool next_event(XrEventDataBuffer& event);
    // Looks for the headset anew, as is due before another session. False: there is none now.
    bool find_system();
    XrPath path(const char* text);

    Api api;
    Enabled has;
    XrSystemId system = XR_NULL_SYSTEM_ID;
    std::string runtime_name, system_name;
    bool tracks_hands = false;
    XrViewConfigurationView views[2];
    XrEnvironmentBlendMode blend_mode(bool see_through);
    std::vector<std::string> take_messages();

  private:
    void create(const std::vector<std::string>& names);
    void look();
    void listen();
    static XrBool32 XRAPI_CALL heard(XrDebugUtilsMessageSeverityFlagsEXT how,
                                     XrDebugUtilsMessageTypeFlagsEXT of,
                                     const XrDebugUtilsMessengerCallbackDataEXT* what, void* self);

    XrDebugUtilsMessengerEXT messenger = XR_NULL_HANDLE;
    struct Messages;
    std::shared_ptr<Messages> messages;  // written by any thread of the runtime
};

}  // namespace knead::xr
