#include "host/hands/rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include "host/assets/skin.h"
#include "host/hands/rig_table.h"
#include "tests/contact/bent_hand.h"
#include "tests/folder.h"

namespace knead {
namespace {

constexpr Topology topologies[] = {Topology::h25, Topology::h47};
constexpr Side sides[] = {left, right};
const char* const tools[] = {"slab", "rod", "cone", "ball", "knife", "scissors"};

auto pose_of(const Hand& hand)
{
    return [&hand](int j) { return hand.joints[j % joint_count]; };
}

std::vector<Vec3<float>> centres(const Rig& rig, const Hand& hand)
{
    std::vector<Vec3<float>> c;
    for (const auto& b : rig.spheres) c.push_back(centre(b, pose_of(hand)));
    return c;
}

template <class Visit>
void for_each_rig(Visit&& visit)
{
    for (const Side side : sides) {
        for (const Topology t : topologies) visit(hand_rig(t, side), side);
        for (const char* name : tools) visit(tool_rig(name, side), side);
    }
}

TEST(HandRig, HasTheSpheresConesAndSlabsOfItsTopology)
{
    const auto count = [](Topology t, int spheres, int cones, int slabs) {
        const Rig rig = hand_rig(t, right);
        EXPECT_EQ(int(rig.spheres.size()), spheres);
        EXPECT_EQ(std::count_if(rig.primitives.begin(), rig.primitives.end(),
                                [](const Primitive& q) { return q.count == 2; }),
                  cones);
        EXPECT_EQ(std::count_if(rig.primitives.begin(), rig.primitives.end(),
                                [](const Primitive& q) { return q.count == 3; }),
                  slabs);
    };
    count(Topology::h25, 25, 14, 12);
    count(Topology::h47, 47, 23, 31);
}

TEST(HandRig, StandsWhereItWasFittedWhenTheHandIsOpen)
{
    const Hand hand = open_hand(right);
    const auto c25 = centres(hand_rig(Topology::h25, right), hand);
    const auto c47 = centres(hand_rig(Topology::h47, right), hand);
    for (std::size_t i = 0; i < c25.size(); ++i)
        EXPECT_LT(length(c25[i] - h25_spheres[i].c), 1e-6f) << i;
    for (std::size_t i = 0; i < c47.size(); ++i)
        EXPECT_LT(length(c47[i] - h47_spheres[i].c), 1e-6f) << i;
}

TEST(HandRig, CoversEveryJointOfTheOpenHand)
{
    for (const Topology t : topologies) {
        const Rig rig = hand_rig(t, right);
        const Hand hand = open_hand(right);
        std::vector<Sphere<float>> s;
        for (const auto& b : rig.spheres)
            s.push_back({centre(b, pose_of(hand)), {}, {}, b.radius, 0});
        for (int j = 0; j < joint_count; ++j) {
            float phi = 1;
            for (const Primitive& q : rig.primitives)
                phi = std::min(phi, closest_point(shape(q.count, s[q.sphere[0]], s[q.sphere[1]],
                                                        s[q.sphere[2]]),
                                                  hand.joints[j].p)
                                        .phi);
            // As deep as the nearest skin is away, but for the error of the fit.
            EXPECT_NEAR(phi, -hand.radius[j], 0.005f) << joint_names[j];
        }
    }
}

TEST(HandRig, HangsEveryTipOnTheLastBoneWhereverTheTipJointIs)
{
    for (const Topology t : topologies) {
        const Rig rig = hand_rig(t, right);
        for (const auto& b : rig.spheres)
            for (int k = 0; k < 4; ++k)
                for (const int tip : {thumb_tip, index_tip, middle_tip, ring_tip, little_tip})
                    EXPECT_NE(b.joint[k] % joint_count, tip);
    }
}

// A primitive's spheres neither part nor fall together, so that no surface tears or vanishes.
TEST(HandRig, NeitherSplitsNorCollapsesInAFist)
{
    for (const Topology t : topologies)
        for (const Side side : sides) {
            const Rig rig = hand_rig(t, side);
            const auto open = centres(rig, open_hand(side));
            const auto fist = centres(rig, flexed(open_hand(side), 80 * degree));
            for (const Primitive& q : rig.primitives)
                for (int k = 1; k < q.count; ++k) {
                    const int a = q.sphere[k - 1], b = q.sphere[k];
                    const float before = length(open[a] - open[b]);
                    EXPECT_LT(length(fist[a] - fist[b]), before + 0.012f) << a << " " << b;
                    EXPECT_GT(length(fist[a] - fist[b]), before - 0.012f) << a << " " << b;
                }
        }
}

TEST(HandRig, IsOnePieceOfSharedSpheres)
{
    for (const Topology t : topologies) {
        const Rig rig = hand_rig(t, right);
        std::vector<int> root(rig.spheres.size());
        std::iota(root.begin(), root.end(), 0);
        for (std::size_t pass = 0; pass < root.size(); ++pass)
            for (const Primitive& q : rig.primitives)
                for (const int s : q.sphere)
                    root[s] = root[q.sphere[0]] = std::min(root[s], root[q.sphere[0]]);
        EXPECT_EQ(std::count(root.begin(), root.end(), 0), std::ptrdiff_t(root.size()));
    }
}

TEST(AnyRig, HasPositiveRadiiWeightsThatSumToOneAndSpheresThatExist)
{
    for_each_rig([](const Rig& rig, Side side) {
        for (const auto& b : rig.spheres) {
            EXPECT_GT(b.radius, 0);
            EXPECT_NEAR(b.weight[0] + b.weight[1] + b.weight[2] + b.weight[3], 1, 1e-6f);
            for (int k = 0; k < 4; ++k) {
                EXPECT_GE(b.weight[k], 0);
                EXPECT_LE(b.weight[k], b.weight[0]);
                EXPECT_EQ(b.joint[k] / joint_count, int(side));
            }
        }
        for (const Primitive& q : rig.primitives) {
            EXPECT_EQ(q.tool, 0);
            for (int k = 0; k < 3; ++k) {
                EXPECT_GE(q.sphere[k], 0);
                EXPECT_LT(q.sphere[k], int(rig.spheres.size()));
                if (k > 0) {
                    EXPECT_EQ(q.sphere[k] == q.sphere[k - 1], k >= q.count);
                }
            }
        }
    });
}

TEST(AnyRig, MirrorsLeftAndRightInEveryPose)
{
    const auto same = [](const Rig& one, const Rig& other) {
        ASSERT_EQ(one.spheres.size(), other.spheres.size());
        for (const float angle : {0.f, 50 * degree}) {
            const auto l = centres(one, flexed(open_hand(left), angle));
            const auto r = centres(other, flexed(open_hand(right), angle));
            for (std::size_t i = 0; i < l.size(); ++i)
                EXPECT_LT(length(l[i] - Vec3<float>{-r[i].x, r[i].y, r[i].z}), 1e-6f) << i;
        }
    };
    for (const Topology t : topologies) same(hand_rig(t, left), hand_rig(t, right));
    for (const char* name : tools) same(tool_rig(name, left), tool_rig(name, right));
}

TEST(AnyRig, MovesFromPoseToPoseInOneStepAndSpinsAsItsJointDoes)
{
    const float dt = 1 / 90.f, rate = 3;  // [s], [rad/s]
    for_each_rig([&](const Rig& rig, Side side) {
        const Hand from = open_hand(side);
        Hand to = from;  // the whole hand turns about the wrist's y and moves
        const Quat<float> turn = turn_about(Vec3<float>{0, 1, 0}, rate * dt);
        for (auto& j : to.joints)
            j = {turn * j.q, rotate(turn, j.p) + Vec3<float>{0.001f, 0.002f, -0.003f}};
        for (const auto& b : rig.spheres) {
            const Sphere<float> s = posed(b, pose_of(from), pose_of(to), dt, 1.0f);
            const Vec3<float> c0 = centre(b, pose_of(from));
            const Vec3<float> c1 = rotate(turn, c0) + Vec3<float>{0.001f, 0.002f, -0.003f};
            EXPECT_LT(length(s.c - c1), 1e-6f);
            EXPECT_LT(length(s.v - (1 / dt) * (c1 - c0)), 1e-4f);
            EXPECT_LT(length(s.w - Vec3<float>{0, rate, 0}), 2e-3f);
            EXPECT_EQ(s.r, b.radius);
        }
    });
}

TEST(ToolRig, RefusesAnUnknownNameAndNamesTheChoices)
{
    for (const char* wrong : {"", "spoon", "Knife", "rod "}) try {
            tool_rig(wrong, right);
            FAIL() << "accepted \"" << wrong << "\"";
        } catch (const std::invalid_argument& e) {
            for (const char* name : tools)
                EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
        }
}

TEST(ToolRig, HasTheSizesItIsSaidToHave)
{
    const Rig rod = tool_rig("rod", right);
    EXPECT_FLOAT_EQ(rod.spheres[0].radius, 0.01f);
    EXPECT_NEAR(length(rod.spheres[0].offset[0] - rod.spheres[1].offset[0]) + 0.02f, 0.24f, 1e-6f);
    for (const char* blade : {"knife", "scissors"})
        for (const auto& s : tool_rig(blade, right).spheres) EXPECT_LE(2 * s.radius, 0.001f);
}

TEST(ToolRig, HoldsTheKnifeAheadWithItsBladeUprightAndItsEdgeBelow)
{
    const Rig knife = tool_rig("knife", right);
    const Hand hand = open_hand(right);
    const auto c = centres(knife, hand);
    const Vec3<float> across = rotate(hand.joints[palm].q, Vec3<float>{1, 0, 0});
    float low = 0, ahead = 0;
    for (const auto& p : c) {
        EXPECT_NEAR(dot(p - c[0], across), 0, 1e-6f);
        low = std::min(low, p.y);
        ahead = std::min(ahead, p.z);
    }
    EXPECT_LT(low, hand.joints[palm].p.y - 0.03f);
    EXPECT_LT(ahead, hand.joints[index_tip].p.z - 0.05f);
}

// Blades label the side that their normal points to, so all slabs of one tool must agree.
TEST(ToolRig, TurnsTheNormalsOfABladesSlabsToTheSameSide)
{
    for (const char* name : {"knife", "scissors"})
        for (const Side side : sides) {
            const Rig rig = tool_rig(name, side);
            const auto c = centres(rig, open_hand(side));
            const auto normal = [&](const Primitive& q) {
                return cross(c[q.sphere[1]] - c[q.sphere[0]], c[q.sphere[2]] - c[q.sphere[0]]);
            };
            const Vec3<float> first = normal(rig.primitives[0]), second = normal(rig.primitives[1]);
            EXPECT_GT(dot(first, second), 0.999f * length(first) * length(second)) << name;
        }
}

TEST(ToolRig, HingesOneScissorBladeOnTheIndexAndOneOnTheThumb)
{
    const Rig rig = tool_rig("scissors", right);
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(rig.spheres[i].joint[0], joint_count + (i < 3 ? index_distal : thumb_distal));
}

// Points on a known cone, fitted from a wrong start.
TEST(Skin, SaysWhatIsWrongWithAFileThatIsNoHand)
{
    const Folder folder;
    const std::string path = folder / "hand.glb";
    const auto refused = [&](const std::string& bytes) {
        std::ofstream(path, std::ios::binary) << bytes;
        try {
            read_skin(path);
            ADD_FAILURE() << "accepted " << bytes.size() << " bytes";
        } catch (const std::runtime_error& e) {
            EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
        }
    };
    refused("");
    refused("glTF");
    refused(std::string(64, '\xff'));
    const std::string json = R"({"asset":{"version":"2.0"},"meshes":[],"skins":[]}  )";
    const auto word = [](std::size_t n) {
        std::string w;
        for (int i = 0; i < 4; ++i) w += char(n >> (8 * i) & 255);
        return w;
    };
    refused("glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json);
    std::filesystem::remove(path);
    EXPECT_THROW(read_skin(path), std::runtime_error);
}

}  // namespace
}  // namespace knead
