// Choosing, moving, turning and scaling objects with hands or controllers: a pure model, from the
// pinch that begins it to its release. The clay is unchanged until then, as with a mouse
// (transform_gesture.h).
#pragma once
#include <optional>
#include <vector>

#include "host/hands/hands.h"
#include "host/ui/hover.h"
#include "host/ui/transform_gesture.h"

namespace knead {

// Scaled and turned about the origin, then displaced.
struct Similarity {
    double scale = 1;
    Quat<double> turn{1, 0, 0, 0};
    Vec3<double> by{};

    Vec3<double> at(Vec3<double> x) const { return by + scale * rotate(turn, x); }
};
// First `a`, then `b`.
Similarity then(const Similarity& a, const Similarity& b);
// What moves a grip with it, from one pose to another.
Similarity motion_between(const Joint<double>& from, const Joint<double>& to);
// What moves both points with two grips. Their turns about the line between them are averaged.
Similarity motion_between(const Joint<double> (&from)[side_count],
                          const Joint<double> (&to)[side_count]);

// A hand in a frame.
struct GrabHand {
    bool tracked = false, pinches = false;
    Joint<double> at{{1, 0, 0, 0}, {0, 0, 0}};  // of the pinch, in the simulation's frame [m]
    std::optional<Hovered> hovers;
};

struct GrabInput {
    GrabHand hands[side_count];
    double time = 0;           // ascending [s]
    double scale = 1;          // simulation metres per metre of the hands
    Side adds = left;          // this hand's pinches add objects to the chosen ones
    bool adds_always = false;  // so do those of both
    bool cancels = false;      // ends a motion without effect
    std::vector<ObjectId> chosen{};
};

struct GrabAnswer {
    enum Choice { unchanged, alone, more, less, none };
    Choice choice = unchanged;
    ObjectId object;      // of `alone`, `more` and `less`
    bool begins = false;  // a motion of the chosen objects has begun
    bool ends = false, cancelled = false;
};

class GrabGesture {
  public:
    static constexpr double still = 0.01;        // a pinch that moves less is a click [m of hands]
    static constexpr double still_angle = 0.14;  // [rad]
    static constexpr double lost_for = 0.5;      // a hand that is lost longer cancels [s]

    GrabAnswer frame(const GrabInput& input);
    // Ends what is under way without effect, until all pinches are released.
    void stop();
    // Objects are being moved.
    bool moves() const { return moves_; }
    // A pinch is closed.
    bool pinches() const { return held_[left] || held_[right]; }
    // Whether a hand's pinch belongs to the gesture.
    bool holds(Side side) const { return held_[side]; }
    // The motion so far.
    Similarity motion() const;

  private:
    void anchor();
    void release(Side side, const GrabInput& input, GrabAnswer& answer);
    void press(Side side, const GrabInput& input, GrabAnswer& answer);

    bool down_[side_count] = {false, false};  // pinched in the frame before
    bool held_[side_count] = {false, false};  // pinches of the gesture
    Joint<double> from_[side_count]{}, to_[side_count]{};
    double seen_[side_count] = {0, 0};  // last time that it was tracked [s]
    Similarity before_;                 // up to the last change of hands
    ObjectId pressed_;                  // object of the first pinch; 0: none
    Side first_ = right;
    bool toggles_ = false;     // the first pinch adds or takes away
    bool was_chosen_ = false;  // before that pinch
    bool moves_ = false;
};

// The motion of chosen objects: each is scaled about its own centre of mass, and all are turned and
// displaced as one.
struct ObjectMotion {
    double factor = 1;
    Quat<double> turn{1, 0, 0, 0};
    Vec3<double> about{}, by{};  // [m]

    Vec3<double> at(Vec3<double> x, Vec3<double> own) const
    {
        return about + by + rotate(turn, own + factor * (x - own) - about);
    }
    // Those that do it, in order, without those that would change nothing: growth at the new place,
    // shrinking at the old one. `origin`: of the simulation's frame in that of the scene's file.
    std::vector<Command> commands(const std::vector<ObjectId>& objects, Vec3<double> origin) const;
    // "Move x 1.0 y 0.0 z 0.0 cm, turn 15 degrees, scale 1.20"
    std::string text() const;
};
// `centre`: the middle of their centres of mass, which follows the motion.
ObjectMotion object_motion(const Similarity& motion, Vec3<double> centre, bool snaps);

}  // namespace knead
