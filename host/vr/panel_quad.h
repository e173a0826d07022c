// A picture on a rectangle in the scene, drawn over what an EyePainter has drawn, behind what is
// nearer.
#pragma once
#include <array>

#include "host/vr/headset_view.h"
#include "host/vr/panel_text.h"
#include "render/eye_painter.h"
#include "render/gl.h"

namespace knead {

class PanelQuad {
  public:
    // In the context that is current, whose functions were found.
    PanelQuad(int width, int height, bool srgb);
    void upload(const PanelCanvas& canvas);
    // `corners`: upper left, upper right, lower left, lower right, in the eye's world [m]. The
    // target is as EyePainter left it, its depth near over distance.
    void draw(const std::array<Vec3<float>, 4>& corners, const EyeView& view,
              const EyeTarget& target) const;

  private:
    Program drawn;
    Texture picture;
    VertexArray nothing;
};

}  // namespace knead
