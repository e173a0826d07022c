#include "tests/openxr_replay/gl_guard.h"

#include <dlfcn.h>

#include <nlohmann/json.hpp>

// clang-format off
// The functions of OpenGL before GLX, which includes GL/gl.h; EGL and GLX before OpenXR's bindings,
// which name their types.
#include <EGL/egl.h>
#include "render/gl.h"
#include <GL/glx.h>
#define XR_USE_PLATFORM_XLIB
#define XR_USE_PLATFORM_EGL
#include "tests/openxr_replay/runtime.h"
// clang-format on

namespace knead::replay {
namespace {

template <class Function>
Function* found(const char* library, const char* name)
{
    void* opened = ::dlopen(library, RTLD_NOW | RTLD_LOCAL);
    void* function = opened ? ::dlsym(opened, name) : nullptr;
    refuse_if(!function, XR_ERROR_RUNTIME_FAILURE, std::string(library) + " has no " + name);
    return reinterpret_cast<Function*>(function);
}

void load(void* address)
{
    using Address = void (*(*)(const char*))();
    refuse_if(!load_gl_functions(reinterpret_cast<Address>(address)),
              XR_ERROR_GRAPHICS_DEVICE_INVALID, "the context is not of OpenGL 4.5");
}

struct EglSource : GlGuardSource {
    explicit EglSource(const XrGraphicsBindingEGLMNDX& from) : given(from)
    {
        refuse_if(!given.getProcAddress || !given.display || !given.context || !given.config,
                  XR_ERROR_GRAPHICS_DEVICE_INVALID, "the EGL binding is not whole");
        const auto held = bind();
        load(reinterpret_cast<void*>(given.getProcAddress));
    }
    struct Guard : GlGuard {
        explicit Guard(EglSource& of) : source(of)
        {
            source.bind_api(EGL_OPENGL_API);
            display = source.current_display(), context = source.current_context();
            draw = source.current_surface(EGL_DRAW), read = source.current_surface(EGL_READ);
            if (context == source.given.context) return;
            const EGLBoolean made = source.make(source.given.display, EGL_NO_SURFACE,
                                                EGL_NO_SURFACE, source.given.context);
            refuse_if(!made, XR_ERROR_RUNTIME_FAILURE, "the context is current elsewhere");
        }
        ~Guard() override
        {
            if (context == source.given.context) return;
            if (context)
                source.make(display, draw, read, context);
            else
                source.steal();
        }
        EglSource& source;
        EGLDisplay display;
        EGLContext context;
        EGLSurface draw, read;
    };
    std::unique_ptr<GlGuard> bind() override { return std::make_unique<Guard>(*this); }
    void steal() override { make(given.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }
    const char* name() const override { return "EGL"; }
    void* address(const char* function) const override
    {
        return reinterpret_cast<void*>(given.getProcAddress(function));
    }

    XrGraphicsBindingEGLMNDX given;
    static constexpr const char* library = "libEGL.so.1";
    decltype(&eglBindAPI) bind_api = found<decltype(eglBindAPI)>(library, "eglBindAPI");
    decltype(&eglMakeCurrent) make = found<decltype(eglMakeCurrent)>(library, "eglMakeCurrent");
    decltype(&eglGetCurrentContext) current_context =
        found<decltype(eglGetCurrentContext)>(library, "eglGetCurrentContext");
    decltype(&eglGetCurrentDisplay) current_display =
        found<decltype(eglGetCurrentDisplay)>(library, "eglGetCurrentDisplay");
    decltype(&eglGetCurrentSurface) current_surface =
        found<decltype(eglGetCurrentSurface)>(library, "eglGetCurrentSurface");
};

struct GlxSource : GlGuardSource {
    explicit GlxSource(const XrGraphicsBindingOpenGLXlibKHR& from) : given(from)
    {
        refuse_if(!given.xDisplay || !given.glxContext || !given.glxDrawable ||
                      !given.glxFBConfig || given.visualid == 0,
                  XR_ERROR_GRAPHICS_DEVICE_INVALID, "the GLX binding is not whole");
        const auto held = bind();
        load(reinterpret_cast<void*>(
            found<decltype(glXGetProcAddressARB)>(library, "glXGetProcAddressARB")));
    }
    struct Guard : GlGuard {
        explicit Guard(GlxSource& of)
            : source(of), context(of.current_context()), drawable(of.current_drawable())
        {
            if (context == source.given.glxContext) return;
            const auto& given = source.given;
            refuse_if(!source.make(given.xDisplay, given.glxDrawable, given.glxContext),
                      XR_ERROR_RUNTIME_FAILURE, "the context is current elsewhere");
        }
        ~Guard() override
        {
            if (context == source.given.glxContext) return;
            if (context)
                source.make(source.given.xDisplay, drawable, context);
            else
                source.steal();
        }
        GlxSource& source;
        GLXContext context;
        GLXDrawable drawable;
    };
    std::unique_ptr<GlGuard> bind() override { return std::make_unique<Guard>(*this); }
    void steal() override { make(given.xDisplay, 0, nullptr); }
    const char* name() const override { return "GLX"; }
    void* address(const char* function) const override
    {
        return reinterpret_cast<void*>(find(reinterpret_cast<const unsigned char*>(function)));
    }

    XrGraphicsBindingOpenGLXlibKHR given;
    static constexpr const char* library = "libGLX.so.0";
    decltype(&glXGetProcAddressARB) find =
        found<decltype(glXGetProcAddressARB)>(library, "glXGetProcAddressARB");
    decltype(&glXMakeCurrent) make = found<decltype(glXMakeCurrent)>(library, "glXMakeCurrent");
    decltype(&glXGetCurrentContext) current_context =
        found<decltype(glXGetCurrentContext)>(library, "glXGetCurrentContext");
    decltype(&glXGetCurrentDrawable) current_drawable =
        found<decltype(glXGetCurrentDrawable)>(library, "glXGetCurrentDrawable");
};

}  // namespace

std::unique_ptr<GlGuardSource> gl_of(const void* chain)
{
    if (const void* egl = in_chain(chain, XR_TYPE_GRAPHICS_BINDING_EGL_MNDX)) {
        check_enabled(XR_MNDX_EGL_ENABLE_EXTENSION_NAME);
        return std::make_unique<EglSource>(*static_cast<const XrGraphicsBindingEGLMNDX*>(egl));
    }
    if (const void* glx = in_chain(chain, XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR))
        return std::make_unique<GlxSource>(
            *static_cast<const XrGraphicsBindingOpenGLXlibKHR*>(glx));
    return nullptr;
}

}  // namespace knead::replay
