// Gestures of closed hands: a fist takes the nearest clay and lets it go again. Independent of the
// simulation, which moves what is carried (scene_editor.h).
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "host/hands/hands_options.h"
#include "host/surface/mesh.h"

namespace knead {

// Closure of a hand: 0 flat, 1 a fist; 0 if its joints are not tracked.
float closure(const Hand& hand);
// Of one finger, which is not the thumb, by its tip.
float closure(const Hand& hand, JointName tip);

class FistGesture {
  public:
    static constexpr float closes = 0.7f, opens = 0.45f;  // closure at which a fist begins and ends
    static constexpr float reach = 0.08f;  // from the palm to the clay [m] of the user's size

    struct Answer {
        std::optional<int> took;  // category of the clay that was grabbed in this frame
        bool let_go = false;      // clay was released in this frame
        Side by = right;          // whose fist took it or let it go
    };
    // One frame of both hands, in the tracker's frame; `clay`: current surfaces, in the
    // simulation's. Two fists take nothing: they move the scene.
    Answer frame(const HandFrame& hands, const HandsOptions& options,
                 const std::vector<Mesh>& clay);
    bool holds() const { return holding; }

  private:
    void close(const HandFrame& hands);

    std::array<bool, side_count> fist{};
    bool holding = false;
    Side by = right;  // whose fist holds
};

}  // namespace knead
