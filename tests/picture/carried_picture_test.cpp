// What a picture shows of clay and splats that have gone on since their state.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "host/picture/splat_layer.h"
#include "render/geometry.h"
#if KNEAD_HAS_GL
#include "render/context.h"
#include "render/gl.h"
#endif

namespace knead {
namespace {

EyeView eye_before()
{
    EyeView view;
    view.position = {0, 0, 1.5f};
    view.width = 128, view.height = 96;
    return view;
}

SplatCloud some_splats()
{
    SplatCloud cloud;
    resize(cloud, 60);
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const float a = 0.31f * float(i);
        cloud.centre[i] = {0.6f * std::cos(a), 0.5f * std::sin(1.7f * a), 0.3f * std::sin(a)};
        cloud.scale[i] = {0.05f, 0.02f, 0.03f};
        cloud.rotation[i] = {1, 0, 0, 0};
        cloud.opacity[i] = 0.8f;
    }
    return cloud;
}

std::vector<Gaussian<double>> at(const SplatCloud& cloud, Vec3<double> way, double stretch)
{
    std::vector<Gaussian<double>> all;
    for (const Vec3<float>& x : cloud.centre) {
        Gaussian<double> g = gaussian_at(cast<double>(x) + way, 0);
        g.F.a.x += stretch;
        all.push_back(g);
    }
    return all;
}

// Half of the way more, and half of the stretch.
TEST(CarriedPicture, ShowsSplatsWhereTheyHaveComeByThen)
{
    const SplatCloud cloud = some_splats();
    const auto before = at(cloud, {0, 0, 0}, 0), now = at(cloud, {0.02, 0.04, 0}, 0.5),
               then = at(cloud, {0.03, 0.06, 0}, 0.75);
    SplatDrawer drawer(cloud, Device{DeviceKind::cpu}, 1);
    const auto drawn = [&](const SplatMotion& motion) {
        return drawer.layer(eye_before(), motion, true).colour;
    };
    const auto wanted = drawn({&then});
    EXPECT_EQ(drawn({&now, nullptr, &before, 0.5f}), wanted);
    EXPECT_NE(drawn({&now, nullptr, &before, 0}), wanted);
    EXPECT_EQ(drawn({&now, nullptr, &before, 0}), drawn({&now}));
    const std::vector<Gaussian<double>> others(before.begin(), before.end() - 1);
    EXPECT_EQ(drawn({&now, nullptr, &others, 0.5f}), drawn({&now})) << "other splats";
}

Mesh ball(float radius, float advance)
{
    Geometry sphere{};
    DrawPrimitive primitive{1, {}};
    primitive.sphere[0].r = radius, primitive.sphere[0].c = {0.5f, 0.3f, 0.5f};
    add_hull(sphere, primitive, 4, {0, 0, 0});
    Mesh mesh;
    for (const PaintVertex& v : sphere.vertices) {
        mesh.vertices.push_back(v.place), mesh.normals.push_back(v.normal);
        mesh.advance.push_back(advance);
    }
    mesh.triangles = sphere.triangles;
    return mesh;
}

TEST(CarriedPicture, LeavesOutTrianglesOfWhichNobodyKnowsWhereTheyWillBe)
{
    Geometry whole{}, part{};
    Mesh mesh = ball(0.2f, 0.01f);
    add_clay(whole, mesh);
    mesh.advance[7] = std::nanf("");
    add_clay(part, mesh);
    EXPECT_LT(part.triangles.size(), whole.triangles.size());
    EXPECT_GE(part.triangles.size() + 6, whole.triangles.size());
}

#if KNEAD_HAS_GL

// A ball that grew by so much is drawn as large as it will be; depth and all.
TEST(CarriedPicture, ShowsClayWhereItHasComeByThen)
{
    std::unique_ptr<Context> context;
    try {
        context = std::make_unique<Context>();
    } catch (const std::runtime_error& reason) {
        GTEST_SKIP() << reason.what();
    }
    const Context::Bound bound(*context);
    const EyeView view = eye_view({{0.5f, 0.6f, 1.9f}, {0.5f, 0.3f, 0.5f}, 0.6f, 160, 120});
    const auto depths = [&](const Mesh& mesh, float ahead) {
        const std::unique_ptr<EyePainter> painter = EyePainter::open(1, false);
        const Texture colour = texture(GL_TEXTURE_2D), depth = texture(GL_TEXTURE_2D);
        const Framebuffer frame = framebuffer();
        glTextureStorage2D(colour, 1, GL_RGBA8, view.width, view.height);
        glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, view.width, view.height);
        glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, colour, 0);
        glNamedFramebufferTexture(frame, GL_DEPTH_ATTACHMENT, depth, 0);
        painter->set_clay({mesh}, 1);
        EyeLook look;
        look.extrapolation = ahead;
        painter->paint(view, look, {frame});
        std::vector<float> values(std::size_t(view.width * view.height));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, frame);
        glReadPixels(0, 0, view.width, view.height, GL_DEPTH_COMPONENT, GL_FLOAT, values.data());
        return values;
    };
    const auto apart = [](const std::vector<float>& a, const std::vector<float>& b) {
        int pixels = 0;
        for (std::size_t i = 0; i < a.size(); ++i) pixels += std::abs(a[i] - b[i]) > 1e-5f;
        return pixels;
    };
    const auto wanted = depths(ball(0.2f, 0), 0);
    EXPECT_LE(apart(depths(ball(0.18f, 0.04f), 0.5f), wanted), 8) << "rounding at its rim";
    EXPECT_GT(apart(depths(ball(0.18f, 0.04f), 0), wanted), 500);
    Mesh untold = ball(0.2f, 0);
    untold.advance.clear();
    EXPECT_EQ(apart(depths(untold, 1), wanted), 0);
    EXPECT_THROW(depths(untold, std::nanf("")), std::invalid_argument);
    EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
}

#endif

}  // namespace
}  // namespace knead
