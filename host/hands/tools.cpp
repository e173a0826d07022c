// Tools as medial primitives, in a natural grip. Real sizes [m], right hand; mirrored for the left.
#include <stdexcept>

#include "host/hands/rig.h"

namespace knead {
namespace {

// A sphere in the frame of one joint: -z ahead, -y out of the palm or the finger pad.
struct Piece {
    JointName joint;
    Vec3<float> c;  // [m]
    float r;        // [m]
};
struct Design {
    const char* name;
    std::vector<Piece> spheres;
    std::vector<Primitive> primitives;
    std::vector<Piece> handle{};  // cones of two spheres each; drawn only
};

constexpr float half_blade = 0.0005f;  // blades are 1 mm thick

// Two blades of 80 x 12 x 1 mm, one ahead of the index finger and one ahead of the thumb, both in
// the plane of the two pointing directions, edge to edge, offset by a blade's thickness so that
// they pass each other. Their normals agree, so that both assign the same sides of a cut.
std::vector<Piece> scissor_blades()
{
    const Hand hand = open_hand(right);
    const auto ahead = [&](JointName j) { return rotate(hand.joints[j].q, Vec3<float>{0, 0, -1}); };
    const Vec3<float> wide = cross(ahead(index_distal), ahead(thumb_distal));
    const Vec3<float> normal = (1 / length(wide)) * wide;
    std::vector<Piece> pieces;
    for (const JointName j : {index_distal, thumb_distal}) {
        const bool index = j == index_distal;
        const Vec3<float> u = ahead(j);
        const Vec3<float> inwards = index ? cross(normal, u) : cross(u, normal);
        const Vec3<float> aside = (index ? half_blade : -half_blade) * normal;
        const auto add = [&](float along, float across) {
            const Vec3<float> c = along * u + across * inwards + aside;
            pieces.push_back({j, rotate(conjugate(hand.joints[j].q), c), half_blade});
        };
        add(0.01f, index ? 0.006f : -0.006f);
        add(0.01f, index ? -0.006f : 0.006f);
        add(0.09f, 0);
    }
    return pieces;
}

const std::vector<Design>& designs()
{
    static const std::vector<Design> all = {
        // A paddle of 90 x 130 x 10 mm lying flat in the palm and under the fingers, to press with.
        {"slab",
         {{palm, {-0.04f, -0.03f, 0.01f}, 0.005f},
          {palm, {0.04f, -0.03f, 0.01f}, 0.005f},
          {palm, {0.04f, -0.03f, -0.11f}, 0.005f},
          {palm, {-0.04f, -0.03f, -0.11f}, 0.005f}},
         {{3, {0, 1, 2}, 0}, {3, {0, 2, 3}, 0}}},
        // 24 cm long, 10 mm in radius, across the palm: a rolling pin.
        {"rod",
         {{palm, {-0.11f, -0.03f, -0.02f}, 0.01f}, {palm, {0.11f, -0.03f, -0.02f}, 0.01f}},
         {{2, {0, 1, 1}, 0}}},
        // 10 cm from a base of 20 mm radius to a point of 1 mm, ahead of the index finger.
        {"cone",
         {{index_distal, {0, -0.01f, -0.04f}, 0.02f}, {index_distal, {0, -0.01f, -0.14f}, 0.001f}},
         {{2, {0, 1, 1}, 0}},
         {{index_distal, {0, -0.01f, 0.03f}, 0.006f}, {index_distal, {0, -0.01f, -0.05f}, 0.006f}}},
        // A ball of 8 mm radius on a rod of 2.5 mm radius, under the index finger's pad like a pen.
        {"ball",
         {{index_distal, {0, -0.01f, 0.02f}, 0.0025f},
          {index_distal, {0, -0.01f, -0.07f}, 0.0025f},
          {index_distal, {0, -0.01f, -0.07f}, 0.008f}},
         {{2, {0, 1, 1}, 0}, {1, {2, 2, 2}, 0}}},
        // A blade of 120 x 30 x 1 mm ahead of the fist, upright, its edge below.
        {"knife",
         {{palm, {0, -0.015f, -0.07f}, half_blade},
          {palm, {0, -0.045f, -0.07f}, half_blade},
          {palm, {0, -0.045f, -0.19f}, half_blade},
          {palm, {0, -0.015f, -0.15f}, half_blade}},
         {{3, {0, 1, 3}, 0}, {3, {1, 2, 3}, 0}},
         {{palm, {0, -0.03f, 0.035f}, 0.011f}, {palm, {0, -0.03f, -0.068f}, 0.010f}}},
        {"scissors",
         scissor_blades(),
         {{3, {0, 1, 2}, 0}, {3, {3, 4, 5}, 0}},
         {{index_distal, {0, -0.004f, 0.012f}, 0.0035f},
          {index_distal, {0, 0, -0.014f}, 0.002f},
          {thumb_distal, {0, -0.004f, 0.012f}, 0.0035f},
          {thumb_distal, {0, 0, -0.014f}, 0.002f}}},
    };
    return all;
}

const Design& design_of(const std::string& name)
{
    std::string known;
    for (const Design& design : designs()) {
        if (design.name == name) return design;
        known += (known.empty() ? "" : ", ") + std::string(design.name);
    }
    throw std::invalid_argument("unknown tool \"" + name + "\"; expected one of: " + known);
}

Rig hung(const std::vector<Piece>& pieces, const std::vector<Primitive>& primitives, Side side)
{
    Rig rig{{}, primitives};
    for (const Piece& piece : pieces) {
        const int j = int(side) * joint_count + piece.joint;
        const float x = side == right ? piece.c.x : -piece.c.x;
        const Vec3<float> c{x, piece.c.y, piece.c.z};
        rig.spheres.push_back({{j, j, j, j}, {1, 0, 0, 0}, {c, c, c, c}, piece.r});
    }
    return rig;
}

}  // namespace

std::vector<std::string> tool_names()
{
    std::vector<std::string> names;
    for (const Design& design : designs()) names.push_back(design.name);
    return names;
}

Rig tool_rig(const std::string& name, Side side)
{
    const Design& design = design_of(name);
    return hung(design.spheres, design.primitives, side);
}

Rig tool_handle(const std::string& name, Side side)
{
    const Design& design = design_of(name);
    std::vector<Primitive> cones;
    for (int i = 0; i + 1 < int(design.handle.size()); i += 2)
        cones.push_back({2, {i, i + 1, i + 1}, 0});
    return hung(design.handle, cones, side);
}

}  // namespace knead
