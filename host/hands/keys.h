// How a made hand moves: keys at which it rests, each placed so that it stands as near to a ball,
// or as deep in it, as asked.
#pragma once
#include <string>
#include <vector>

#include "host/hands/posture.h"

namespace knead {

// How a hand meets the ball, in the frame of its wrist: the point that is brought onto the ball's
// axis, the direction in which it presses, and a second direction to turn it by.
struct Grasp {
    Rig rig;
    Vec3<double> point, press, along;
};

// The bare hand pressing with its palm; `ahead` [m] is how far the pressing point lies from the
// wrist along the middle finger: 0.03 the heel, 0.08 below the knuckles, 0.13 the fingers.
Grasp bare(Topology topology, Side side, double ahead);
// The bare hand reaching ahead with the tips of thumb and index.
Grasp tips(Topology topology, Side side, const Fingers& fingers);
// A rod, pressed with the end on the thumb's side.
Grasp stick(Side side, const Fingers& grip);
// A flat tool, pressed with the face that looks away from the palm, or with the edge that does.
Grasp face(const std::string& tool, Side side, const Fingers& grip);
Grasp edge(const std::string& tool, Side side, const Fingers& grip);

// A moment at which the hand rests: how it is turned, where its wrist stands seen from the ball's
// centre in the hand's own frame, and its fingers. Between two keys turn and place are blended
// apart, so that a hand that turns goes around the ball.
struct Key {
    double time;  // [s]
    Quat<double> q;
    Vec3<double> place;  // [m]
    Fingers fingers;
};

// One hand's part, written key by key. Slides [m] are beside the ball's axis, in the wrist's frame.
class Part {
  public:
    Part(Side side, double radius) : side_(side), radius_(radius) {}

    Side side() const { return side_; }
    const std::vector<Key>& keys() const { return keys_; }

    // The hand's grasp from the next key on, turned to press and point that way in the world.
    void take(const Grasp& grasp, Vec3<double> press, Vec3<double> along);
    // At `time` the rig stands `gap` [m] from the ball; negative: that deep in it.
    void reach(double time, const Fingers& fingers, double gap, Vec3<double> slide = {});
    // How far before the ball's centre [m] the grasp's point must stand for that gap.
    double distance(const Fingers& fingers, double gap, Vec3<double> slide = {}) const;
    // At `time` the grasp's point stands `distance` [m] before the ball's centre.
    void put(double time, const Fingers& fingers, double distance, Vec3<double> slide = {});
    // At `time` the hand is where it was, `back` [m] further from the ball.
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
