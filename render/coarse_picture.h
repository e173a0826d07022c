// A live picture of fewer pixels, stretched over the window, for machines that cannot draw all of
// them in time.
#pragma once
#include <memory>

#include "render/eye_painter.h"

namespace knead {

class CoarsePicture {
  public:
    virtual ~CoarsePicture() = default;
    static std::unique_ptr<CoarsePicture> open();  // in the context that is current
    // Draws the view into the window's framebuffer, from such a share of its pixels a side.
    // `keep`: repeat() can show it again, without drawing it.
    virtual void paint(EyePainter& painter, const EyeView& view, const EyeLook& look, double scale,
                       bool keep = false) = 0;
    virtual void repeat() = 0;
};

}  // namespace knead
