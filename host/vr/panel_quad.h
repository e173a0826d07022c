// Textured rectangles in the scene.
#pragma once
#include <array>

#include "host/vr/headset_view.h"
#include "host/vr/panel_texture.h"
#include "render/eye_painter.h"
#include "render/gl.h"

namespace knead {

class PanelQuad {
  public:
    // Precondition: a context is current and load_gl() was called.
    PanelQuad();
    // Opaque, nearer or not than what was drawn before, which it replaces; writes its depth. For
    // EyePainter::DrawBetween: hands come after it. `corners` as below, `target` linear. Panels
    // that overlap are drawn from the farthest to the nearest.
    void draw(const std::array<Vec3<float>, 4>& corners, const EyeView& view,
              const EyeTarget& target, const PanelTexture& picture) const;

  private:
    Program drawn;
    VertexArray nothing;
};

}  // namespace knead
