// Pictures: does the light tell a dent from none, and does nothing hostile break them.
#include "render/painter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "host/base/errors.h"
#if KNEAD_HAS_GL
#include "render/geometry.h"
#endif

namespace knead {
namespace {

#if KNEAD_HAS_GL

constexpr float ball_radius = 0.25f;  // [m]
constexpr Vec3<float> ball_centre{0.5f, 0.25f, 0.5f};

// A ball on the floor, with a dent towards +z that is `depth` deep [m] and about 0.1 m wide.
Mesh dented_ball(float depth)
{
    Mesh mesh;
    Geometry sphere{};
    DrawPrimitive primitive{1, {}};
    primitive.sphere[0].r = 1;
    add_hull(sphere, primitive, 4, {0, 0, 0});
    const auto place = [&](Vec3<float> d) {
        const float turn = std::acos(clamp(d.z, -1.0f, 1.0f)) / 0.25f;
        return ball_centre + (ball_radius - depth * std::exp(-turn * turn * turn * turn)) * d;
    };
    for (const PaintVertex& v : sphere.vertices) {
        const float n = length(v.normal), e = 1e-2f;
        const Vec3<float> d = (1 / n) * v.normal, u = orthogonal(d), w = cross(d, u);
        const auto at = [&](Vec3<float> q) { return place((1 / length(q)) * q); };
        const Vec3<float> normal =
            cross(at(d + e * u) - at(d - e * u), at(d + e * w) - at(d - e * w));
        mesh.vertices.push_back(place(d));
        mesh.normals.push_back((1 / length(normal)) * normal);
    }
    mesh.triangles = sphere.triangles;
    return mesh;
}

DrawPrimitive finger()
{
    DrawPrimitive primitive{2, {}};
    primitive.sphere[0].c = {0.5f, 0.5f, 0.95f};
    primitive.sphere[1].c = {0.52f, 0.36f, 0.85f};
    primitive.sphere[0].r = 0.03f;
    primitive.sphere[1].r = 0.02f;
    return primitive;
}

Camera front() { return {{0.5f, 0.6f, 1.9f}, ball_centre, 0.6f, 240, 180}; }

// Mean luminance, 0 to 255 in sRGB, of the 5 x 5 pixels about the place p.
double luminance(const Image& image, const Camera& camera, Vec3<float> p)
{
    const Vec3<float> gaze = camera.target - camera.eye, forward = (1 / length(gaze)) * gaze;
    const Vec3<float> side = cross(forward, Vec3<float>{0, 1, 0});
    const Vec3<float> right = (1 / length(side)) * side, up = cross(right, forward);
    const Vec3<float> d = p - camera.eye;
    const float scale = float(image.height) / 2 / std::tan(camera.field / 2) / dot(d, forward);
    const int column = int(float(image.width) / 2 + scale * dot(d, right));
    const int row = int(float(image.height) / 2 - scale * dot(d, up));
    double sum = 0;
    for (int y = row - 2; y <= row + 2; ++y) {
        for (int x = column - 2; x <= column + 2; ++x) {
            const std::size_t at = 3 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x));
            sum += 0.2126 * image.rgb.at(at) + 0.7152 * image.rgb.at(at + 1) +
                   0.0722 * image.rgb.at(at + 2);
        }
    }
    return sum / 25;
}

class Picture : public testing::Test {
  protected:
    void SetUp() override
    {
        try {
            painter = Painter::open();
        } catch (const std::runtime_error& reason) {
            GTEST_SKIP() << reason.what();
        }
    }
    Image paint(const std::vector<Mesh>& meshes, const std::vector<DrawPrimitive>& primitives = {})
    {
        return painter->paint(meshes, primitives, front(), 0);
    }
    std::unique_ptr<Painter> painter;
};

TEST_F(Picture, HasTheSizeAskedForAndMoreThanOneColour)
{
    const Image image = paint({dented_ball(0)});
    EXPECT_EQ(image.width, 240);
    EXPECT_EQ(image.height, 180);
    ASSERT_EQ(image.rgb.size(), 3u * 240 * 180);
    std::map<int, int> colours;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
        ++colours[image.rgb[i] << 16 | image.rgb[i + 1] << 8 | image.rgb[i + 2]];
    }
    EXPECT_GT(colours.size(), 1000u);
    EXPECT_FALSE(painter->name().empty());
}

TEST_F(Picture, DepthsAreThoseOfTheMeshAlongTheGaze)
{
    paint({dented_ball(0)});
    const std::vector<float> depths = painter->depths();
    ASSERT_EQ(depths.size(), 240u * 180);
    const Camera camera = front();
    const float distance = length(camera.target - camera.eye);
    const float nearest = *std::min_element(depths.begin(), depths.end());
    EXPECT_NEAR(nearest, distance - 0.25f, 0.01f);
    EXPECT_NEAR(depths[90 * 240 + 120], nearest, 1e-3f) << "the middle of the ball";
    EXPECT_TRUE(std::isinf(depths[0])) << "the background";
}

// Where splats will be put, the floor is in shade, and nothing else has changed.
TEST_F(Picture, WhatIsUnseenCastsItsShadow)
{
    const Image bare = paint({}), seen = paint({dented_ball(0)});
    const Image unseen = painter->paint({}, std::vector<HandLook>{}, front(), 0, {dented_ball(0)});
    const std::vector<float> depths = painter->depths();
    EXPECT_TRUE(std::all_of(depths.begin(), depths.end(), [](float d) { return std::isinf(d); }));
    const Vec3<float> beside{0.5f + 0.3f, 0, 0.5f}, behind = ball_centre;
    EXPECT_NE(unseen.rgb, bare.rgb);
    EXPECT_LT(luminance(unseen, front(), beside), 1.01 * luminance(bare, front(), beside));
    EXPECT_NE(luminance(unseen, front(), behind), luminance(seen, front(), behind));
}

TEST_F(Picture, ADentIsDarkOnTheSideOfTheLightAndBrightOpposite)
{
    const Image plain = paint({dented_ball(0)}), dented = paint({dented_ball(0.04f)});
    // The key light stands up left of the camera, so the dent's upper left wall faces away from it.
    const Vec3<float> shaded = ball_centre + Vec3<float>{-0.03f, 0.03f, 0.23f};
    const Vec3<float> sunny = ball_centre + Vec3<float>{0.035f, -0.03f, 0.22f};
    EXPECT_LT(luminance(dented, front(), shaded), 0.75 * luminance(plain, front(), shaded));
    EXPECT_GT(luminance(dented, front(), sunny), 1.05 * luminance(plain, front(), sunny));
    const Vec3<float> elsewhere = ball_centre + Vec3<float>{-0.15f, 0.17f, 0.1f};
    EXPECT_NEAR(luminance(dented, front(), elsewhere), luminance(plain, front(), elsewhere), 3);
}

TEST_F(Picture, AShallowDentIsSeen)
{
    const Image plain = paint({dented_ball(0)}), dented = paint({dented_ball(0.004f)});
    const Vec3<float> wall = ball_centre + Vec3<float>{-0.04f, 0.04f, 0.24f};
    EXPECT_LT(luminance(dented, front(), wall), luminance(plain, front(), wall) - 4);
}

TEST_F(Picture, TheFloorIsDarkInTheShadowAndDarkestWhereTheBallTouches)
{
    const Image bare = paint({}), image = paint({dented_ball(0)});
    const Vec3<float> lit{0.15f, 0, 0.6f}, shadow{0.86f, 0, 0.45f}, contact{0.56f, 0, 0.62f};
    EXPECT_NEAR(luminance(image, front(), lit), luminance(bare, front(), lit), 12);
    EXPECT_LT(luminance(image, front(), shadow), 0.75 * luminance(bare, front(), shadow));
    EXPECT_LT(luminance(image, front(), contact), 0.9 * luminance(image, front(), shadow));
}

TEST_F(Picture, IsTheSameTwiceAndFromASecondPainter)
{
    const std::vector<Mesh> meshes = {dented_ball(0.02f)};
    const Image first = paint(meshes, {finger()});
    const Image other_size =
        painter->paint(meshes, {}, {{1, 1, 2}, {0.5f, 0, 0.5f}, 0.6f, 33, 21}, 0);
    EXPECT_EQ(other_size.rgb.size(), 3u * 33 * 21);
    EXPECT_EQ(paint(meshes, {finger()}).rgb, first.rgb);
    const std::unique_ptr<Painter> second = Painter::open();
    EXPECT_EQ(second->paint(meshes, {finger()}, front(), 0).rgb, first.rgb);
    EXPECT_EQ(paint(meshes, {finger()}).rgb, first.rgb);
}

// Whoever ends a run does not wait for a picture of many pixels.
TEST_F(Picture, IsGivenUpWhereThatIsAsked)
{
    Camera camera = front();
    camera.width = 1024, camera.height = 1024;
    const std::vector<Mesh> clay{dented_ball(0)};
    int polls = 0;
    painter->give_up_when([&] { return ++polls == 3; });
    EXPECT_THROW(painter->paint(clay, {}, camera, 0), PictureError);
    EXPECT_EQ(polls, 3);
    painter->give_up_when([&] { return ++polls < 0; });
    polls = 0;
    const Image whole = painter->paint(clay, {}, camera, 0);
    EXPECT_GT(polls, 8);
    EXPECT_EQ(painter->paint(clay, {}, camera, 0).rgb, whole.rgb);
}

TEST_F(Picture, HandsCastShadowsAndFadeByTheirOpacity)
{
    const std::vector<Mesh> meshes = {dented_ball(0)};
    Camera camera = front();
    const auto seen = [&](float opacity, Vec3<float> p) {
        camera.hands = opacity;
        return luminance(painter->paint(meshes, {finger()}, camera, 0), camera, p);
    };
    const Vec3<float> on_finger = 0.5f * (finger().sphere[0].c + finger().sphere[1].c);
    const double none = seen(0, on_finger), half = seen(0.5f, on_finger), all = seen(1, on_finger);
    EXPECT_GT(std::abs(all - none), 10);
    EXPECT_GT(std::abs(half - none), 3);
    EXPECT_GT(std::abs(half - all), 3);
    camera.hands = 0;
    EXPECT_EQ(painter->paint(meshes, {finger()}, camera, 0).rgb, paint(meshes).rgb);
}

TEST_F(Picture, EmptyAndBrokenClayIsLeftOutQuietly)
{
    const float bad = std::numeric_limits<float>::quiet_NaN();
    const float far = std::numeric_limits<float>::infinity();
    const Image bare = paint({});
    EXPECT_EQ(paint({Mesh{}}).rgb, bare.rgb);
    Mesh broken;
    broken.vertices = {{bad, 0, 0}, {0, far, 0}, {0, 0, 1}, {1, 0, 0}};
    broken.normals = {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {bad, 0, 0}};
    broken.triangles = {{0, 1, 2}, {1, 2, 3}, {3, 3, 3}};
    DrawPrimitive lost = finger();
    lost.sphere[1].c.y = bad;
    DrawPrimitive negative = finger();
    negative.sphere[0].r = -1;
    EXPECT_EQ(paint({broken}, {lost, negative}).rgb, bare.rgb);
}

TEST_F(Picture, DegenerateTrianglesAndNormalsDoNotBreakIt)
{
    Mesh flat;
    flat.vertices = {{0.5f, 0.1f, 0.5f}, {0.5f, 0.1f, 0.5f}, {0.6f, 0.1f, 0.5f}};
    flat.normals = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    flat.triangles = {{0, 0, 0}, {0, 1, 2}};
    DrawPrimitive point{3, {}};  // three spheres of radius 0 in one place
    EXPECT_EQ(paint({flat}, {point}).rgb.size(), 3u * 240 * 180);
}

TEST_F(Picture, OneStrayVertexDoesNotSpoilTheShadows)
{
    Mesh clay = dented_ball(0);
    const int first = int(clay.vertices.size());
    for (const float x : {0.0f, 1e-3f, 2e-3f}) {
        clay.vertices.push_back({1e6f + x, 1e6f, -1e6f});
        clay.normals.push_back({0, 1, 0});
    }
    clay.triangles.push_back({first, first + 1, first + 2});
    const Image image = paint({clay}), bare = paint({});
    const Vec3<float> shadow{0.86f, 0, 0.45f};
    EXPECT_LT(luminance(image, front(), shadow), 0.8 * luminance(bare, front(), shadow));
}

TEST_F(Picture, WhatCannotBeDrawnIsNamed)
{
    const auto reason = [&](const std::vector<Mesh>& meshes,
                            const std::vector<DrawPrimitive>& primitives,
                            const Camera& camera) -> std::string {
        try {
            painter->paint(meshes, primitives, camera, 0);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "no error";
    };
    const auto says = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    Mesh mesh = dented_ball(0);
    mesh.triangles.push_back({0, 1, 1 << 30});
    EXPECT_PRED2(says, reason({mesh}, {}, front()), "names vertex 1073741824 of");
    mesh = dented_ball(0);
    mesh.normals.pop_back();
    EXPECT_PRED2(says, reason({mesh}, {}, front()), "normals");
    EXPECT_PRED2(says, reason({}, {DrawPrimitive{4, {}}}, front()), "of 4 spheres");
    Camera camera = front();
    camera.width = 0;
    EXPECT_PRED2(says, reason({}, {}, camera), "0 x 180 pixels");
    camera = front();
    camera.target = camera.eye;
    EXPECT_PRED2(says, reason({}, {}, camera), "stands on its target");
    camera.target.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_PRED2(says, reason({}, {}, camera), "not finite");
    camera = front();
    camera.field = 4;
    EXPECT_PRED2(says, reason({}, {}, camera), "field of view");
}

// OpenGL 4.5 promises textures of 16384 texels a side; a picture takes two a pixel.
TEST_F(Picture, IsAsWideAsTheDeviceCanDraw)
{
    const int most = painter->largest_side();
    ASSERT_GE(most, 8192);
    Camera camera = front();
    camera.width = 5000, camera.height = 16;
    const Image wide = painter->paint({dented_ball(0)}, {}, camera, 0);
    EXPECT_EQ(wide.width, 5000);
    EXPECT_EQ(wide.rgb.size(), 3u * 5000 * 16);
    EXPECT_NE(*std::max_element(wide.rgb.begin(), wide.rgb.end()), 0);
    camera.width = most + 1;
    EXPECT_THROW(painter->paint({}, {}, camera, 0), std::invalid_argument);
    EXPECT_EQ(paint({dented_ball(0)}).width, 240);
}

TEST_F(Picture, StraightDownAndFromBelowTheFloorItStillShowsTheClay)
{
    const std::vector<Mesh> clay = {dented_ball(0)};
    for (const Vec3<float> eye : {Vec3<float>{0.5f, 2, 0.5f}, Vec3<float>{0.5f, -1, 0.6f}}) {
        const Camera camera{eye, ball_centre, 0.6f, 120, 90};
        EXPECT_NE(painter->paint(clay, {}, camera, 0).rgb, painter->paint({}, {}, camera, 0).rgb);
    }
}

TEST(Hull, EveryVertexLiesOnTheExactHullAndTheSurfaceIsClosed)
{
    DrawPrimitive primitive{3, {}};
    primitive.sphere[0].c = {0.1f, 0.2f, 0.3f};
    primitive.sphere[1].c = {0.4f, 0.1f, 0.2f};
    primitive.sphere[2].c = {0.2f, 0.5f, 0.25f};
    primitive.sphere[0].r = 0.05f, primitive.sphere[1].r = 0.08f, primitive.sphere[2].r = 0.03f;
    for (int count = 1; count <= 3; ++count) {
        primitive.count = count;
        const auto exact = shape(count, primitive.sphere[0], primitive.sphere[count > 1 ? 1 : 0],
                                 primitive.sphere[count - 1]);
        Geometry g{};
        add_hull(g, primitive, 3, {1, 1, 1});
        ASSERT_EQ(g.triangles.size(), 1280u);
        for (const PaintVertex& v : g.vertices)
            EXPECT_NEAR(closest_point(exact, v.place).phi, 0, 2e-6f);
        std::map<std::pair<int, int>, int> edges;
        for (const Int3 t : g.triangles) {
            ++edges[{t.x, t.y}], ++edges[{t.y, t.z}], ++edges[{t.z, t.x}];
        }
        for (const auto& [edge, times] : edges) {
            EXPECT_EQ(times, 1);
            EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
        }
    }
}

#else

TEST(Picture, WithoutOpenGlTheReasonIsSaid)
{
    try {
        Painter::open();
        FAIL() << "a painter without OpenGL";
    } catch (const std::runtime_error& reason) {
        EXPECT_NE(std::string(reason.what()).find("no pictures"), std::string::npos);
    }
}

#endif

}  // namespace
}  // namespace knead
