#include "host/vr/panel_quad.h"

#ifdef KNEAD_HAS_GL

#include <stdexcept>

#include "render/program.h"

namespace knead {
namespace {

constexpr const char* vertex = R"(#version 450 core
layout(location = 0) uniform vec4 corners[4];
layout(location = 4) uniform vec4 part;  // texture coordinates, upper left and lower right
out vec2 at;
void main()
{
    at = mix(part.xy, part.zw, vec2(gl_VertexID & 1, gl_VertexID >> 1));
    gl_Position = corners[gl_VertexID];
}
)";
constexpr const char* fragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D picture;
in vec2 at;
layout(location = 0) out vec4 colour;
layout(location = 1) out float mark;  // no splat covers it (EyePainter::DrawBetween)
void main()
{
    colour = vec4(texture(picture, at).rgb, 1);
    mark = 1;
}
)";

}  // namespace

PanelQuad::PanelQuad() : drawn(program({vertex}, {fragment}, "panel")), nothing(vertex_array()) {}

void PanelQuad::draw(const std::array<Vec3<float>, 4>& corners, const EyeView& view,
                     const EyeTarget& target, const PanelTexture& from) const
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
    glDepthFunc(GL_ALWAYS);
    (target.linear ? glEnable : glDisable)(GL_FRAMEBUFFER_SRGB);
    glUseProgram(drawn);
    glUniform4fv(0, 4, clips);
    glUniform4f(4, from.u0, from.v0, from.u1, from.v1);
    glBindTextures(0, 1, &from.name);
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
