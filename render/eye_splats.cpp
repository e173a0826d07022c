#include "render/eye_splats.h"

#include <algorithm>
#include <stdexcept>

namespace knead {

void DrawnSplats::resize(int to_width, int to_height)
{
    colour = texture(GL_TEXTURE_2D), depth = texture(GL_TEXTURE_2D);
    glTextureStorage2D(colour, 1, GL_RGBA16F, to_width, to_height);
    glTextureStorage2D(depth, 1, GL_R32F, to_width, to_height);
    for (const GLuint name : {GLuint(colour), GLuint(depth)}) {
        const GLint filter = name == colour ? GL_LINEAR : GL_NEAREST;
        glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, filter);
        glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, filter);
        glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    width = to_width, height = to_height;
}

void EyeSplats::let_go()
{
    if (raster_) raster_->drop();
    for (DrawnSplats& s : eyes_) s.registered = false;
}

void EyeSplats::upload(int eye, const SplatLayer& layer)
{
    const std::size_t pixels = std::size_t(layer.width) * std::size_t(layer.height);
    if (layer.width < 0 || layer.height < 0 || layer.colour.size() != 4 * pixels ||
        layer.depth.size() != pixels)
        throw std::invalid_argument("a layer of splats whose arrays are not of its size");
    DrawnSplats& s = eyes_.at(std::size_t(eye));
    s.colour_name = s.depth_name = 0;
    if (pixels == 0) return;
    if (!s.is_of(layer.width, layer.height)) let_go(), s.resize(layer.width, layer.height);
    glTextureSubImage2D(s.colour, 0, 0, 0, layer.width, layer.height, GL_RGBA, GL_FLOAT,
                        layer.colour.data());
    glTextureSubImage2D(s.depth, 0, 0, 0, layer.width, layer.height, GL_RED, GL_FLOAT,
                        layer.depth.data());
    s.show(layer.width, layer.height);
}

void EyeSplats::set(int eye, GLuint colour, GLuint depth)
{
    DrawnSplats& s = eyes_.at(std::size_t(eye));
    s.colour_name = depth ? colour : 0, s.depth_name = depth;
    s.shown_width = s.shown_height = 0;
}

// Registering textures takes tens of milliseconds, so larger ones are reused.
void EyeSplats::draw(GpuRaster& raster, const SplatFrame& frame, const DeviceGaussians* moved)
{
    if (!raster_ || device_ != raster.device()) {
        let_go();
        raster_ = std::make_unique<SharedSplats>(raster.device());
        device_ = raster.device();
    }
    const std::size_t eyes = std::min(frame.eyes.size(), eyes_.size());
    bool stands = true;
    for (std::size_t e = 0; e < eyes; ++e)
        stands = stands && eyes_[e].registered &&
                 eyes_[e].holds(frame.eyes[e].width, frame.eyes[e].height);
    if (!stands) let_go();
    for (std::size_t e = 0; e < eyes && !stands; ++e) {
        DrawnSplats& s = eyes_[e];
        const Eye<float>& seen = frame.eyes[e];
        if (!s.holds(seen.width, seen.height))
            s.resize(std::max({s.width, seen.width, most_width_}),
                     std::max({s.height, seen.height, most_height_}));
        raster_->take(int(e), s.colour, s.depth, s.width, s.height);
        s.registered = true;
    }
    raster_->draw(raster, frame, moved);
    for (std::size_t e = 0; e < eyes; ++e) eyes_[e].show(frame.eyes[e].width, frame.eyes[e].height);
}

}  // namespace knead
