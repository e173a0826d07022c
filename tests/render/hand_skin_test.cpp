// The skin of a hand lies on the primitives that touch, open and bent, and is one closed piece.
#include "render/hand_skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "host/hands/posture.h"

namespace knead {
namespace {

// Both hands; those of `side` posed.
std::vector<Joint<double>> joints_of(Side side, const Joint<double>& at, const Fingers& fingers,
                                     double zoom)
{
    std::vector<Joint<double>> joints(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}});
    const Pose pose = posed(side, at, fingers);
    for (int j = 0; j < joint_count; ++j) {
        Joint<double>& to = joints[std::size_t(int(side) * joint_count + j)];
        to = {pose[std::size_t(j)].q, zoom * pose[std::size_t(j)].p};
    }
    return joints;
}

// Distances of the vertices from the medial hand of a user's size, those behind the wrist left out;
// sorted. Those inside are negative.
std::vector<double> distances(Topology topology, Side side, const Fingers& fingers,
                              Stretch<float> size = {})
{
    const auto joints = joints_of(side, {{1, 0, 0, 0}, {0, 0, 0}}, fingers, double(size.along));
    const Mesh mesh = hand_skin(topology, side).posed(joints, 1, size);
    const Rig rig = hand_rig(topology, side);
    std::vector<Sphere<float>> s;
    for (const Binding<float>& as_fitted : rig.spheres) {
        const Binding<float> b = stretched(as_fitted, size);
        s.push_back({centre(b, [&](int j) { return cast<float>(joints[std::size_t(j)]); }),
                     {},
                     {},
                     b.radius,
                     0});
    }
    std::vector<Shape<float>> shapes;
    for (const Primitive& p : rig.primitives)
        shapes.push_back(shape(p.count, s[std::size_t(p.sphere[0])], s[std::size_t(p.sphere[1])],
                               s[std::size_t(p.sphere[2])]));
    std::vector<double> all;
    for (const Vec3<float>& v : mesh.vertices) {
        if (v.z > -0.02f) continue;
        float least = 1e30f;
        for (const Shape<float>& one : shapes) least = min(least, closest_point(one, v).phi);
        all.push_back(double(least));
    }
    std::sort(all.begin(), all.end());
    return all;
}

TEST(HandSkin, LiesOnTheMedialHandOpenAndBent)
{
    const struct {
        Fingers fingers;
        double p95, most;  // [m]
    } cases[] = {{Fingers{}, 0.0005, 0.002}, {gripped(0.4), 0.0015, 0.004}};
    for (const Side side : {left, right})
        for (const auto& c : cases) {
            std::vector<double> all = distances(Topology::h25, side, c.fingers);
            ASSERT_GT(all.size(), 2000u);
            for (double& d : all) d = std::abs(d);
            std::sort(all.begin(), all.end());
            EXPECT_LT(all[all.size() * 95 / 100], c.p95);
            EXPECT_LT(all.back(), c.most);
        }
}

// In proportion; where fingers are thick or thin for their length, too, but for a few points of
// creases, which open or close.
TEST(HandSkin, LiesOnTheMedialHandOfAnySize)
{
    const struct {
        Stretch<float> size;
        double most;  // outside [m]
    } cases[] = {{{0.8f, 0.8f}, 0.0009},   {{1.25f, 1.25f}, 0.0013}, {{0.95f, 1.05f}, 0.0018},
                 {{1.05f, 0.95f}, 0.0011}, {{0.9f, 1.1f}, 0.0024},   {{1.1f, 0.9f}, 0.0011}};
    for (const Topology topology : {Topology::h25, Topology::h47})
        for (const auto& [size, most] : cases) {
            SCOPED_TRACE(testing::Message() << size.across << " across, " << size.along);
            const std::vector<double> all = distances(topology, right, Fingers{}, size);
            const auto first = std::lower_bound(all.begin(), all.end(), 0.0);
            const double p95 = *(first + (all.end() - first) * 95 / 100);
            const double p5 = *(all.begin() + (first - all.begin()) * 5 / 100);
            if (std::getenv("KNEAD_SHOW"))
                std::printf("%g x %g: outside %.2f, most %.2f; inside %.2f, most %.2f mm\n",
                            double(size.across), double(size.along), 1e3 * p95, 1e3 * all.back(),
                            -1e3 * p5, -1e3 * all.front());
            const auto far = all.end() - std::upper_bound(all.begin(), all.end(), 0.001);
            if (std::getenv("KNEAD_SHOW"))
                std::printf("  farther than 1 mm: %ld of %zu\n", long(far), all.size());
            EXPECT_LE(far, 8);
            EXPECT_LT(p95, 0.0003);
            EXPECT_GT(p5, -0.0004);
            EXPECT_LT(all.back(), most);
            EXPECT_GT(all.front(), -0.004);
        }
}

TEST(HandSkin, IsClosedAndTurnedOutwards)
{
    const auto joints = joints_of(right, {{1, 0, 0, 0}, {0, 0, 0}}, Fingers{}, 1);
    const Mesh mesh = hand_skin(Topology::h47, right).posed(joints, 1);
    EXPECT_EQ(components(mesh), 1);
    // A hand and 9 cm of a forearm.
    EXPECT_GT(volume(mesh), 0.3e-3);
    EXPECT_LT(volume(mesh), 1.2e-3);
    std::map<std::pair<int, int>, int> edges;
    for (const Int3 t : mesh.triangles)
        ++edges[{t.x, t.y}], ++edges[{t.y, t.z}], ++edges[{t.z, t.x}];
    for (const auto& [edge, times] : edges) {
        EXPECT_EQ(times, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
}

TEST(HandSkin, MovesAsAWholeWithTheHandAndItsZoom)
{
    const Fingers bent = gripped(0.5);
    const Mesh still = hand_skin(Topology::h25, left)
                           .posed(joints_of(left, {{1, 0, 0, 0}, {0, 0, 0}}, bent, 1), 1);
    const Quat<double> turn = turn_about(Vec3<double>{0, 0.6, 0.8}, 1.2);
    const Vec3<double> to{0.3, 0.1, -0.2};
    const Mesh moved =
        hand_skin(Topology::h25, left).posed(joints_of(left, {turn, to}, bent, 2.5), 2.5);
    ASSERT_EQ(moved.vertices.size(), still.vertices.size());
    for (std::size_t v = 0; v < still.vertices.size(); v += 7) {
        const Vec3<double> wanted = 2.5 * (to + rotate(turn, cast<double>(still.vertices[v])));
        EXPECT_LT(length(cast<double>(moved.vertices[v]) - wanted), 1e-5);
        const Vec3<double> n = rotate(turn, cast<double>(still.normals[v]));
        EXPECT_LT(length(cast<double>(moved.normals[v]) - n), 1e-5);
    }
}

}  // namespace
}  // namespace knead
