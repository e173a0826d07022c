// OpenGL state for drawing live pictures, and its reset.
#pragma once
#include "render/gl.h"

namespace knead {

// set_state(): all state that drawing depends on. reset_state(): back to the defaults of a new
// context.
inline void set_state()
{
    for (const GLenum off :
         {GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_BLEND, GL_CULL_FACE, GL_POLYGON_OFFSET_FILL,
          GL_SAMPLE_ALPHA_TO_COVERAGE, GL_RASTERIZER_DISCARD, GL_DEPTH_CLAMP, GL_FRAMEBUFFER_SRGB})
        glDisable(off);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_MULTISAMPLE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glDepthRangef(0, 1);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glBindSamplers(0, 5, nullptr);
}
inline void reset_state()
{
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glDepthFunc(GL_LESS);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glUseProgram(0);
    glBindVertexArray(0);
    glBindTextures(0, 5, nullptr);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, 0);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, 0);
}

}  // namespace knead
