// A smooth skin over the medial hand, with a forearm: a mesh skinned to the joints. For display
// only; contact uses the primitives beneath it.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "host/hands/hands.h"
#include "host/surface/mesh.h"

namespace knead {

class HandSkin {
  public:
    // The smoothed surface of the union of the primitives of hand_rig(topology, side), in the pose
    // of open_hand(side).
    HandSkin(Topology topology, Side side);

    // The skin for the joints of both hands (side * joint_count + joint); `zoom` as in
    // HandsOptions; `stretch`: size of the hand over the default one. Returns one mesh of category
    // 0.
    Mesh posed(const std::vector<Joint<double>>& joints, double zoom,
               Stretch<float> stretch = {}) const;

    std::size_t vertices() const { return skinned_.size(); }

  private:
    void lay_on(const Hand& open, Side side);
    // Skinning of a vertex: a weighted mean of sphere centres, plus an offset rotated by the
    // joints.
    static constexpr int most = 6;
    struct Skinned {
        int sphere[most];
        float share[most];  // sum 1
        int joint[4];
        float weight[4];                   // sum 1
        Vec3<float> offset[4], normal[4];  // in the joints' frames
        float rise[2];  // displacement along the normal for thin and thick fingers [m]
    };
    Rig rig_;  // with a forearm; at real size
    std::vector<Skinned> skinned_;
    std::vector<Int3> triangles_;
};

// Created at first use and cached. Thread-safe.
const HandSkin& hand_skin(Topology topology, Side side);

}  // namespace knead
