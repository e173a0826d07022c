// Panels in live pictures: over clay and splats, under hands, and what is left of a picture
// elsewhere.
#include <gtest/gtest.h>

#include <cmath>

#include "host/vr/panel_texture.h"
#if KNEAD_HAS_GL
#include "host/vr/panel_quad.h"
#include "tests/render/eye_picture.h"
#endif

namespace knead {
namespace {

TEST(PanelTexture, CountsPixelsFromTheUpperLeft)
{
    const PanelTexture part = PanelTexture::part(3, 0, 800, 150, 70, 800, 870);
    EXPECT_EQ(part.name, 3u);
    EXPECT_FLOAT_EQ(part.u0, 0);
    EXPECT_FLOAT_EQ(part.u1, 150 / 800.f);
    EXPECT_FLOAT_EQ(part.v0, 70 / 870.f);
    EXPECT_NEAR(part.v1, 0, 1e-7f);
}

#if KNEAD_HAS_GL

// A panel of 0.3 m behind the middle of a ball of clay, upright, facing the eye.
class PanelPicture : public EyePicture {
  protected:
    using Corners = std::array<Vec3<float>, 4>;
    using Bytes = std::array<int, 3>;
    static constexpr int middle = picture_width / 2 + picture_width * (picture_height / 2);
    static constexpr Bytes red{200, 60, 20}, green{30, 180, 90}, blue{40, 70, 210};

    void SetUp() override
    {
        EyePicture::SetUp();
        if (!painter) return;
        quad = std::make_unique<PanelQuad>();
        picture = texture(GL_TEXTURE_2D);
        // Columns: 32 red, 16 green over 16 blue, 16 red; 64 rows, the uppermost first.
        std::vector<std::uint8_t> texels;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const Bytes& c = x < 32 || x >= 48 ? red : y < 32 ? green : blue;
                for (const int byte : {c[0], c[1], c[2], 255}) texels.push_back(std::uint8_t(byte));
            }
        glTextureStorage2D(picture, 1, GL_SRGB8_ALPHA8, 64, 64);
        glTextureSubImage2D(picture, 0, 0, 0, 64, 64, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
        glTextureParameteri(picture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTextureParameteri(picture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        plain_red = {picture, 0, 0, 0.5f, 1};
    }
    void TearDown() override
    {
        quad.reset(), picture = {};
        EyePicture::TearDown();
    }

    // A point at this distance from the eye on the ray through the middle, shifted in the picture's
    // plane [m].
    static Vec3<float> before_eye(float distance, float right = 0, float up = 0)
    {
        const EyeView view = front();
        return view.position + rotate(view.rotation, Vec3<float>{right, up, -distance});
    }
    static Corners panel_at(float distance, float half = 0.15f)
    {
        return {before_eye(distance, -half, half), before_eye(distance, half, half),
                before_eye(distance, -half, -half), before_eye(distance, half, -half)};
    }
    EyePainter::DrawBetween draw(const Corners& corners, PanelTexture part)
    {
        return [=, this](const EyeTarget& to) { quad->draw(corners, front(), to, part); };
    }
    std::vector<int> with(const EyePainter::DrawBetween& between, const EyeView& view = front(),
                          const EyeLook& look = {})
    {
        painter->paint(view, look, {plain->frame}, 0, between);
        return plain->colours();
    }
    static Bytes at(const std::vector<int>& colours, int pixel)
    {
        const std::size_t i = 4 * std::size_t(pixel);
        return {colours[i], colours[i + 1], colours[i + 2]};
    }
    static bool is(const Bytes& found, const Bytes& wanted, int tolerance = 1)
    {
        for (std::size_t i = 0; i < 3; ++i)
            if (std::abs(found[i] - wanted[i]) > tolerance) return false;
        return true;
    }
    static int count(const std::vector<int>& colours, const Bytes& wanted)
    {
        int all = 0;
        for (int i = 0; i < picture_width * picture_height; ++i) all += is(at(colours, i), wanted);
        return all;
    }
    static std::vector<HandLook> hand_at(Vec3<float> place, float radius = 0.04f)
    {
        DrawPrimitive finger{1, {}};
        finger.sphere[0].c = place, finger.sphere[0].r = radius;
        return {{{finger}, {}, 1, true}};
    }

    const float to_ball = length(ball_centre - front().position);
    std::unique_ptr<PanelQuad> quad;
    Texture picture;
    PanelTexture plain_red;
};

TEST_F(PanelPicture, IsSeenThroughNearerClayAndUnderNearerHands)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const Corners corners = panel_at(to_ball);  // cuts the ball in halves
    const std::vector<int> bare = painted();
    EXPECT_FALSE(is(at(bare, middle), red, 30));
    const std::vector<int> panel = with(draw(corners, plain_red));
    EXPECT_TRUE(is(at(panel, middle), red));
    EXPECT_NEAR(plain->depths()[middle], front().near / to_ball, 1e-6f);
    // Its square is red, and all else as it was.
    const float side = 0.3f / to_ball / (front().up - front().down) * picture_height;
    EXPECT_NEAR(count(panel, red), side * side, 4 * side);
    int different = 0;
    for (int i = 0; i < picture_width * picture_height; ++i)
        different += at(panel, i) != at(bare, i);
    EXPECT_NEAR(different, side * side, 4 * side);

    painter->set_hands(hand_at(before_eye(to_ball - 0.4f)));
    const std::vector<int> hand = with(draw(corners, plain_red));
    EXPECT_FALSE(is(at(hand, middle), red, 30));
    EXPECT_NEAR(front().near / plain->depths()[middle], to_ball - 0.44f, 2e-3f);
    EXPECT_GT(count(hand, red), 100) << "beside it";
    // In the clay, but in front of the panel; and behind the panel.
    painter->set_hands(hand_at(before_eye(to_ball - 0.1f)));
    EXPECT_FALSE(is(at(with(draw(corners, plain_red)), middle), red, 30));
    EXPECT_EQ(at(painted(), middle), at(bare, middle)) << "which covers it without a panel";
    painter->set_hands(hand_at(before_eye(to_ball + 0.1f)));
    EXPECT_TRUE(is(at(with(draw(corners, plain_red)), middle), red));
}

TEST_F(PanelPicture, IsNotCoveredByTheFloor)
{
    EyeLook look;
    look.floor = 0.4f;  // between eye and panel
    const Corners corners = panel_at(to_ball);
    EXPECT_TRUE(is(at(with(draw(corners, plain_red), front(), look), middle), red));
    look.transparent = true;
    EXPECT_TRUE(is(at(with(draw(corners, plain_red), front(), look), middle), red));
    EXPECT_EQ(plain->colours()[4 * middle + 3], 255);
}

TEST_F(PanelPicture, IsNotCoveredBySplatsNorIsAHandBeforeIt)
{
    SplatLayer layer{1, 1, {0.5f, 0, 0, 0.5f}, {0.3f}};  // very near
    const Corners corners = panel_at(to_ball);
    const std::vector<int> without = with(draw(corners, plain_red));
    painter->set_hands(hand_at(before_eye(to_ball - 0.4f)));
    const std::vector<int> hand = with(draw(corners, plain_red));
    painter->set_splats(0, layer);
    const std::vector<int> hand_and_splats = with(draw(corners, plain_red));
    const std::vector<float> depths = plain->depths();
    EXPECT_EQ(at(hand_and_splats, middle), at(hand, middle));
    EXPECT_NEAR(front().near / depths[middle], to_ball - 0.44f, 2e-3f);
    EXPECT_NE(at(hand_and_splats, 0), at(hand, 0)) << "splats cover the rest";
    painter->set_hands(std::vector<HandLook>{});
    const std::vector<int> splats = with(draw(corners, plain_red));
    EXPECT_EQ(at(splats, middle), at(without, middle));
    EXPECT_EQ(count(splats, red), count(without, red));
    layer.colour = {0.9f, 0, 0, 0.9f};
    painter->set_splats(0, layer);
    with(draw(corners, plain_red));
    EXPECT_NEAR(plain->depths()[middle], front().near / to_ball, 1e-6f);
    EXPECT_NEAR(plain->depths()[0], front().near / 0.3f, 1e-6f);
}

TEST_F(PanelPicture, ShowsPartsOfATextureUpright)
{
    const float near_one = to_ball - 0.5f;
    const auto both = [&](const EyeTarget& to) {
        quad->draw(panel_at(to_ball), front(), to, plain_red);
        quad->draw(panel_at(near_one, 0.05f), front(), to, {picture, 0.5f, 0, 0.75f, 1});
    };
    const std::vector<int> c = with(both);
    EXPECT_TRUE(is(at(c, middle + 3 * picture_width), green)) << "rows count from below";
    EXPECT_TRUE(is(at(c, middle - 3 * picture_width), blue));
    EXPECT_EQ(count(c, green) + count(c, blue) > 80, true);
    EXPECT_GT(count(c, red), 200);
    EXPECT_NEAR(plain->depths()[middle], front().near / near_one, 1e-6f);
    // The lower half alone.
    const std::vector<int> lower = with(draw(panel_at(to_ball), {picture, 0.5f, 0.5f, 0.75f, 1}));
    EXPECT_EQ(count(lower, green), 0);
    EXPECT_GT(count(lower, blue), 200);
}

TEST_F(PanelPicture, LeavesPicturesWithoutItAsTheyWere)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    painter->set_hands(hand_at(before_eye(to_ball - 0.5f)));
    painter->set_splats(0, {1, 1, {0.2f, 0.4f, 0.1f, 0.75f}, {to_ball - 0.1f}});
    const std::vector<int> before = painted();
    const std::vector<float> depths = plain->depths();
    with(draw(panel_at(to_ball), plain_red));
    EXPECT_EQ(painted(), before);
    EXPECT_EQ(plain->depths(), depths);
    EXPECT_EQ(with([](const EyeTarget&) {}), before) << "nothing is drawn between";
    EXPECT_EQ(plain->depths(), depths);
    // A larger picture: all textures of the painter are made anew.
    const OffscreenTarget large(GL_RGBA8, 2 * picture_width, 2 * picture_height);
    EyeView view = front();
    view.width *= 2, view.height *= 2;
    painter->paint(view, {}, {large.frame}, 0, draw(panel_at(to_ball), plain_red));
    EXPECT_EQ(painted(), before);
}

TEST_F(PanelPicture, IsTheSameForOtherTargetsAndStates)
{
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    painter->set_hands(hand_at(before_eye(to_ball - 0.5f)));
    const std::vector<int> wanted = with(draw(panel_at(to_ball), plain_red));
    EXPECT_EQ(with([&](const EyeTarget& to) {
                  draw(panel_at(to_ball), plain_red)(to);
                  for (const GLenum on : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE,
                                          GL_FRAMEBUFFER_SRGB, GL_RASTERIZER_DISCARD})
                      glEnable(on);
                  glScissor(0, 0, 1, 1);
                  glCullFace(GL_FRONT_AND_BACK);
                  glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
                  glDepthMask(GL_FALSE);
                  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
                  glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
              }),
              wanted);
    for (const GLenum off : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE, GL_FRAMEBUFFER_SRGB,
                             GL_RASTERIZER_DISCARD, GL_DEPTH_TEST})
        EXPECT_FALSE(glIsEnabled(off)) << off;
    const OffscreenTarget srgb(GL_SRGB8_ALPHA8, 2 * picture_width, picture_height + 10);
    EyeTarget target{srgb.frame, picture_width, 10};
    target.linear = true;
    painter->paint(front(), {}, target, 1, draw(panel_at(to_ball), plain_red));
    const std::vector<int> found = srgb.colours();
    int different = 0;
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width; ++x)
            different += !is(at(found, picture_width + x + (y + 10) * 2 * picture_width),
                             at(wanted, x + y * picture_width));
    EXPECT_EQ(different, 0);
}

TEST_F(PanelPicture, IsNotDrawnWhereNobodySees)
{
    const EyeView view = front();
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    painter->set_hands(hand_at(before_eye(to_ball - 0.5f, -0.05f)));
    painter->set_splats(0, {1, 1, {0.2f, 0.4f, 0.1f, 0.75f}, {0.1f}});
    const std::vector<int> whole = with(draw(panel_at(to_ball), plain_red));
    const std::array<float, 2> a{view.left, view.down}, b{0, view.down}, c{view.left, view.up};
    painter->set_hidden(0, {a, b, c, c, b, {0, view.up}});
    const std::vector<int> half = with(draw(panel_at(to_ball), plain_red));
    const std::vector<float> depths = plain->depths();
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width; ++x) {
            const std::size_t i = std::size_t(y * picture_width + x);
            const bool hidden = x < picture_width / 2;
            ASSERT_EQ(depths[i] == 0, hidden) << x << " " << y;
            ASSERT_EQ(at(half, int(i)), hidden ? Bytes{} : at(whole, int(i))) << x << " " << y;
        }
}

TEST_F(PanelPicture, HasSmoothEdges)
{
    EyeLook look;
    look.transparent = true, look.floor_seen = false;
    Corners corners = panel_at(to_ball);
    for (Vec3<float>& corner : corners) corner.x += 0.0007f;
    corners[0].y += 0.02f, corners[2].y += 0.02f;  // its upper and lower edges are slanted
    const std::vector<int> c = with(draw(corners, plain_red), front(), look);
    int partly = 0;
    for (int i = 0; i < picture_width * picture_height; ++i) {
        const int alpha = c[4 * std::size_t(i) + 3];
        partly += alpha > 0 && alpha < 255;
        EXPECT_TRUE(alpha < 255 || is(at(c, i), red));
    }
    EXPECT_GT(partly, 10);
}

#endif

}  // namespace
}  // namespace knead
