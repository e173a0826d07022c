// Live pictures for tests: a painter in a context of its own, and a framebuffer to draw into.
#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "render/eye_painter.h"
#if KNEAD_HAS_GL
#include "render/context.h"
#include "render/gl.h"

namespace knead {

constexpr Vec3<float> ball_centre{0.5f, 0.25f, 0.5f};
constexpr int picture_width = 160, picture_height = 120;

inline Mesh ball(Vec3<float> centre, float radius, int category = 0)
{
    Geometry sphere{};
    DrawPrimitive primitive{1, {}};
    primitive.sphere[0].r = radius, primitive.sphere[0].c = centre;
    add_hull(sphere, primitive, 4, {0, 0, 0});
    Mesh mesh;
    mesh.category = category;
    for (const PaintVertex& v : sphere.vertices) {
        mesh.vertices.push_back(v.place);
        mesh.normals.push_back(v.normal);
    }
    mesh.triangles = sphere.triangles;
    return mesh;
}

inline EyeView front()
{
    return eye_view({{0.5f, 0.6f, 1.9f}, ball_centre, 0.6f, picture_width, picture_height});
}

// A framebuffer to draw into, and what was drawn, rows from below.
struct OffscreenTarget {
    explicit OffscreenTarget(GLenum format, int w = picture_width, int h = picture_height)
        : width(w), height(h)
    {
        colour = texture(GL_TEXTURE_2D), depth = texture(GL_TEXTURE_2D), frame = framebuffer();
        glTextureStorage2D(colour, 1, format, w, h);
        glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, w, h);
        glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, colour, 0);
        glNamedFramebufferTexture(frame, GL_DEPTH_ATTACHMENT, depth, 0);
    }
    std::vector<int> colours() const  // red, green, blue, alpha as stored
    {
        std::vector<std::uint8_t> bytes(std::size_t(4 * width * height));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, frame);
        glDisable(GL_FRAMEBUFFER_SRGB);
        glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
        return {bytes.begin(), bytes.end()};
    }
    std::vector<float> depths() const
    {
        std::vector<float> values(std::size_t(width * height));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, frame);
        glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, values.data());
        return values;
    }
    int width, height;
    Texture colour, depth;
    Framebuffer frame;
};

inline int red_green_blue(const std::vector<int>& c, int pixel)
{
    return c[std::size_t(4 * pixel)] + c[std::size_t(4 * pixel + 1)] +
           c[std::size_t(4 * pixel + 2)];
}

class EyePicture : public testing::Test {
  protected:
    void SetUp() override
    {
        try {
            context = std::make_unique<Context>();
        } catch (const std::runtime_error& reason) {
            GTEST_SKIP() << reason.what();
        }
        bound = std::make_unique<Context::Bound>(*context);
        painter = EyePainter::open(4);
        plain = std::make_unique<OffscreenTarget>(GL_RGBA8);
    }
    void TearDown() override
    {
        if (bound) {
            EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
        }
        plain.reset(), painter.reset(), bound.reset(), context.reset();
    }
    std::vector<int> painted(const EyeView& view = front(), const EyeLook& look = {})
    {
        painter->paint(view, look, {plain->frame});
        return plain->colours();
    }
    std::unique_ptr<Context> context;
    std::unique_ptr<Context::Bound> bound;
    std::unique_ptr<EyePainter> painter;
    std::unique_ptr<OffscreenTarget> plain;
};

}  // namespace knead
#endif
