#include "tests/openxr_replay/pictures.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "render/gl.h"

namespace knead::replay {
namespace {

// Reads by a framebuffer of its own, and leaves the bindings as they were.
template <class Value>
std::vector<Value> pixels(ShownTexture texture, GLenum attachment, GLenum format, GLenum type,
                          const int box[4], int values)
{
    GLint before = 0, packed = 0, buffer = 0;
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &before);
    glGetIntegerv(GL_PACK_ALIGNMENT, &packed);
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &buffer);
    std::vector<Value> all(std::size_t(box[2]) * std::size_t(box[3]) * std::size_t(values));
    GLuint from = 0;
    glCreateFramebuffers(1, &from);
    if (texture.layer == ShownTexture::whole)
        glNamedFramebufferTexture(from, attachment, texture.name, 0);
    else
        glNamedFramebufferTextureLayer(from, attachment, texture.name, 0, texture.layer);
    if (attachment == GL_COLOR_ATTACHMENT0)
        glNamedFramebufferReadBuffer(from, GL_COLOR_ATTACHMENT0);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, from);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(box[0], box[1], box[2], box[3], format, type, all.data());
    glPixelStorei(GL_PACK_ALIGNMENT, packed);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, GLuint(buffer));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, GLuint(before));
    glDeleteFramebuffers(1, &from);
    return all;
}

}  // namespace

Image colour_of(ShownTexture texture, int x, int y, int width, int height)
{
    const int box[4] = {x, y, width, height};
    const auto all =
        pixels<std::uint8_t>(texture, GL_COLOR_ATTACHMENT0, GL_RGB, GL_UNSIGNED_BYTE, box, 3);
    Image image{width, height, std::vector<std::uint8_t>(all.size())};
    const std::size_t row = 3 * std::size_t(width);
    for (std::size_t r = 0; r < std::size_t(height); ++r)
        std::memcpy(&image.rgb[r * row], &all[(std::size_t(height) - 1 - r) * row], row);
    return image;
}

DepthInfo depth_of(ShownTexture texture, int x, int y, int width, int height)
{
    const int box[4] = {x, y, width, height};
    const auto all =
        pixels<float>(texture, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT, GL_FLOAT, box, 1);
    DepthInfo facts;
    double sum = 0, count = 0;
    for (const float value : all) {
        facts.nearest = std::min(facts.nearest, value);
        facts.farthest = std::max(facts.farthest, value);
        if (value < 1) sum += double(value), ++count;
    }
    facts.covered = count / double(all.size());
    facts.mean = count > 0 ? sum / count : 0;
    return facts;
}

}  // namespace knead::replay
