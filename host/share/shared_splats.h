// Textures of OpenGL's that take pictures of splats from a CUDA device on that device.
#pragma once
#include <memory>

#include "host/splats/device_gaussians.h"
#include "host/splats/gpu_raster.h"

namespace knead {

class SharedSplats {
  public:
    // In the context that is current whenever this is used or deleted.
    explicit SharedSplats(int device);
    ~SharedSplats();
    SharedSplats(const SharedSplats&) = delete;

    // Registers textures, GL's names, of eye 0 or 1: GL_RGBA16F and GL_R32F, all of one size, in
    // place of earlier ones. Throws std::runtime_error where CUDA refuses.
    void take(int eye, unsigned colour, unsigned depth, int width, int height);
    void drop();  // all of them

    // Draws the eyes of the frame, one or two, into their textures, for what GL draws from now on,
    // and waits for nothing: depths as spread (cuda/splats/spread.h), row 0 the top. Throws as
    // GpuRaster::launch(), and std::invalid_argument for eyes larger than their textures.
    // `moved`: where the first splats are, in place of what the frame says; may be null.
    void draw(GpuRaster& raster, const SplatFrame& frame, const DeviceGaussians* moved);
    // What a picture took on the device, one of the last few of this size [s]; 0: none is known.
    double seconds() const;

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
