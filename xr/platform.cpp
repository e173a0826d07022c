#include "xr/platform.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <sstream>
#include <thread>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace knead::xr {

void* function_of_library(const std::string& names, const char* name, std::string& reason)
{
    std::istringstream in(names);
    std::string why;  // error for the first library, the most likely name on this system
    for (std::string library; in >> library;) {
#ifdef _WIN32
        const HMODULE opened = LoadLibraryA(library.c_str());
        void* found = opened ? reinterpret_cast<void*>(GetProcAddress(opened, name)) : nullptr;
        if (!opened && why.empty()) why = library + " was not found";
#else
        void* opened = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
        void* found = opened ? ::dlsym(opened, name) : nullptr;
        if (!opened) {
            const char* said = ::dlerror();
            if (why.empty()) why = said ? said : library + " was not found";
        }
#endif
        if (opened && !found) why = library + " has no " + name;
        if (found) return found;
    }
    reason = why;
    return nullptr;
}

void sleep_for(double seconds)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

std::unique_ptr<Platform> platform(GlBinding binding, const std::vector<std::string>& offered)
{
    const bool knows_egl =
        std::find(offered.begin(), offered.end(), "XR_MNDX_egl_enable") != offered.end();
#ifdef _WIN32
    const GlBinding usual = GlBinding::wgl;
#else
    const bool x11 = std::getenv("DISPLAY") != nullptr;
    const GlBinding usual = x11 && !knows_egl ? GlBinding::glx : GlBinding::egl;
#endif
    const GlBinding chosen = binding == GlBinding::automatic ? usual : binding;
    if (chosen == GlBinding::egl && !knows_egl)
        throw HeadsetError(
            "the OpenXR runtime does not take OpenGL by EGL (XR_MNDX_egl_enable); under X11, "
            "--binding glx is another way");
    try {
        if (chosen == GlBinding::wgl) return wgl_platform();
        return chosen == GlBinding::glx ? glx_platform() : egl_platform();
    } catch (const std::runtime_error& e) {
        throw HeadsetError(std::string("no OpenGL 4.5 for the headset: ") + e.what());
    }
}

}  // namespace knead::xr
