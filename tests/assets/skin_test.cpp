// Reading a skin and fitting a medial hand to it, on a hand whose shape is known.
#include "host/assets/skin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "host/assets/fit.h"
#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "tests/assets/hand_glb.h"
#include "tests/contact/bent_hand.h"
#include "tests/folder.h"

namespace knead {
namespace {

const HandGlb& known(Side side)
{
    static const HandGlb hands[] = {HandGlb(left), HandGlb(right)};
    return hands[side];
}

class KnownHand : public InFolder {
  protected:
    HandMesh mesh(Side side) const
    {
        const std::string file = path(side == left ? "left.glb" : "right.glb");
        write_whole(file, known(side).bytes());
        return {file, side};
    }
    std::string refused(const HandGlb& hand) const
    {
        write_whole(path("x.glb"), hand.bytes());
        try {
            read_skin(path("x.glb"));
        } catch (const InputError& e) {
            const std::string said = e.what(), start = path("x.glb") + ": ";
            EXPECT_EQ(said.rfind(start, 0), 0u) << said;
            return said.substr(std::min(said.size(), start.size()));
        }
        return "";
    }
};

TEST_F(KnownHand, IsReadInTheFrameOfTheOpenHand)
{
    const auto all = known_shapes();
    for (const Side side : {left, right}) {
        const Skin read = read_skin(mesh(side).path), skin = side == right ? read : mirrored(read);
        ASSERT_EQ(skin.vertices.size(), known(side).vertices.size());
        ASSERT_EQ(skin.triangles.size() * 3, skin.vertices.size());
        for (std::size_t i = 0; i < skin.vertices.size(); i += 7) {
            EXPECT_NEAR(nearest(all, skin.vertices[i]).closest_point.phi, 0, 2e-6);
            double sum = 0;
            for (const double w : skin.weights[i]) {
                EXPECT_GE(w, 0);
                sum += w;
            }
            EXPECT_NEAR(sum, 1, 1e-12);
        }
        const Hand open = open_hand(right);
        for (int j = palm; j < joint_count; ++j) {
            const Joint<double>& joint = skin.joints[j];
            EXPECT_LT(length(joint.p - cast<double>(open.joints[j].p)), j == palm ? 1e-5 : 2e-6)
                << j;
            EXPECT_NEAR(std::abs(joint.q.w * open.joints[j].q.w + joint.q.x * open.joints[j].q.x +
                                 joint.q.y * open.joints[j].q.y + joint.q.z * open.joints[j].q.z),
                        1, 2e-4)
                << j;
        }
    }
}

TEST_F(KnownHand, PointsSpreadEvenlyOverItAndFollowItsJoints)
{
    const Skin skin = read_skin(mesh(right).path);
    const std::vector<SkinPoint> points = spread(skin, 6000);
    EXPECT_GT(points.size(), 4000u);
    EXPECT_LT(points.size(), 6000u);  // without the open end
    const auto all = known_shapes();
    for (const SkinPoint& point : points) {
        EXPECT_NEAR(nearest(all, point.p).closest_point.phi, 0, 3e-4);
        EXPECT_LT(length(follow(skin, point, skin.joints) - point.p), 1e-12);
    }
    std::array<Joint<double>, joint_count> moved = skin.joints;
    for (Joint<double>& joint : moved) joint.p.y += 0.3;
    EXPECT_NEAR(follow(skin, points[0], moved).y, points[0].p.y + 0.3, 1e-12);
}

// As its users have it: spheres that lie in the mesh and reach its skin.
void expect_medial(const FitReport& fit)
{
    const auto all = known_shapes();
    for (std::size_t i = 0; i < fit.spheres.size(); ++i) {
        const FittedSphere& s = fit.spheres[i];
        const double depth = -nearest(all, cast<double>(s.c)).closest_point.phi;
        EXPECT_GT(depth, 0) << i;
        EXPECT_LT(s.r, depth + 3e-3) << i;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
            EXPECT_GE(s.weight[k], 0) << i;
            sum += s.weight[k];
        }
        EXPECT_NEAR(sum, 1, 1e-6) << i;
    }
}

// The bounds are those of the hand that the mesh was made from, and what the pull to the seeds and
// the coarser weights of a fit may add.
TEST_F(KnownHand, IsFoundAgainFromBothItsMeshes)
{
    const FitReport fit = fit_hand({mesh(right), mesh(left)}, Topology::h25);
    EXPECT_EQ(fit.cones, 14);
    EXPECT_EQ(fit.slabs, 12);
    expect_medial(fit);
    for (int i = 0; i < 25; ++i) {
        EXPECT_LT(length(fit.spheres[i].c - h25_spheres[i].c), 5e-3f) << i;
        EXPECT_NEAR(fit.spheres[i].r, h25_spheres[i].r, 2e-3) << i;
    }
    EXPECT_GT(fit.shift, 0);
    EXPECT_LT(fit.shift, fit.farthest);
    const Skin skin = read_skin(mesh(right).path);
    const std::vector<SkinPoint> points = spread(skin, 3000);
    const Rig rig = hand_rig(Topology::h25, right);
    const Deviation itself = deviation(rig, right, skin, points, open_hand(right), true);
    EXPECT_LT(itself.mean, 1e-4);
    EXPECT_LT(fit.deviation.mean, itself.mean + 2e-4);
    EXPECT_LT(fit.deviation.p95, itself.p95 + 5e-4);
    EXPECT_LT(fit.deviation.bulge, itself.bulge + 2e-3);
    const Hand fist = flexed(open_hand(right), 60 * degree);
    EXPECT_LT(deviation(fit.rig, right, skin, points, fist).p95,
              deviation(rig, right, skin, points, fist).p95 + 1e-3);
}

TEST_F(KnownHand, IsFittedByTheFinerHandAndTheFitsAreWrittenAsATable)
{
    const FitReport fit = fit_hand({mesh(left)}, Topology::h47);
    EXPECT_EQ(fit.cones, 23);
    EXPECT_EQ(fit.slabs, 31);
    EXPECT_LT(fit.deviation.mean, 3e-4);
    expect_medial(fit);
    EXPECT_GT(fit.open.joints[thumb_tip].p.x, 0);  // a left hand, palm down
    std::ostringstream out;
    write_rig_table(out, fit, fit);
    std::istringstream table(out.str());
    int rows = 0;
    for (std::string line; std::getline(table, line);) rows += line.rfind("    {{", 0) == 0;
    EXPECT_EQ(rows, joint_count + 2 * 47);
    for (const char* name : {"open_joints[joint_count]", "h25_spheres[]", "h47_spheres[]"})
        EXPECT_NE(out.str().find(name), std::string::npos) << name;
}

TEST_F(KnownHand, SpoiledIsRefusedWithThePlace)
{
    const HandGlb& good = known(right);
    EXPECT_EQ(refused(good), "");
    const auto spoiled = [&](const auto& spoil) {
        HandGlb hand = good;
        spoil(hand);
        return refused(hand);
    };
    EXPECT_EQ(spoiled([](HandGlb& h) { h.names[3] = "index-finger-tip"; }),
              "/skins/0/joints: expected one named \"index-finger-tip\", found 2");
    EXPECT_EQ(spoiled([](HandGlb& h) { h.names[HandGlb::index(ring_tip)] = "ring-tip"; }),
              "/skins/0/joints: expected one named \"ring-finger-tip\", found 0");
    EXPECT_EQ(spoiled([](HandGlb& h) { h.inverse_bind[5] = {}; }),
              "/skins/0/inverseBindMatrices: element 5: expected an invertible matrix, found "
              "determinant 0");
    EXPECT_EQ(spoiled([](HandGlb& h) { h.weights[7] = {}; }),
              "WEIGHTS_0: vertex 7: expected a weight above 0, found none");
    EXPECT_EQ(spoiled([](HandGlb& h) { h.joints[9][0] = HandGlb::sleeve; }),
              "JOINTS_0: vertex 9: expected a joint of the hand, found 0");
    EXPECT_EQ(spoiled([](HandGlb& h) { h.joints[9][0] = 200; }),
              "JOINTS_0: vertex 9: expected a joint of the hand, found 200");
    EXPECT_EQ(spoiled([](HandGlb& h) {
                  h.joints.pop_back();
              }).rfind("/meshes/0/primitives/0/attributes/JOINTS_0: expected one for each of", 0),
              0u);
    EXPECT_NE(spoiled([](HandGlb& h) {
                  h.vertices[1].x = std::nanf("");
              }).find("element 1: expected finite numbers, found nan"),
              std::string::npos);
}

}  // namespace
}  // namespace knead
