// A window of the desktop with OpenGL 4.5 and panels: GLFW and Dear ImGui are behind it alone.
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
    // Opens it and makes its context current on this thread; OpenGL is loaded. Throws ResourceError
    // with the reason where there is no screen, no GLFW (libglfw.so.3) or no OpenGL 4.5, or where
    // this build has no window.
    static std::unique_ptr<Window> open(const std::string& title, int width, int height);
    virtual ~Window() = default;

    virtual int width() const = 0;  // of what is drawn into [pixels]
    virtual int height() const = 0;
    virtual bool closed() const = 0;
    virtual std::string renderer() const = 0;  // as OpenGL names it
    // False while nobody can see it: minimised, or not mapped.
    virtual bool visible() const = 0;
    // What a person did since the last call. Waits up to `patience` [s] for something to happen to
    // the window, or for wake().
    virtual std::vector<InputEvent> poll(double patience) = 0;
    static void wake();  // while a window is open; any thread may call it
    // Whether it has to be drawn anew since the last call: its size changed, or what covered it
    // went.
    virtual bool damaged() = 0;

    // The panels of a frame, which take what `input` has for them: afterwards it is theirs where
    // mouse_taken() or keys_taken() say so. `seconds` since the last frame.
    virtual PanelRequests panels(PanelModel& model, const InputState& input, double seconds) = 0;
    // What they hide at the left edge [pixels].
    virtual int panels_width() const = 0;
    virtual bool mouse_taken() const = 0;
    virtual bool keys_taken() const = 0;
    // Draws the panels over what is there.
    virtual void draw_panels() = 0;
    virtual Image image() = 0;  // what was drawn, before it is shown
    virtual void show() = 0;
    virtual int gl_errors() = 0;    // since the last call
    virtual bool lost() const = 0;  // the context: all that belongs to it is gone
};

}  // namespace knead
