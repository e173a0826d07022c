#include "render/eye_shapes.h"

#include <algorithm>
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

}  // namespace knead
