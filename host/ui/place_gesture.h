// Putting down an object that is added: with a hand until its pinch opens, or with the mouse on
// what is below the pointer. Pure models.
#pragma once
#include <optional>

#include "host/picture/outline.h"
#include "host/ui/grab_gesture.h"

namespace knead {

// The object's centre where its box rests on a surface, `gap` above it [m].
Vec3<double> resting_on(const SceneObject& object, const TransformSurface& on, double gap);
// The object at a place, in the frame of the scene's file. `origin`: of the simulation's frame in
// that.
SceneObject placed(const SceneObject& object, Vec3<double> centre, Vec3<double> origin);
// Its outline in the simulation's frame: the corners of its box, and ellipses around round shapes.
// `thick`: width of the lines [m].
Mesh object_outline(const SceneObject& object, Vec3<double> centre, double thick);

// The object is with the hand that pinched last, at the beginning with the one that `usual` names.
class PlaceGesture {
  public:
    enum Answer { goes_on, placed, cancelled };
    struct Input {
        GrabHand hands[side_count];
        bool cancels = false, snaps = false;
        Side usual = right;
    };
    Answer frame(const Input& input);
    // Where the object is; nothing: no hand was tracked yet.
    const std::optional<Vec3<double>>& at() const { return at_; }

  private:
    std::optional<Vec3<double>> at_;
    std::optional<Side> by_;
    bool down_[side_count] = {true, true};  // a hand that pinches already must open first
    bool pinched_ = false;
};

}  // namespace knead
