// Live pictures: the eye's geometry, what covers what, colours, and the state that is left.
#include "render/eye_painter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/base/errors.h"
#include "tests/render/eye_picture.h"

namespace knead {
namespace {

TEST(EyeView, OfACameraLooksFromItToItsTarget)
{
    const Camera camera{{0.5f, 0.6f, 1.9f}, {0.4f, 0.25f, 0.5f}, 0.6f, 240, 180};
    const EyeView view = eye_view(camera);
    const Vec3<float> gaze = camera.target - camera.eye;
    const Vec3<float> ahead = rotate(view.rotation, Vec3<float>{0, 0, -1});
    EXPECT_NEAR(dot(ahead, gaze), length(gaze), 1e-5f);
    EXPECT_NEAR(rotate(view.rotation, Vec3<float>{1, 0, 0}).y, 0, 1e-6f);
    EXPECT_GT(rotate(view.rotation, Vec3<float>{0, 1, 0}).y, 0.9f);
    EXPECT_NEAR(view.right / view.up, 240.0f / 180, 1e-5f);
    const Eye<float> eye = splat_eye(view);
    EXPECT_TRUE(valid(eye));
    EXPECT_NEAR(dot(rotate(eye.rotation, Vec3<float>{0, 0, 1}), gaze), length(gaze), 1e-5f);
    EXPECT_LT(rotate(eye.rotation, Vec3<float>{0, 1, 0}).y, -0.9f);
    EXPECT_TRUE(eye.up == -view.up && eye.down == -view.down);
}

#if KNEAD_HAS_GL

constexpr int middle = picture_width / 2 + picture_width * (picture_height / 2);

TEST_F(EyePicture, DepthIsNearOverDistanceAndNothingInfinitelyFar)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    EyeLook look;
    look.floor_seen = false;
    const EyeView view = front();
    painted(view, look);
    const std::vector<float> depths = plain->depths();
    const float distance = length(ball_centre - view.position);
    EXPECT_NEAR(view.near / depths[middle], distance - 0.25f, 2e-3f);
    EXPECT_EQ(depths[0], 0);
    look.floor_seen = true;
    painted(view, look);
    EXPECT_GT(plain->depths()[picture_width / 2], 0) << "the floor, in the lowest row";
}

// Two halves of a field, each an eye of its own, are the whole.
TEST_F(EyePicture, AFrustumMayBeAsymmetric)
{
    painter->set_clay({ball(ball_centre + Vec3<float>{0.1f, 0.1f, 0}, 0.2f)}, 1);
    const std::vector<int> whole = painted();
    EyeView half = front();
    half.width = picture_width / 2;
    for (const bool right : {false, true}) {
        half.left = right ? 0 : front().left, half.right = right ? front().right : 0;
        const std::vector<int> part = painted(half);
        int different = 0;
        for (int y = 0; y < picture_height; ++y)
            for (int x = 0; x < picture_width / 2; ++x)
                different += std::abs(red_green_blue(part, x + y * picture_width) -
                                      red_green_blue(whole, x + (right ? picture_width / 2 : 0) +
                                                                y * picture_width)) > 12;
        EXPECT_LT(different, picture_width * picture_height / 200);
    }
}

TEST_F(EyePicture, AHeadThatIsUpsideDownSeesThePictureTurned)
{
    painter->set_clay({ball(ball_centre + Vec3<float>{0.15f, 0.1f, 0}, 0.2f)}, 1);
    const std::vector<int> upright = painted();
    EyeView turned = front();
    turned.rotation = turned.rotation * Quat<float>{0, 0, 0, 1};
    const std::vector<int> other = painted(turned);
    int different = 0;
    for (int i = 0; i < picture_width * picture_height; ++i)
        different += std::abs(red_green_blue(upright, i) -
                              red_green_blue(other, picture_width * picture_height - 1 - i)) > 12;
    EXPECT_LT(different, picture_width * picture_height / 100);
}

TEST_F(EyePicture, AnSrgbTextureHoldsTheSameBytes)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const std::vector<int> wanted = painted();
    const OffscreenTarget srgb(GL_SRGB8_ALPHA8);
    EyeTarget target{srgb.frame};
    target.linear = true;
    painter->paint(front(), {}, target);
    const std::vector<int> found = srgb.colours();
    ASSERT_EQ(found.size(), wanted.size());
    int most = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
        most = std::max(most, std::abs(found[i] - wanted[i]));
    EXPECT_LE(most, 1);
}

TEST_F(EyePicture, BeforeTheRealWorldOnlyWhatIsThereHasAlpha)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    EyeLook look;
    look.transparent = true, look.floor_seen = false;
    const std::vector<int> c = painted(front(), look);
    EXPECT_EQ(c[3], 0);
    EXPECT_EQ(c[0] + c[1] + c[2], 0);
    EXPECT_EQ(c[4 * middle + 3], 255);
    look.floor_seen = true;
    const std::vector<int> on_floor = painted(front(), look);
    EXPECT_GT(on_floor[4 * (picture_width / 2) + 3], 200);
}

TEST_F(EyePicture, ClayIsUploadedWithItsVersionAndHiddenClayCastsItsShadow)
{
    const std::vector<int> bare = painted();
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const std::vector<int> with = painted();
    EXPECT_NE(with, bare);
    painter->set_clay({}, 1);
    EXPECT_EQ(painted(), with) << "the same version is not looked at";
    painter->set_clay({ball(ball_centre, 0.25f, 7)}, 2, {7});
    const std::vector<int> shadow = painted();
    EXPECT_NE(shadow, bare);
    EXPECT_NE(shadow, with);
    // The shadow falls to the right of the ball: the light stands to the left of the camera.
    int darker = 0;
    for (int i = 0; i < picture_width * picture_height; ++i)
        darker += red_green_blue(shadow, i) < red_green_blue(bare, i) - 30;
    EXPECT_GT(darker, 300);
    painter->set_clay({}, 3);
    EXPECT_EQ(painted(), bare);
}

TEST_F(EyePicture, ClayOfAHiddenCategoryIsLeftOutWithItsShadow)
{
    const Mesh near = ball({0.3f, 0.25f, 0.5f}, 0.12f, 4), far = ball({0.7f, 0.25f, 0.5f}, 0.12f);
    const std::vector<int> bare = painted();
    painter->set_clay({far}, 1);
    const std::vector<int> alone = painted();
    painter->set_clay({near, far}, 2);
    const std::vector<int> both = painted();
    EXPECT_NE(both, alone);
    painter->set_clay({near, far}, 2, {}, {4});
    EXPECT_EQ(painted(), alone) << "the same version, but hidden";
    painter->set_clay({near, far}, 2, {4}, {4});
    EXPECT_EQ(painted(), alone) << "hidden, although splats are drawn in its place";
    painter->set_clay({near, far}, 2, {}, {0, 4});
    EXPECT_EQ(painted(), bare);
    painter->set_clay({near, far}, 2);
    EXPECT_EQ(painted(), both);
}

TEST_F(EyePicture, WhatIsSelectedGlowsAndNothingElse)
{
    painter->set_clay({ball({0.3f, 0.25f, 0.5f}, 0.12f, 0), ball({0.7f, 0.25f, 0.5f}, 0.12f, 1)},
                      1);
    const std::vector<int> none = painted();
    EyeLook look;
    look.highlight = 1;
    const std::vector<int> one = painted(front(), look);
    int on_left = 0, on_right = 0;
    for (int i = 0; i < picture_width * picture_height; ++i)
        if (red_green_blue(none, i) != red_green_blue(one, i))
            ++(i % picture_width < picture_width / 2 ? on_left : on_right);
    EXPECT_EQ(on_left, 0);
    EXPECT_GT(on_right, 200);
}

// By category, or vertex by vertex; uploaded again with their version.
TEST_F(EyePicture, ClayHasTheColoursOfItsObjects)
{
    const std::vector<Mesh> two{ball({0.3f, 0.25f, 0.5f}, 0.12f, 0),
                                ball({0.7f, 0.25f, 0.5f}, 0.12f, 1)};
    const Vec3<float> blue{0.02f, 0.05f, 0.6f};
    painter->set_clay(two, 1);
    const std::vector<int> none = painted();
    const auto bluer = [&](const std::vector<int>& now) {
        int left = 0, right = 0;
        for (int y = 0; y < picture_height; ++y)
            for (int x = 0; x < picture_width; ++x) {
                const std::size_t at = std::size_t(x + picture_width * y) * 4 + 2;
                if (now[at] > none[at] + 40) ++(x < picture_width / 2 ? left : right);
            }
        return std::pair{left, right};
    };
    ClayColours colours;
    colours.of_category[1] = blue, colours.version = 5;
    painter->set_clay(two, 1, {}, {}, colours);
    const auto [left, right] = bluer(painted());
    EXPECT_EQ(left, 0);
    EXPECT_GT(right, 200);
    colours.of_category.clear();
    painter->set_clay(two, 1, {}, {}, colours);
    EXPECT_EQ(bluer(painted()), std::pair(left, right)) << "the same version is not looked at";
    colours.of_vertices = {std::vector<Vec3<float>>(two[0].vertices.size(), blue), {}};
    colours.version = 6;
    painter->set_clay(two, 1, {}, {}, colours);
    EXPECT_GT(bluer(painted()).first, 200);
    EXPECT_EQ(bluer(painted()).second, 0);
    painter->set_clay(two, 1);
    EXPECT_EQ(painted(), none);
    colours.of_vertices[0].pop_back(), colours.version = 7;
    EXPECT_THROW(painter->set_clay(two, 1, {}, {}, colours), std::invalid_argument);
}

TEST_F(EyePicture, AMarkHasItsColourAndNoShadow)
{
    painter->set_clay({}, 1);
    const std::vector<int> none = painted();
    HandLook look;
    look.skins = {ball({0.5f, 0.5f, 0.5f}, 0.05f)};
    look.skin = false, look.glow = {1, 0.4f, 0.02f};
    const auto changed = [&] {
        painter->set_hands(std::vector<HandLook>{look});
        const std::vector<int> now = painted();
        int count = 0;
        for (int i = 0; i < picture_width * picture_height; ++i)
            count += red_green_blue(now, i) != red_green_blue(none, i);
        return count;
    };
    const int with_shadow = changed();
    look.mark = true;
    const int marked = changed();
    EXPECT_GT(marked, 30);
    EXPECT_GT(with_shadow, marked + 20);
}

TEST_F(EyePicture, HandsFadeByTheirOpacityAndGlow)
{
    DrawPrimitive finger{2, {}};
    finger.sphere[0].c = {0.4f, 0.3f, 1.0f}, finger.sphere[1].c = {0.6f, 0.2f, 0.9f};
    finger.sphere[0].r = 0.05f, finger.sphere[1].r = 0.04f;
    const std::vector<int> none = painted();
    const auto changed = [&](float opacity, Vec3<float> glow = {0, 0, 0}) {
        painter->set_hands(std::vector<HandLook>{{{finger}, {}, opacity, true, false, glow}});
        const std::vector<int> c = painted();
        double sum = 0;
        for (int i = 0; i < picture_width * picture_height; ++i)
            sum += std::abs(red_green_blue(c, i) - red_green_blue(none, i));
        return sum;
    };
    EXPECT_EQ(changed(0), 0);
    const double little = changed(0.2f), half = changed(0.45f), all = changed(1);
    EXPECT_GT(little, 0);
    EXPECT_GT(half, 1.5 * little);
    EXPECT_GT(all, 1.5 * half);
    EXPECT_EQ(changed(0, {2, 1.6f, 0.8f}), 0);
    EXPECT_GT(std::abs(changed(1, {2, 1.6f, 0.8f}) - all), 0.1 * all);
}

TEST_F(EyePicture, SplatsHideWhatLiesBehindThemAndNothingBefore)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const std::vector<int> bare = painted();
    const float distance = length(ball_centre - front().position) - 0.25f;
    SplatLayer layer{2, 2, std::vector<float>(16, 0.5f), {}};
    for (std::size_t i = 0; i < 4; ++i) layer.colour[4 * i + 1] = layer.colour[4 * i + 2] = 0;
    layer.depth.assign(4, distance - 0.1f);
    painter->set_splats(0, layer);
    const std::vector<int> before = painted();
    EXPECT_NEAR(before[4 * middle], 127 + bare[4 * middle] / 2, 3);
    EXPECT_NEAR(before[4 * middle + 1], bare[4 * middle + 1] / 2, 3);
    layer.depth.assign(4, distance + 0.1f);
    painter->set_splats(0, layer);
    const std::vector<int> behind = painted();
    EXPECT_EQ(behind[4 * middle], bare[4 * middle]);
    EXPECT_NE(behind, bare) << "the floor lies behind all of it";
    painter->paint(front(), {}, {plain->frame}, 1);
    EXPECT_EQ(plain->colours(), bare) << "the other eye has none";
    painter->set_splats(0, SplatLayer{});
    EXPECT_EQ(painted(), bare);
}

// The left half is hidden, from splats too, and the right half is as it was.
TEST_F(EyePicture, WhatNobodySeesStaysEmpty)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    painter->set_splats(0, {1, 1, {0.2f, 0.4f, 0.1f, 0.75f}, {0.1f}});
    const EyeView view = front();
    const std::vector<int> whole = painted(view);
    const std::array<float, 2> a{view.left, view.down}, b{0, view.down}, c{view.left, view.up};
    painter->set_hidden(0, {a, b, c, c, b, {0, view.up}});
    const std::vector<int> half = painted(view);
    const std::vector<float> depths = plain->depths();
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width; ++x) {
            const std::size_t at = std::size_t(y * picture_width + x);
            const bool hidden = x < picture_width / 2;
            ASSERT_EQ(depths[at] == 0, hidden) << x << " " << y;
            for (std::size_t i = 4 * at; i < 4 * at + 4; ++i)
                ASSERT_EQ(half[i], hidden ? 0 : whole[i]) << x << " " << y;
        }
    EXPECT_THROW(painter->set_hidden(0, {a, b}), std::invalid_argument);
    painter->set_hidden(0, {});
    EXPECT_EQ(painted(view), whole);
}

TEST_F(EyePicture, IsTheSameWhateverStateIsSetAndLeavesThatOfANewContext)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const std::vector<int> wanted = painted();
    for (const GLenum on : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE, GL_STENCIL_TEST,
                            GL_FRAMEBUFFER_SRGB, GL_RASTERIZER_DISCARD})
        glEnable(on);
    glScissor(0, 0, 1, 1);
    glCullFace(GL_FRONT_AND_BACK);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_NEVER);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    painter->set_clay({ball(ball_centre, 0.25f)}, 2);
    EXPECT_EQ(painted(), wanted);
    for (const GLenum off : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE, GL_STENCIL_TEST,
                             GL_FRAMEBUFFER_SRGB, GL_RASTERIZER_DISCARD, GL_DEPTH_TEST})
        EXPECT_FALSE(glIsEnabled(off)) << off;
    GLint value = 0;
    glGetIntegerv(GL_DEPTH_FUNC, &value);
    EXPECT_EQ(value, GL_LESS);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &value);
    EXPECT_EQ(value, GL_NEGATIVE_ONE_TO_ONE);
    glGetIntegerv(GL_CURRENT_PROGRAM, &value);
    EXPECT_EQ(value, 0);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &value);
    EXPECT_EQ(value, 0);
    EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
}

TEST_F(EyePicture, APictureMayBeDrawnBesideAnother)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const std::vector<int> wanted = painted();
    const OffscreenTarget both(GL_RGBA8, 2 * picture_width, picture_height + 10);
    painter->paint(front(), {}, {both.frame, picture_width, 10});
    const std::vector<int> c = both.colours();
    int different = 0;
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width; ++x)
            different += red_green_blue(c, picture_width + x + (y + 10) * 2 * picture_width) !=
                         red_green_blue(wanted, x + y * picture_width);
    EXPECT_EQ(different, 0);
}

TEST_F(EyePicture, WhatCannotBeDrawnIsRefusedAndTheNextPictureIsMade)
{
    const float bad = std::numeric_limits<float>::quiet_NaN();
    const std::vector<int> bare = painted();
    for (int k = 0; k < 6; ++k) {
        EyeView view = front();
        if (k == 0) view.position.x = bad;
        if (k == 1) view.width = 0;
        if (k == 2) view.right = view.left;
        if (k == 3) view.near = 0;
        if (k == 4) view.rotation = {0, 0, 0, 0};
        if (k == 5) view.up = bad;
        EXPECT_THROW(painted(view), std::invalid_argument) << k;
    }
    EyeLook look;
    look.light = {0, 0, 0};
    EXPECT_THROW(painted(front(), look), std::invalid_argument);
    Mesh broken = ball(ball_centre, 0.25f);
    broken.normals.pop_back();
    EXPECT_THROW(painter->set_clay({broken}, 5), std::invalid_argument);
    broken = ball(ball_centre, 0.25f);
    for (Vec3<float>& v : broken.vertices) v.x = bad;
    painter->set_clay({broken}, 6);
    DrawPrimitive lost{1, {}};
    lost.sphere[0].r = bad;
    painter->set_hands({lost});
    EXPECT_EQ(painted(), bare);
    EXPECT_THROW(painter->set_splats(0, SplatLayer{2, 2, {}, {}}), std::invalid_argument);
    const Framebuffer empty = framebuffer();
    EXPECT_THROW(painter->paint(front(), {}, {empty}), PictureError);
    EXPECT_THROW(EyePainter::open(3), std::runtime_error);
}

#else

TEST(EyePicture, WithoutOpenGlTheReasonIsSaid)
{
    EXPECT_THROW(EyePainter::open(4), std::runtime_error);
}

#endif

}  // namespace
}  // namespace knead
