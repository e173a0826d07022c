// Operating system dependent code: loading libraries, and a GL context for OpenXR.
// docs/method/headset.md lists all such calls of the project.
#pragma once
#include <memory>
#include <string>

#include "xr/headset.h"

namespace knead::xr {

// Loads function `name` from the first of the libraries `names` (separated by blanks) that has it.
// Returns null and sets `reason` on failure. Opened libraries are never closed.
void* function_of_library(const std::string& names, const char* name, std::string& reason);

void sleep_for(double seconds);

// An invisible GL 4.5 core context.
class Platform {
  public:
    virtual ~Platform() = default;
    virtual const char* name() const = 0;  // "EGL", "GLX", "WGL"
    virtual const char* extension()
        const = 0;                            // OpenXR extension required by its binding; "": none
    virtual const void* binding() const = 0;  // for XrSessionCreateInfo::next
    virtual void make_current() = 0;
    virtual Headset::GlAddress address() const = 0;
};

// Throw std::runtime_error with the reason.
std::unique_ptr<Platform> egl_platform();
std::unique_ptr<Platform> glx_platform();
std::unique_ptr<Platform> wgl_platform();

// Creates the context for `binding`. automatic: WGL on Windows; GLX if DISPLAY is set and `offered`
// (the runtime's extensions) lacks XR_MNDX_egl_enable; else EGL. Throws HeadsetError.
std::unique_ptr<Platform> platform(GlBinding binding, const std::vector<std::string>& offered);

}  // namespace knead::xr
