// A desktop window with OpenGL 4.5 and panels; the only user of GLFW and Dear ImGui.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/files/image.h"
#include "render/view/input.h"
#include "render/view/panel_model.h"

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
    virtual bool closed() const = 0;
    virtual std::string renderer() const = 0;  // GL_RENDERER
    // False while minimised or not mapped.
    virtual bool visible() const = 0;
    // Returns the input events since the last call. Waits up to `patience` [s] for a window event
    // or wake().
    virtual std::vector<InputEvent> poll(double patience) = 0;
    static void wake();  // thread-safe; precondition: a window is open
    // True if the window must be redrawn since the last call: resized or exposed.
    virtual bool damaged() = 0;

    // Builds the panels of a frame from `input`; then mouse_taken() and keys_taken() are true if
    // the panels use that input. `seconds`: time since the last frame.
    virtual PanelRequests panels(PanelModel& model, const InputState& input, double seconds) = 0;
    // Width covered by the panels at the left edge [pixels].
    virtual int panels_width() const = 0;
    virtual bool mouse_taken() const = 0;
    virtual bool keys_taken() const = 0;
    // Draws the panels over the framebuffer.
    virtual void draw_panels() = 0;
    virtual Image image() = 0;  // copy of the framebuffer; call before show()
    virtual void show() = 0;
    virtual int gl_errors() = 0;    // number since the last call
    virtual bool lost() const = 0;  // the GL context was reset: all its objects are gone
};

}  // namespace knead
