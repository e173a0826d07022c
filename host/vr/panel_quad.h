// Textured rectangle in the scene, drawn after an EyePainter with depth test.
#pragma once
#include <array>

#include "host/vr/headset_view.h"
#include "host/vr/panel_text.h"
#include "render/eye_painter.h"
#include "render/gl.h"

namespace knead {

class PanelQuad {
  public:
    // Precondition: a context is current and load_gl() was called.
    PanelQuad(int width, int height, bool srgb);
    void upload(const PanelCanvas& canvas);
    // `corners`: upper left, upper right, lower left, lower right, in the eye's world [m].
    // `target`: as drawn by EyePainter; its depth is near / distance.
    void draw(const std::array<Vec3<float>, 4>& corners, const EyeView& view,
              const EyeTarget& target) const;

  private:
    Program drawn;
    Texture picture;
    VertexArray nothing;
};

}  // namespace knead
