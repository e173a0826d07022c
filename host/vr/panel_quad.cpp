#include "host/vr/panel_quad.h"

#ifdef KNEAD_HAS_GL

#include <stdexcept>

#include "render/program.h"

namespace knead {
namespace {

constexpr const char* vertex = R"(#version 450 core
layout(location = 0) uniform vec4 corners[4];
out vec2 at;
void main()
{
    at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = corners[gl_VertexID];
}
)";
constexpr const char* fragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D picture;
in vec2 at;
layout(location = 0) out vec4 colour;
void main()
{
    colour = vec4(texture(picture, at).rgb, 1);
}
)";

}  // namespace

PanelQuad::PanelQuad(int width, int height, bool srgb)
    : drawn(program({vertex}, {fragment}, "panel")),
      picture(texture(GL_TEXTURE_2D)),
      nothing(vertex_array())
{
    int levels = 1;
    while (levels < 4 && width >> levels > 16) ++levels;
    glTextureStorage2D(picture, levels, srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, width, height);
    glTextureParameteri(picture, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(picture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(picture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(picture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void PanelQuad::upload(const PanelCanvas& canvas)
{
    glTextureSubImage2D(picture, 0, 0, 0, canvas.width(), canvas.height(), GL_RGBA,
                        GL_UNSIGNED_BYTE, canvas.rgba().data());
    glGenerateTextureMipmap(picture);
}

void PanelQuad::draw(const std::array<Vec3<float>, 4>& corners, const EyeView& view,
                     const EyeTarget& target) const
{
    float clips[16];
    for (std::size_t k = 0; k < 4; ++k) {
        const std::array<float, 4> clip = clip_of(view, corners[k]);
        std::copy(clip.begin(), clip.end(), clips + 4 * k);
    }
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
    glViewport(target.x, target.y, view.width, view.height);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    (target.linear ? glEnable : glDisable)(GL_FRAMEBUFFER_SRGB);
    glUseProgram(drawn);
    glUniform4fv(0, 4, clips);
    const GLuint name = picture;
    glBindTextures(0, 1, &name);
    glBindVertexArray(nothing);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    glBindTextures(0, 1, nullptr);
    glBindVertexArray(0);
    glUseProgram(0);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

}  // namespace knead
#endif
