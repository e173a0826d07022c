// Two fists move, turn and zoom the scene as one, without effect on the clay: a pure model.
#pragma once
#include <optional>

#include "host/vr/headset_view.h"

namespace knead {

// Where the frame of the hands is, and how large the scene appears in it.
struct ScenePlace {
    Workplace workplace;
    double zoom = 1;  // simulation metres per metre of the hands
};

class SceneGesture {
  public:
    static constexpr double least = 0.05, largest = 50;  // zoom
    static constexpr double longest_step = 0.1;  // of a fist in a frame: else it is lost [m]

    // Both fists in the headset's frame [m]; none: there are not two. The scene follows them: the
    // point between them stays there, and it turns about the vertical only, so that floors stay
    // level. Returns the new place, or nothing if there are not two fists.
    std::optional<ScenePlace> frame(const std::optional<std::array<Vec3<double>, 2>>& fists,
                                    const ScenePlace& now);

  private:
    std::optional<std::array<Vec3<double>, 2>> last_;
};

}  // namespace knead
