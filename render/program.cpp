#include "render/program.h"

#include <cstddef>
#include <stdexcept>
#include <vector>

#include "render/geometry.h"

namespace knead {
namespace {

Shader shader(GLenum kind, const std::initializer_list<std::string>& pieces,
              const std::string& name)
{
    Shader made(glCreateShader(kind));
    std::vector<const char*> texts;
    for (const std::string& piece : pieces) texts.push_back(piece.c_str());
    glShaderSource(made, GLsizei(texts.size()), texts.data(), nullptr);
    glCompileShader(made);
    GLint fine = 0;
    glGetShaderiv(made, GL_COMPILE_STATUS, &fine);
    if (!fine) {
        char log[2000] = "";
        glGetShaderInfoLog(made, sizeof log, nullptr, log);
        throw std::runtime_error("no pictures: the shader " + name + ": " + log);
    }
    return made;
}

}  // namespace

Program program(std::initializer_list<std::string> vertex,
                std::initializer_list<std::string> fragment, const std::string& name)
{
    const Shader v = shader(GL_VERTEX_SHADER, vertex, name);
    const Shader f = shader(GL_FRAGMENT_SHADER, fragment, name);
    Program made(glCreateProgram());
    glAttachShader(made, v);
    glAttachShader(made, f);
    glLinkProgram(made);
    GLint fine = 0;
    glGetProgramiv(made, GL_LINK_STATUS, &fine);
    if (!fine) {
        char log[2000] = "";
        glGetProgramInfoLog(made, sizeof log, nullptr, log);
        throw std::runtime_error("no pictures: the program " + name + ": " + log);
    }
    return made;
}

VertexArray paint_layout(GLuint vertices, GLuint triangles)
{
    VertexArray layout = vertex_array();
    const struct {
        GLint count;
        std::size_t offset;
    } fields[] = {{3, offsetof(PaintVertex, place)},
                  {3, offsetof(PaintVertex, normal)},
                  {4, offsetof(PaintVertex, colour)},
                  {1, offsetof(PaintVertex, advance)}};
    for (GLuint i = 0; i < 4; ++i) {
        glEnableVertexArrayAttrib(layout, i);
        glVertexArrayAttribFormat(layout, i, fields[i].count, GL_FLOAT, GL_FALSE,
                                  GLuint(fields[i].offset));
        glVertexArrayAttribBinding(layout, i, 0);
    }
    glVertexArrayVertexBuffer(layout, 0, vertices, 0, sizeof(PaintVertex));
    glVertexArrayElementBuffer(layout, triangles);
    return layout;
}

Texture shadow_maps(int side, int layers)
{
    Texture maps = texture(GL_TEXTURE_2D_ARRAY);
    glTextureStorage3D(maps, 1, GL_DEPTH_COMPONENT16, side, side, layers);
    const float far[4] = {1, 1, 1, 1};
    glTextureParameterfv(maps, GL_TEXTURE_BORDER_COLOR, far);
    glTextureParameteri(maps, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTextureParameteri(maps, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    glTextureParameteri(maps, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(maps, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(maps, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTextureParameteri(maps, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    return maps;
}

}  // namespace knead
