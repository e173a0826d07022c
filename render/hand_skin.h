// A smooth skin over the medial hand, with a forearm, as a mesh that moves with the joints. It is
// only seen: what touches clay are the primitives that it is laid over.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "host/hands/hands.h"
#include "host/surface/mesh.h"

namespace knead {

class HandSkin {
  public:
    // Over hand_rig(topology, side) in the pose of open_hand(side), by the surface of the union of
    // its primitives, smoothed.
    HandSkin(Topology topology, Side side);

    // Where the joints of both hands, side by side, put it; `zoom` as of HandsOptions; `stretch`:
    // how large the hand is against the default one. One mesh of category 0.
    Mesh posed(const std::vector<Joint<double>>& joints, double zoom,
               Stretch<float> stretch = {}) const;

    std::size_t vertices() const { return skinned_.size(); }

  private:
    void lay_on(const Hand& open, Side side);
    // A vertex hangs on spheres, as the primitives between them do: on what these shares of the
    // centres add up to, by an offset that turns with the joints.
    static constexpr int most = 6;
    struct Skinned {
        int sphere[most];
        float share[most];  // sum 1
        int joint[4];
        float weight[4];                   // sum 1
        Vec3<float> offset[4], normal[4];  // in the joints' frames
        float rise[2];                     // along the normal, of thin and of thick fingers [m]
    };
    Rig rig_;  // with a forearm; at real size
    std::vector<Skinned> skinned_;
    std::vector<Int3> triangles_;
};

// Made when it is first asked for, then kept.
const HandSkin& hand_skin(Topology topology, Side side);

}  // namespace knead
