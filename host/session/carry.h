// Holding clay as a whole: a fist takes hold of the nearest object and carries it, two fists draw
// the scene larger or smaller. Meanwhile hands touch nothing. Knows no simulation.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "cuda/mpm/edit.h"
#include "host/hands/hands_options.h"
#include "host/surface/mesh.h"

namespace knead {

// How far a hand is closed: 0 flat, 1 a fist. 0 where its joints are not known.
float closure(const Hand& hand);

class Carry {
  public:
    static constexpr float closes = 0.7f, opens = 0.45f;  // closure where a fist begins, ends
    static constexpr float reach = 0.08f;  // from the palm to the clay [m] of the user's size

    struct Answer {
        // Carries what was taken: a rotation, then a shift, in the simulation's frame.
        std::optional<int> category;
        RigidMotion<double> motion{};
        double zoom = 1;    // the hands' zoom is to be divided by that
        bool took = false;  // hold of clay, in this frame
        bool let_go = false;
    };
    // One frame of both hands, in the frame of the hands; `clay` is where it is now.
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
    double apart = 0;                   // of both fists [m]; 0: there were not two
};

}  // namespace knead
