// OpenGL by GLX under X11, with a window that is never mapped.
#include "xr/platform.h"

#ifdef KNEAD_HAS_GLX
#include <GL/glx.h>
#include <X11/Xlib.h>

#include <stdexcept>

#define XR_USE_PLATFORM_XLIB
#include "xr/openxr.h"
#endif

namespace knead::xr {
#ifdef KNEAD_HAS_GLX
namespace {

template <class Function>
Function* function(const char* library, const char* name, Function*)
{
    std::string reason;
    void* found = function_of_library(library, name, reason);
    if (!found) throw std::runtime_error(reason);
    return reinterpret_cast<Function*>(found);
}
constexpr const char* x11 = "libX11.so.6";
constexpr const char* glx = "libGLX.so.0 libGL.so.1";

using CreateContext = GLXContext(Display*, GLXFBConfig, GLXContext, Bool, const int*);

class GlxPlatform : public Platform {
  public:
    GlxPlatform();
    ~GlxPlatform() override { free_all(); }
    const char* name() const override { return "GLX"; }
    const char* extension() const override { return ""; }
    const void* binding() const override { return &bound; }
    void make_current() override
    {
        if (!make(display, window, context))
            throw std::runtime_error("the context cannot be made current");
    }
    Headset::GlAddress address() const override
    {
        return reinterpret_cast<Headset::GlAddress>(find);
    }

  private:
    void start();
    void free_all();

    decltype(&XOpenDisplay) open = function(x11, "XOpenDisplay", &*open);
    decltype(&XCloseDisplay) close = function(x11, "XCloseDisplay", &*close);
    decltype(&XInitThreads) threads = function(x11, "XInitThreads", &*threads);
    decltype(&XCreateColormap) colours = function(x11, "XCreateColormap", &*colours);
    decltype(&XFreeColormap) free_colours = function(x11, "XFreeColormap", &*free_colours);
    decltype(&XCreateWindow) create = function(x11, "XCreateWindow", &*create);
    decltype(&XDestroyWindow) destroy = function(x11, "XDestroyWindow", &*destroy);
    decltype(&XFree) free_list = function(x11, "XFree", &*free_list);
    decltype(&glXGetProcAddressARB) find = function(glx, "glXGetProcAddressARB", &*find);
    decltype(&glXChooseFBConfig) choose = function(glx, "glXChooseFBConfig", &*choose);
    decltype(&glXGetVisualFromFBConfig) visual =
        function(glx, "glXGetVisualFromFBConfig", &*visual);
    decltype(&glXMakeCurrent) make = function(glx, "glXMakeCurrent", &*make);
    decltype(&glXDestroyContext) destroy_context =
        function(glx, "glXDestroyContext", &*destroy_context);
    Display* display = nullptr;
    Colormap map = 0;
    Window window = 0;
    GLXContext context = nullptr;
    XrGraphicsBindingOpenGLXlibKHR bound{
        XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR, nullptr, {}, {}, {}, {}, {}};
};

GlxPlatform::GlxPlatform()
{
    threads();  // the runtime may use the display from other threads
    display = open(nullptr);
    if (!display)
        throw std::runtime_error("no X display (DISPLAY is not set, or cannot be opened)");
    try {
        start();
    } catch (...) {
        free_all();
        throw;
    }
}

void GlxPlatform::start()
{
    const int kind[] = {GLX_X_RENDERABLE,
                        True,
                        GLX_DRAWABLE_TYPE,
                        GLX_WINDOW_BIT,
                        GLX_RENDER_TYPE,
                        GLX_RGBA_BIT,
                        GLX_RED_SIZE,
                        8,
                        GLX_GREEN_SIZE,
                        8,
                        GLX_BLUE_SIZE,
                        8,
                        GLX_DOUBLEBUFFER,
                        True,
                        None};
    int count = 0;
    GLXFBConfig* configs = choose(display, DefaultScreen(display), kind, &count);
    if (!configs || count < 1) throw std::runtime_error("the X display has no GLX configuration");
    const GLXFBConfig config = configs[0];
    free_list(configs);
    XVisualInfo* looks = visual(display, config);
    if (!looks) throw std::runtime_error("the GLX configuration has no visual");
    const Window root = RootWindow(display, looks->screen);
    XSetWindowAttributes about{};
    map = about.colormap = colours(display, root, looks->visual, AllocNone);
    window = create(display, root, 0, 0, 16, 16, 0, looks->depth, InputOutput, looks->visual,
                    CWColormap | CWBorderPixel, &about);
    const auto identifier = looks->visualid;
    free_list(looks);
    const auto by_attributes = reinterpret_cast<CreateContext*>(
        find(reinterpret_cast<const GLubyte*>("glXCreateContextAttribsARB")));
    const int wanted[] = {GLX_CONTEXT_MAJOR_VERSION_ARB,
                          4,
                          GLX_CONTEXT_MINOR_VERSION_ARB,
                          5,
                          GLX_CONTEXT_PROFILE_MASK_ARB,
                          GLX_CONTEXT_CORE_PROFILE_BIT_ARB,
                          None};
    if (by_attributes) context = by_attributes(display, config, nullptr, True, wanted);
    if (!context) throw std::runtime_error("no context of OpenGL 4.5 core by GLX");
    bound.xDisplay = display, bound.visualid = std::uint32_t(identifier);
    bound.glxFBConfig = config, bound.glxDrawable = window, bound.glxContext = context;
    make_current();
}

void GlxPlatform::free_all()
{
    if (context) {
        make(display, None, nullptr);
        destroy_context(display, context);
    }
    if (window) destroy(display, window);
    if (map) free_colours(display, map);
    close(display);
}

}  // namespace

std::unique_ptr<Platform> glx_platform() { return std::make_unique<GlxPlatform>(); }
#else
std::unique_ptr<Platform> glx_platform()
{
    throw std::runtime_error("this program was built without GL/glx.h and X11/Xlib.h");
}
#endif
}  // namespace knead::xr
