// A desktop window with OpenGL 4.5; the only user of GLFW.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/files/image.h"
#include "render/view/input.h"

namespace knead {

class Window {
  public:
    // Opens a window, makes its context current on this thread and loads OpenGL. Throws
    // ResourceError with the reason: no screen, GLFW (libglfw.so.3) or OpenGL 4.5, or a build
    // without window.
    static std::unique_ptr<Window> open(const std::string& title, int width, int height);
    virtual ~Window() = default;

    virtual int width() const = 0;  // of the framebuffer [pixels]
    virtual int height() const = 0;
    virtual std::string renderer() const = 0;  // GL_RENDERER
    // False while minimised or not mapped.
    virtual bool visible() const = 0;
    // Size of text and controls that the display asks for; 1: 96 dots per inch. May change while
    // the window is open: damaged() is true then.
    virtual double content_scale() const = 0;
    virtual void set_title(const std::string& text) = 0;
    virtual std::string clipboard() const = 0;  // "": no text
    virtual void set_clipboard(const std::string& text) = 0;
    // Returns the input events since the last call. Waits up to `patience` [s] for a window event
    // or wake(). A request to close the window is one of them, and does not close it.
    virtual std::vector<InputEvent> poll(double patience) = 0;
    static void wake();  // thread-safe; precondition: a window is open
    // True if the window must be redrawn since the last call: resized, exposed or
    // with another content scale.
    virtual bool damaged() = 0;

    virtual Image image() = 0;  // copy of the framebuffer; call before show()
    virtual void show() = 0;
    virtual int gl_errors() = 0;    // number since the last call
    virtual bool lost() const = 0;  // the GL context was reset: all its objects are gone
};

}  // namespace knead
