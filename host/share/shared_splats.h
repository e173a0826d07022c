// OpenGL textures that receive splat pictures from a CUDA device without a copy through host
// memory.
#pragma once
#include <memory>

#include "host/splats/device_gaussians.h"
#include "host/splats/gpu_raster.h"

namespace knead {

class SharedSplats {
  public:
    // The same GL context must be current whenever this object is used or deleted.
    explicit SharedSplats(int device);
    ~SharedSplats();
    SharedSplats(const SharedSplats&) = delete;

    // Registers GL textures for eye 0 or 1 in place of earlier ones: `colour` GL_RGBA16F and
    // `depth` GL_R32F, of this size [pixels]. Throws std::runtime_error on a CUDA error.
    void take(int eye, unsigned colour, unsigned depth, int width, int height);
    void drop();  // unregisters all textures

    // Enqueues drawing of the frame's one or two eyes into their textures, ordered before later GL
    // commands, without blocking the host. Depths are spread (cuda/splats/spread.h); row 0 is the
    // top. `moved`, if not null, replaces positions and deformations of the first splats. Throws as
    // GpuRaster::launch(), and std::invalid_argument for an eye larger than its textures.
    void draw(GpuRaster& raster, const SplatFrame& frame, const DeviceGaussians* moved);
    // Device time of a recent picture with these textures [s]; 0: unknown.
    double seconds() const;

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
