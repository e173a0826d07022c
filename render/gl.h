// The functions of OpenGL 4.5, and GL objects that free themselves.
#pragma once
#include <utility>

#include "render/gl_functions.h"

namespace knead {

// Owns the name of one GL object; 0 is none. The context must be current when it is freed.
template <class Free>
class GlObject {
  public:
    GlObject() = default;
    explicit GlObject(GLuint name) : name_(name) {}
    GlObject(GlObject&& o) noexcept : name_(std::exchange(o.name_, 0)) {}
    GlObject& operator=(GlObject&& o) noexcept
    {
        std::swap(name_, o.name_);
        return *this;
    }
    ~GlObject()
    {
        if (name_ != 0) Free{}(name_);
    }
    operator GLuint() const { return name_; }

  private:
    GLuint name_ = 0;
};

struct FreeTexture {
    void operator()(GLuint name) const { glDeleteTextures(1, &name); }
};
struct FreeBuffer {
    void operator()(GLuint name) const { glDeleteBuffers(1, &name); }
};
struct FreeFramebuffer {
    void operator()(GLuint name) const { glDeleteFramebuffers(1, &name); }
};
struct FreeVertexArray {
    void operator()(GLuint name) const { glDeleteVertexArrays(1, &name); }
};
struct FreeShader {
    void operator()(GLuint name) const { glDeleteShader(name); }
};
struct FreeProgram {
    void operator()(GLuint name) const { glDeleteProgram(name); }
};
using Texture = GlObject<FreeTexture>;
using Buffer = GlObject<FreeBuffer>;
using Framebuffer = GlObject<FreeFramebuffer>;
using VertexArray = GlObject<FreeVertexArray>;
using Shader = GlObject<FreeShader>;
using Program = GlObject<FreeProgram>;

inline Texture texture(GLenum kind)
{
    GLuint name = 0;
    glCreateTextures(kind, 1, &name);
    return Texture(name);
}
inline Buffer buffer()
{
    GLuint name = 0;
    glCreateBuffers(1, &name);
    return Buffer(name);
}
inline Framebuffer framebuffer()
{
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    return Framebuffer(name);
}
inline VertexArray vertex_array()
{
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return VertexArray(name);
}

}  // namespace knead
