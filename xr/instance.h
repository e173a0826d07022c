// An OpenXR instance and its system (the headset).
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "xr/api.h"
#include "xr/extensions.h"
#include "xr/platform.h"

namespace knead::xr {

// Entry point of the loader. Throws HeadsetError if there is no loader.
PFN_xrGetInstanceProcAddr loader();

// Instance extensions of the runtime. Throws HeadsetError if there is no runtime.
std::vector<std::string> offered_extensions(PFN_xrGetInstanceProcAddr loader);

class Instance {
  public:
    // `binding`: extension required by the graphics binding; "": none. Throws HeadsetError if a
    // required extension or the headset is missing.
    Instance(PFN_xrGetInstanceProcAddr loader, const std::vector<std::string>& offered,
             const std::string& binding);
    ~Instance();
    Instance(const Instance&) = delete;

    // Polls the next event; false: the queue is empty.
    bool next_event(XrEventDataBuffer& event);
    // Queries the system again, as required before another session. False: no headset available.
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
    void query_system();
    void listen();
    static XrBool32 XRAPI_CALL keep_message(XrDebugUtilsMessageSeverityFlagsEXT how,
                                            XrDebugUtilsMessageTypeFlagsEXT of,
                                            const XrDebugUtilsMessengerCallbackDataEXT* what,
                                            void* self);

    XrDebugUtilsMessengerEXT messenger = XR_NULL_HANDLE;
    struct Messages;
    std::shared_ptr<Messages> messages;  // filled by the debug messenger from any thread
};

}  // namespace knead::xr
