// All that depends on the operating system: opening libraries, and a GL context that can be handed
// to OpenXR. docs/method/headset.md lists every such call of the project.
#pragma once
#include <memory>
#include <string>

#include "xr/headset.h"

namespace knead::xr {

// The function `name` of a shared library that is opened by the first of its names that works; null
// and a reason otherwise. The library stays open.
void* function_of_library(const std::string& names, const char* name, std::string& reason);

void sleep_for(double seconds);

// A GL 4.5 core context without anything to be seen of it.
class Platform {
  public:
    virtual ~Platform() = default;
    virtual const char* name() const = 0;       // "EGL", "GLX", "WGL"
    virtual const char* extension() const = 0;  // of OpenXR that its binding needs; "": none more
    virtual const void* binding() const = 0;    // for XrSessionCreateInfo::next
    virtual void make_current() = 0;
    virtual Headset::GlAddress address() const = 0;
};

// Throw std::runtime_error with the reason.
std::unique_ptr<Platform> egl_platform();
std::unique_ptr<Platform> glx_platform();
std::unique_ptr<Platform> wgl_platform();

// By `binding`; automatic: WGL on Windows; otherwise GLX where there is an X display and the
// runtime, whose extensions are `offered`, does not know EGL, else EGL. Throws HeadsetError.
std::unique_ptr<Platform> platform(GlBinding binding, const std::vector<std::string>& offered);

}  // namespace knead::xr
