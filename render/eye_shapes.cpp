#include "render/eye_shapes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace knead {
namespace {

int so_far(const Geometry& geometry) { return int(geometry.triangles.size()); }

}  // namespace

std::vector<DrawnClay> gather_clay(Geometry& geometry, const std::vector<Mesh>& meshes,
                                   const std::vector<int>& unseen)
{
    std::vector<DrawnClay> drawn;
    for (const Mesh& mesh : meshes) {
        const int first = so_far(geometry);
        add_clay(geometry, mesh);
        const bool seen = std::find(unseen.begin(), unseen.end(), mesh.category) == unseen.end();
        drawn.push_back({{first, so_far(geometry) - first}, mesh.category, seen});
    }
    return drawn;
}

std::vector<DrawnHand> gather_hands(Geometry& geometry, const std::vector<HandLook>& hands)
{
    std::vector<DrawnHand> drawn;
    for (const HandLook& hand : hands) drawn.push_back({add_hand(geometry, hand), hand.opacity});
    return drawn;
}

void DrawnSplats::upload(const SplatLayer& layer)
{
    const std::size_t pixels = std::size_t(layer.width) * std::size_t(layer.height);
    if (layer.width < 0 || layer.height < 0 || layer.colour.size() != 4 * pixels ||
        layer.depth.size() != pixels)
        throw std::invalid_argument("a layer of splats whose arrays are not of its size");
    colour_name = depth_name = 0;
    if (pixels == 0) return;
    if (width != layer.width || height != layer.height) {
        colour = texture(GL_TEXTURE_2D), depth = texture(GL_TEXTURE_2D);
        glTextureStorage2D(colour, 1, GL_RGBA16F, layer.width, layer.height);
        glTextureStorage2D(depth, 1, GL_R32F, layer.width, layer.height);
        for (const GLuint name : {GLuint(colour), GLuint(depth)}) {
            const GLint filter = name == colour ? GL_LINEAR : GL_NEAREST;
            glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, filter);
            glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, filter);
            glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
            glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        }
        width = layer.width, height = layer.height;
    }
    glTextureSubImage2D(colour, 0, 0, 0, layer.width, layer.height, GL_RGBA, GL_FLOAT,
                        layer.colour.data());
    glTextureSubImage2D(depth, 0, 0, 0, layer.width, layer.height, GL_RED, GL_FLOAT,
                        layer.depth.data());
    colour_name = colour, depth_name = depth;
}

void DrawnHidden::set(const std::vector<std::array<float, 2>>& to)
{
    if (to == corners) return;
    const bool sound = to.size() % 3 == 0 && std::all_of(to.begin(), to.end(), [](const auto& c) {
                           return std::isfinite(c[0]) && std::isfinite(c[1]);
                       });
    if (!sound) throw std::invalid_argument("a hidden area that is not of finite triangles");
    corners = to;
    glNamedBufferData(vertices, GLsizeiptr(corners.size() * sizeof corners[0]), corners.data(),
                      GL_STATIC_DRAW);
    glVertexArrayVertexBuffer(layout, 0, vertices, 0, sizeof corners[0]);
    glEnableVertexArrayAttrib(layout, 0);
    glVertexArrayAttribFormat(layout, 0, 2, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(layout, 0, 0);
}

void DrawnHidden::draw() const
{
    glBindVertexArray(layout);
    glDrawArrays(GL_TRIANGLES, 0, GLsizei(corners.size()));
}

}  // namespace knead
