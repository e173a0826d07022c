// Splat textures of both eyes: uploaded, written by CUDA, or the caller's.
#pragma once
#include <array>
#include <memory>

#include "host/share/shared_splats.h"
#include "render/eye_painter.h"
#include "render/gl.h"

namespace knead {

// Of one eye.
struct DrawnSplats {
    Texture colour, depth;
    int width = 0, height = 0;
    bool registered = false;                 // with CUDA
    int shown_width = 0, shown_height = 0;   // part used, from the first texel; 0: all
    GLuint colour_name = 0, depth_name = 0;  // textures drawn; 0: none

    bool is_of(int w, int h) const { return width == w && height == h; }
    bool holds(int w, int h) const { return width >= w && height >= h; }
    void resize(int to_width, int to_height);
    void show(int w, int h)
    {
        colour_name = colour, depth_name = depth;
        shown_width = w, shown_height = h;
    }
};

class EyeSplats {
  public:
    const DrawnSplats& of(int eye) const { return eyes_.at(std::size_t(eye)); }
    void upload(int eye, const SplatLayer& layer);
    void set(int eye, GLuint colour, GLuint depth);
    // Shared pictures up to this size [pixels] cause no reallocation.
    void expect(int width, int height) { most_width_ = width, most_height_ = height; }
    void draw(GpuRaster& raster, const SplatFrame& frame, const DeviceGaussians* moved);  // shared
    double seconds() const { return raster_ ? raster_->seconds() : 0; }

  private:
    void let_go();  // unregisters all textures from CUDA

    std::array<DrawnSplats, 2> eyes_;
    std::unique_ptr<SharedSplats> raster_;  // destroyed before the textures
    int device_ = -1;
    int most_width_ = 0, most_height_ = 0;  // as set by expect()
};

}  // namespace knead
