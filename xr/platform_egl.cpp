// OpenGL by EGL, without a window system: XR_MNDX_egl_enable.
#include "xr/platform.h"

#ifdef KNEAD_HAS_EGL
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstring>
#include <stdexcept>

#define XR_USE_PLATFORM_EGL
#include "xr/openxr.h"
#endif

namespace knead::xr {
#ifdef KNEAD_HAS_EGL
namespace {

template <class Function>
Function* egl_function(const char* name, Function*)
{
    std::string reason;
    void* found = function_of_library("libEGL.so.1", name, reason);
    if (!found) throw std::runtime_error(reason);
    return reinterpret_cast<Function*>(found);
}

class EglPlatform : public Platform {
  public:
    EglPlatform();
    ~EglPlatform() override
    {
        make(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        destroy(display, context);
    }
    const char* name() const override { return "EGL"; }
    const char* extension() const override { return XR_MNDX_EGL_ENABLE_EXTENSION_NAME; }
    const void* binding() const override { return &bound; }
    void make_current() override
    {
        bind(EGL_OPENGL_API);  // else EGL uses OpenGL ES contexts
        if (!make(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
            throw std::runtime_error("the context cannot be made current");
    }
    Headset::GlAddress address() const override
    {
        return reinterpret_cast<Headset::GlAddress>(find);
    }

  private:
    bool start(EGLDisplay on);

    decltype(&eglGetProcAddress) find = egl_function("eglGetProcAddress", &*find);
    decltype(&eglQueryString) query = egl_function("eglQueryString", &*query);
    decltype(&eglInitialize) initialize = egl_function("eglInitialize", &*initialize);
    decltype(&eglBindAPI) bind = egl_function("eglBindAPI", &*bind);
    decltype(&eglChooseConfig) choose = egl_function("eglChooseConfig", &*choose);
    decltype(&eglCreateContext) create = egl_function("eglCreateContext", &*create);
    decltype(&eglDestroyContext) destroy = egl_function("eglDestroyContext", &*destroy);
    decltype(&eglMakeCurrent) make = egl_function("eglMakeCurrent", &*make);
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLConfig config = nullptr;
    EGLContext context = EGL_NO_CONTEXT;
    XrGraphicsBindingEGLMNDX bound{XR_TYPE_GRAPHICS_BINDING_EGL_MNDX, nullptr, {}, {}, {}, {}};
};

bool EglPlatform::start(EGLDisplay on)
{
    if (on == EGL_NO_DISPLAY || !initialize(on, nullptr, nullptr)) return false;
    const char* about = query(on, EGL_EXTENSIONS);
    if (!about || !std::strstr(about, "EGL_KHR_surfaceless_context")) return false;
    if (!bind(EGL_OPENGL_API)) return false;
    const EGLint kind[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLint count = 0;
    // The OpenXR binding needs a config, even if EGL supports contexts without one.
    if (!choose(on, kind, &config, 1, &count) || count < 1) return false;
    const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                             4,
                             EGL_CONTEXT_MINOR_VERSION,
                             5,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             EGL_NONE};
    context = create(on, config, EGL_NO_CONTEXT, wanted);
    display = on;
    return context != EGL_NO_CONTEXT;
}

EglPlatform::EglPlatform()
{
    const auto by_platform =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(find("eglGetPlatformDisplayEXT"));
    const auto devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(find("eglQueryDevicesEXT"));
    const auto device_text =
        reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(find("eglQueryDeviceStringEXT"));
    bool made = false;
    EGLDeviceEXT all[16];
    EGLint count = 0;
    if (by_platform && devices && device_text && devices(16, all, &count)) {
        for (EGLint i = 0; i < count && !made; ++i) {
            // Skip software devices: Mesa's surfaceless platform, below, suits them better.
            const char* about = device_text(all[i], EGL_EXTENSIONS);
            if (about && std::strstr(about, "EGL_MESA_device_software")) continue;
            made = start(by_platform(EGL_PLATFORM_DEVICE_EXT, all[i], nullptr));
        }
    }
    if (!made && by_platform)
        made = start(by_platform(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr));
    if (!made) throw std::runtime_error("no context of OpenGL 4.5 core by EGL");
    bound.getProcAddress = reinterpret_cast<decltype(bound.getProcAddress)>(find);
    bound.display = display, bound.config = config, bound.context = context;
    make_current();
}

}  // namespace

std::unique_ptr<Platform> egl_platform() { return std::make_unique<EglPlatform>(); }
#else
std::unique_ptr<Platform> egl_platform()
{
    throw std::runtime_error("this program was built without EGL/egl.h");
}
#endif
}  // namespace knead::xr
