// Gestures of closed hands: a fist grabs the nearest object and carries it as a rigid body, two
// fists zoom the scene. Meanwhile hands touch nothing. Independent of the simulation.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "cuda/mpm/edit.h"
#include "host/hands/hands_options.h"
#include "host/surface/mesh.h"

namespace knead {

// Closure of a hand: 0 flat, 1 a fist; 0 if its joints are not tracked.
float closure(const Hand& hand);

class Carry {
  public:
    static constexpr float closes = 0.7f, opens = 0.45f;  // closure at which a fist begins and ends
    static constexpr float reach = 0.08f;  // from the palm to the clay [m] of the user's size

    struct Answer {
        // Category of the clay that is held, and its motion in the simulation's frame: a rotation,
        // then a shift.
        std::optional<int> category;
        RigidMotion<double> motion{};
        double zoom = 1;      // factor by which to divide the zoom of the hands
        bool took = false;    // clay was grabbed in this frame
        bool let_go = false;  // clay was released in this frame
    };
    // One frame of both hands, in the tracker's frame; `clay`: current surfaces, in the
    // simulation's.
    Answer frame(const HandFrame& hands, const HandsOptions& options,
                 const std::vector<Mesh>& clay);
    bool holds() const { return category.has_value(); }

  private:
    void close(const HandFrame& hands);
    Answer carry(const Joint<double>& palm, const std::vector<Mesh>& clay, double nearest);

    std::array<bool, side_count> fist{};
    std::optional<int> category;        // of the clay that is held
    Side by = right;                    // whose fist holds it
    std::optional<Joint<double>> last;  // the palm, in the simulation's frame
    double apart = 0;                   // distance of both fists [m]; 0: there were not two
};

}  // namespace knead
