#include "render/context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <cstring>
#include <stdexcept>
#include <vector>

#include "render/gl.h"

namespace knead {
namespace {

// EGL functions, loaded at first use: without EGL only pictures are unavailable.
struct Egl {
    decltype(&eglGetProcAddress) address;
    decltype(&eglQueryString) query_string;
    decltype(&eglGetError) error;
    decltype(&eglInitialize) initialize;
    decltype(&eglBindAPI) bind_api;
    decltype(&eglChooseConfig) choose_config;
    decltype(&eglCreateContext) create_context;
    decltype(&eglDestroyContext) destroy_context;
    decltype(&eglMakeCurrent) make_current;
    decltype(&eglGetCurrentContext) current_context;
    decltype(&eglGetCurrentDisplay) current_display;
    decltype(&eglGetCurrentSurface) current_surface;
    decltype(&eglGetDisplay) default_display;
    // Extensions, null where they are missing.
    PFNEGLGETPLATFORMDISPLAYEXTPROC platform_display;
    PFNEGLQUERYDEVICESEXTPROC devices;
    PFNEGLQUERYDEVICESTRINGEXTPROC device_string;
};

template <class Function>
void find(void* library, Function& function, const char* name)
{
    function = reinterpret_cast<Function>(::dlsym(library, name));
    if (!function) throw std::runtime_error(std::string("libEGL.so.1 has no ") + name);
}

Egl load()
{
    void* library = ::dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        const char* reason = ::dlerror();
        throw std::runtime_error(std::string("no pictures: ") +
                                 (reason ? reason : "no libEGL.so.1"));
    }
    Egl e{};
    find(library, e.address, "eglGetProcAddress");
    find(library, e.query_string, "eglQueryString");
    find(library, e.error, "eglGetError");
    find(library, e.initialize, "eglInitialize");
    find(library, e.bind_api, "eglBindAPI");
    find(library, e.choose_config, "eglChooseConfig");
    find(library, e.create_context, "eglCreateContext");
    find(library, e.destroy_context, "eglDestroyContext");
    find(library, e.make_current, "eglMakeCurrent");
    find(library, e.current_context, "eglGetCurrentContext");
    find(library, e.current_display, "eglGetCurrentDisplay");
    find(library, e.current_surface, "eglGetCurrentSurface");
    find(library, e.default_display, "eglGetDisplay");
    const auto extension = [&](auto& function, const char* name) {
        function = reinterpret_cast<std::decay_t<decltype(function)>>(e.address(name));
    };
    extension(e.platform_display, "eglGetPlatformDisplayEXT");
    extension(e.devices, "eglQueryDevicesEXT");
    extension(e.device_string, "eglQueryDeviceStringEXT");
    return e;
}

const Egl& egl()
{
    static const Egl functions = load();
    return functions;
}

bool has(const char* extensions, const char* name)
{
    if (!extensions) return false;
    const std::string padded = " " + std::string(extensions) + " ";
    return padded.find(" " + std::string(name) + " ") != std::string::npos;
}

std::string last_error()
{
    switch (const EGLint code = egl().error()) {
        case EGL_NOT_INITIALIZED:
            return "not initialized";
        case EGL_BAD_ACCESS:
            return "bad access";
        case EGL_BAD_ALLOC:
            return "out of resources";
        case EGL_BAD_MATCH:
            return "not supported there (bad match)";
        case EGL_BAD_CONFIG:
            return "no such configuration";
        case EGL_BAD_ATTRIBUTE:
            return "bad attribute";
        case EGL_BAD_DISPLAY:
            return "bad display";
        default:
            return "EGL error " + std::to_string(code);
    }
}

struct Way {
    EGLDisplay display;
    std::string name;
};

// Hardware devices first, then software ones, then Mesa without a device, then the default.
std::vector<Way> ways()
{
    const Egl& e = egl();
    const char* client = e.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<Way> hardware, software;
    EGLDeviceEXT devices[64];
    EGLint count = 0;
    if (e.platform_display && e.devices && e.devices(64, devices, &count)) {
        for (EGLint i = 0; i < count; ++i) {
            const char* about = e.device_string ? e.device_string(devices[i], EGL_EXTENSIONS) : "";
            const bool soft = has(about, "EGL_MESA_device_software");
            (soft ? software : hardware)
                .push_back({e.platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr),
                            "EGL device " + std::to_string(i) + (soft ? " (software)" : "")});
        }
    }
    hardware.insert(hardware.end(), software.begin(), software.end());
    if (e.platform_display && has(client, "EGL_MESA_platform_surfaceless")) {
        hardware.push_back({e.platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr),
                            "surfaceless EGL"});
    }
    hardware.push_back({e.default_display(EGL_DEFAULT_DISPLAY), "default EGL display"});
    return hardware;
}

EGLConfig configuration(EGLDisplay display)
{
    const char* about = egl().query_string(display, EGL_EXTENSIONS);
    if (has(about, "EGL_KHR_no_config_context")) return EGL_NO_CONFIG_KHR;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    egl().choose_config(display, wanted, &config, 1, &count);
    return config;
}

}  // namespace

bool Context::start(void* display, const std::string& way, std::string& reasons)
{
    const Egl& e = egl();
    const auto no = [&](const std::string& reason) {
        reasons += "\n  " + way + ": " + reason;
        if (context_) e.destroy_context(display, context_);
        context_ = nullptr;
        return false;
    };
    if (display == EGL_NO_DISPLAY) return no("no display");
    if (!e.initialize(display, nullptr, nullptr)) return no(last_error());
    const char* about = e.query_string(display, EGL_EXTENSIONS);
    if (!has(about, "EGL_KHR_surfaceless_context")) return no("it needs a window");
    if (!e.bind_api(EGL_OPENGL_API)) return no("it has no desktop OpenGL");
    const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                             4,
                             EGL_CONTEXT_MINOR_VERSION,
                             5,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             EGL_NONE};
    context_ = e.create_context(display, configuration(display), EGL_NO_CONTEXT, wanted);
    const std::string created = context_ ? "" : last_error();
    if (!context_) return no("OpenGL 4.5 core: " + created);
    display_ = display;
    const Bound bound(*this);
    if (e.current_context() != context_) return no("the context cannot be made current");
    if (!load_gl_functions(e.address)) return no("OpenGL 4.5 does not load");
    const GLubyte* renderer = glGetString(GL_RENDERER);
    name_ = renderer ? reinterpret_cast<const char*>(renderer) : "unnamed";
    return true;
}

Context::Context()
{
    std::string reasons;
    for (const Way& way : ways()) {
        if (start(way.display, way.name, reasons)) return;
    }
    throw std::runtime_error("no pictures: no OpenGL 4.5 context without a window" + reasons);
}

// The display stays initialized: other code in this process may use it.
Context::~Context() { egl().destroy_context(display_, context_); }

Context::Bound::Bound(const Context& context) : own_(context)
{
    egl().bind_api(EGL_OPENGL_API);  // else EGL uses OpenGL ES contexts
    display_ = egl().current_display();
    context_ = egl().current_context();
    draw_ = egl().current_surface(EGL_DRAW);
    read_ = egl().current_surface(EGL_READ);
    egl().make_current(own_.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, own_.context_);
}

Context::Bound::~Bound()
{
    if (context_) {
        egl().make_current(display_, draw_, read_, context_);
    } else {
        egl().make_current(own_.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
}

}  // namespace knead
