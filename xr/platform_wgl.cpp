// OpenGL by WGL on Windows, with a window that is never shown. Compiled on Windows only; not yet
// run.
#include <stdexcept>

#include "xr/platform.h"

#ifdef _WIN32
#include <windows.h>

#define XR_USE_PLATFORM_WIN32
#include "xr/openxr.h"
#endif

namespace knead::xr {
#ifdef _WIN32
namespace {

using CreateContext = HGLRC(WINAPI)(HDC, HGLRC, const int*);

// GL 1.1 functions come from opengl32.dll, all later ones from wglGetProcAddress.
Headset::GlFunction gl_function(const char* name)
{
    if (const PROC found = wglGetProcAddress(name))
        return reinterpret_cast<Headset::GlFunction>(found);
    std::string reason;
    return reinterpret_cast<Headset::GlFunction>(function_of_library("opengl32.dll", name, reason));
}

class WglPlatform : public Platform {
  public:
    WglPlatform();
    ~WglPlatform() override
    {
        wglMakeCurrent(nullptr, nullptr);
        if (context) wglDeleteContext(context);
        if (surface) ReleaseDC(window, surface);
        if (window) DestroyWindow(window);
    }
    const char* name() const override { return "WGL"; }
    const char* extension() const override { return ""; }
    const void* binding() const override { return &bound; }
    void make_current() override
    {
        if (!wglMakeCurrent(surface, context))
            throw std::runtime_error("the context cannot be made current");
    }
    Headset::GlAddress address() const override { return gl_function; }

  private:
    HWND window = nullptr;
    HDC surface = nullptr;
    HGLRC context = nullptr;
    XrGraphicsBindingOpenGLWin32KHR bound{
        XR_TYPE_GRAPHICS_BINDING_OPENGL_WIN32_KHR, nullptr, {}, {}};
};

WglPlatform::WglPlatform()
{
    window = CreateWindowA("STATIC", "knead", WS_POPUP, 0, 0, 16, 16, nullptr, nullptr,
                           GetModuleHandle(nullptr), nullptr);
    surface = window ? GetDC(window) : nullptr;
    PIXELFORMATDESCRIPTOR format{};
    format.nSize = sizeof format;
    format.nVersion = 1;
    format.dwFlags = PFD_DRAW_TO_WINDOW | PFD_SUPPORT_OPENGL | PFD_DOUBLEBUFFER;
    format.cColorBits = 32;
    if (!surface || !SetPixelFormat(surface, ChoosePixelFormat(surface, &format), &format))
        throw std::runtime_error("no window that OpenGL can draw to");
    // wglCreateContextAttribsARB can only be loaded with a current context.
    const HGLRC first = wglCreateContext(surface);
    wglMakeCurrent(surface, first);
    const auto by_attributes =
        reinterpret_cast<CreateContext*>(wglGetProcAddress("wglCreateContextAttribsARB"));
    const int wanted[] = {0x2091, 4, 0x2092, 5, 0x9126, 1, 0};  // version 4.5, core profile
    if (by_attributes) context = by_attributes(surface, nullptr, wanted);
    wglMakeCurrent(nullptr, nullptr);
    wglDeleteContext(first);
    if (!context) throw std::runtime_error("no context of OpenGL 4.5 core by WGL");
    bound.hDC = surface, bound.hGLRC = context;
    make_current();
}

}  // namespace

std::unique_ptr<Platform> wgl_platform() { return std::make_unique<WglPlatform>(); }
#else
std::unique_ptr<Platform> wgl_platform() { throw std::runtime_error("WGL is a way of Windows"); }
#endif
}  // namespace knead::xr
