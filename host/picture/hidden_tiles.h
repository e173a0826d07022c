// The tiles of a picture of splats that no lens shows.
#pragma once
#include <array>
#include <vector>

#include "render/eye_painter.h"

namespace knead {

class HiddenTiles {
  public:
    // What is hidden: triangles, three corners each, in tangents (x right, y up).
    void set(const std::vector<std::array<float, 2>>& corners);
    // Of a view's picture, tiles of `hidden_tile` pixels a side, rows from the top: 1 where all of
    // one, and the pixels around it, have their middles in what is hidden. Empty: none is.
    const std::vector<char>& of(const EyeView& view);

  private:
    std::vector<std::array<float, 2>> corners_;
    EyeView view_{};  // whose tiles are kept
    std::vector<char> tiles_, pixels_;
};

}  // namespace knead
