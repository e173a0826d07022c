// Mask of the picture tiles that are not visible through a headset's lens.
#pragma once
#include <array>
#include <vector>

#include "render/eye_painter.h"

namespace knead {

class HiddenTiles {
  public:
    // The hidden area: triangles, three corners each, in tangents (x right, y up).
    void set(const std::vector<std::array<float, 2>>& corners);
    // The tiles of a view's picture, `hidden_tile` pixels a side, rows from the top: 1 if the
    // centres of all pixels of the tile and of its neighbouring tiles are hidden. Empty: no tile is
    // hidden.
    const std::vector<char>& of(const EyeView& view);

  private:
    std::vector<std::array<float, 2>> corners_;
    EyeView view_{};  // whose tiles are kept
    std::vector<char> tiles_, pixels_;
};

}  // namespace knead
