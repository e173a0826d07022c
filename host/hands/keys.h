// Key frames of a generated hand. At each key the hand is at rest, at a given distance from a ball
// or depth in it.
#pragma once
#include <string>
#include <vector>

#include "host/hands/posture.h"

namespace knead {

// Grasp of the ball, in the wrist's frame: the point placed on the ball's axis, the pressing
// direction, and a second direction that fixes the rotation about it.
struct Grasp {
    Rig rig;
    Vec3<double> point, press, along;
};

// Bare hand pressing with its palm; `ahead` [m]: distance of the pressing point from the wrist
// along the middle finger: 0.03 the heel, 0.08 below the knuckles, 0.13 the fingers.
Grasp bare(Topology topology, Side side, double ahead);
// Bare hand reaching ahead with the tips of thumb and index.
Grasp tips(Topology topology, Side side, const Fingers& fingers);
// A rod, pressed with the end on the side of the thumb.
Grasp stick(Side side, const Fingers& grip);
// A flat tool, pressed with the face or edge that points away from the palm.
Grasp face(const std::string& tool, Side side, const Fingers& grip);
Grasp edge(const std::string& tool, Side side, const Fingers& grip);

// A key: the hand at rest, with its orientation, the wrist's position relative to the ball's centre
// in the hand's own frame, and its fingers. Orientation and position are interpolated separately
// between keys, so that a rotating hand moves around the ball.
struct Key {
    double time;  // [s]
    Quat<double> q;
    Vec3<double> place;  // [m]
    Fingers fingers;
};

// The motion of one hand, built key by key. Slides [m] are offsets from the ball's axis, in the
// wrist's frame.
class Part {
  public:
    Part(Side side, double radius) : side_(side), radius_(radius) {}

    Side side() const { return side_; }
    const std::vector<Key>& keys() const { return keys_; }

    // Sets the grasp for the following keys, rotated to these directions in the world.
    void take(const Grasp& grasp, Vec3<double> press, Vec3<double> along);
    // Key at `time` with the rig `gap` [m] from the ball; negative: that deep in it.
    void reach(double time, const Fingers& fingers, double gap, Vec3<double> slide = {});
    // Distance [m] of the grasp's point from the ball's centre for that gap.
    double distance(const Fingers& fingers, double gap, Vec3<double> slide = {}) const;
    // Key at `time` with the grasp's point `distance` [m] from the ball's centre.
    void put(double time, const Fingers& fingers, double distance, Vec3<double> slide = {});
    // Key at `time` with the hand as at the last key, `back` [m] further from the ball.
    void stay(double time, const Fingers& fingers, double back = 0);

  private:
    Vec3<double> place(double distance, Vec3<double> slide) const;
    double gap_at(const Fingers& fingers, double distance, Vec3<double> slide) const;

    Side side_;
    double radius_;  // of the ball [m]
    Grasp grasp_{};
    Quat<double> q_{1, 0, 0, 0};
    std::vector<Key> keys_;
};

}  // namespace knead
