// A live picture drawn at reduced resolution and scaled up to the window, for slow machines.
#pragma once
#include <memory>

#include "render/eye_painter.h"

namespace knead {

class CoarsePicture {
  public:
    virtual ~CoarsePicture() = default;
    // In the current context, which must be current for all calls.
    static std::unique_ptr<CoarsePicture> open();
    // Draws the view at `scale` times its size per side and scales it up into the window's
    // framebuffer. `keep`: repeat() can show it again without drawing.
    virtual void paint(EyePainter& painter, const EyeView& view, const EyeLook& look, double scale,
                       bool keep = false) = 0;
    virtual void repeat() = 0;
};

}  // namespace knead
