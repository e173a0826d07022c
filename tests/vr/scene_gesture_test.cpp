// Two fists that move, turn and zoom the scene.
#include "host/vr/scene_gesture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace knead {
namespace {

using Fists = std::array<Vec3<double>, 2>;

constexpr Vec3<double> hands_at{3, 2, 1};  // of the hands in the simulation

// What the simulation has at a point of the headset's frame.
Vec3<double> clay_at(const ScenePlace& place, Vec3<double> p)
{
    const Joint<float> in = in_hands(place.workplace, {{1, 0, 0, 0}, cast<float>(p)});
    return hands_at + place.zoom * cast<double>(in.p);
}

TEST(SceneGesture, NeedsTwoFists)
{
    SceneGesture gesture;
    const ScenePlace place;
    EXPECT_FALSE(gesture.frame({}, place));
    EXPECT_FALSE(gesture.frame(Fists{Vec3<double>{-0.2, 0, 0}, Vec3<double>{0.2, 0, 0}}, place))
        << "the first frame";
    EXPECT_TRUE(gesture.frame(Fists{Vec3<double>{-0.2, 0, 0}, Vec3<double>{0.2, 0, 0}}, place));
    EXPECT_FALSE(gesture.frame({}, place));
    EXPECT_FALSE(gesture.frame(Fists{Vec3<double>{-0.2, 0, 0}, Vec3<double>{0.2, 0, 0}}, place))
        << "begun anew";
}

TEST(SceneGesture, TheSceneFollowsTheFists)
{
    std::mt19937 source(8);
    std::uniform_real_distribution<double> in(-0.02, 0.02);
    SceneGesture gesture;
    ScenePlace place;
    place.workplace.turn = 0.4, place.zoom = 3;
    Fists fists{Vec3<double>{-0.2, -0.3, -0.4}, Vec3<double>{0.25, -0.35, -0.5}};
    gesture.frame(fists, place);
    const Vec3<double> middle = clay_at(place, 0.5 * (fists[0] + fists[1]));
    for (int k = 0; k < 100; ++k) {
        for (Vec3<double>& fist : fists)
            fist = fist + Vec3<double>{in(source), in(source), in(source)};
        place = *gesture.frame(fists, place);
    }
    const Vec3<double> now = clay_at(place, 0.5 * (fists[0] + fists[1]));
    EXPECT_LT(length(now - middle), 1e-4) << "what is between them stays there";
    EXPECT_NE(place.zoom, 3);
    EXPECT_NE(place.workplace.turn, 0.4);
}

TEST(SceneGesture, ZoomsByTheirDistanceAndTurnsAboutTheVertical)
{
    SceneGesture gesture;
    ScenePlace place;
    place.zoom = 2;
    gesture.frame(Fists{Vec3<double>{-0.1, 0, 0}, Vec3<double>{0.1, 0, 0}}, place);
    const ScenePlace wide =
        *gesture.frame(Fists{Vec3<double>{-0.15, 0, 0}, Vec3<double>{0.15, 0, 0}}, place);
    EXPECT_NEAR(wide.zoom, 2 / 1.5, 1e-12) << "what is between them appears larger";
    EXPECT_EQ(wide.workplace.turn, 0);
    // The right fist goes to the back.
    const ScenePlace turned =
        *gesture.frame(Fists{Vec3<double>{-0.14, 0, 0.05}, Vec3<double>{0.14, 0, -0.05}}, place);
    EXPECT_NEAR(turned.workplace.turn, std::atan2(0.05, 0.14), 1e-12);
    // One above the other has no heading.
    gesture.frame({}, place);
    gesture.frame(Fists{Vec3<double>{0, -0.1, 0}, Vec3<double>{0, 0.1, 0}}, place);
    const ScenePlace upright =
        *gesture.frame(Fists{Vec3<double>{0, -0.1, 0.01}, Vec3<double>{0.01, 0.1, 0}}, place);
    EXPECT_EQ(upright.workplace.turn, 0);
}

TEST(SceneGesture, IsBounded)
{
    SceneGesture gesture;
    ScenePlace place;
    place.zoom = 0.06;
    gesture.frame(Fists{Vec3<double>{-0.1, 0, 0}, Vec3<double>{0.1, 0, 0}}, place);
    const ScenePlace leap =
        *gesture.frame(Fists{Vec3<double>{-0.1, 0, 0}, Vec3<double>{5, 0, 0}}, place);
    EXPECT_EQ(leap.zoom, 0.06) << "a hand that jumps moves nothing";
    EXPECT_EQ(leap.workplace.at.x, place.workplace.at.x);
    gesture.frame(Fists{Vec3<double>{-0.1, 0, 0}, Vec3<double>{0.1, 0, 0}}, place);
    EXPECT_EQ(
        gesture.frame(Fists{Vec3<double>{-0.18, 0, 0}, Vec3<double>{0.18, 0, 0}}, place)->zoom,
        SceneGesture::least);
}

TEST(Workplace, BackIsTheInverse)
{
    Workplace place{{0.3, -0.4, -0.5}, 0.7};
    const Joint<float> pose{unit(Quat<float>{0.5f, 0.1f, 0.7f, -0.2f}), {1, 2, 3}};
    const Joint<float> back = in_headset_frame(place, in_hands(place, pose));
    EXPECT_LT(length(back.p - pose.p), 1e-5f);
    EXPECT_NEAR(std::abs(back.q.w * pose.q.w + back.q.x * pose.q.x + back.q.y * pose.q.y +
                         back.q.z * pose.q.z),
                1, 1e-5);
}

}  // namespace
}  // namespace knead
