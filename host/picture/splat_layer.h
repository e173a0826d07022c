// Draws the splats of a live scene as layers for a live painter.
#pragma once
#include <array>
#include <future>
#include <memory>
#include <vector>

#include "cuda/splats/deform.h"
#include "host/picture/hidden_tiles.h"
#include "host/session/backend.h"
#include "host/splats/device_gaussians.h"
#include "host/splats/gpu_raster.h"
#include "host/splats/raster.h"
#include "render/eye_painter.h"
#include "render/pace.h"

namespace knead {

// Motion of the first splats of a cloud, one per Gaussian. At most one of `host` and `device` is
// set.
struct SplatMotion {
    const std::vector<Gaussian<double>>* host = nullptr;
    const DeviceGaussians* device = nullptr;
    // Extrapolation: this factor of the last displacement is added, since `host_before` or the
    // device's own previous positions.
    const std::vector<Gaussian<double>>* host_before = nullptr;
    float extrapolation = 0;
    bool any() const { return host || device; }
};

class SplatDrawer {
  public:
    // Uses the rasteriser of that device, with reduced resolution if a picture would take longer
    // than `budget` [s]. Throws std::runtime_error if the device cannot be used.
    SplatDrawer(const SplatCloud& cloud, Device device, double budget);

    // Reduces the resolution outside the fovea.
    void foveate(const Fovea<float>& fovea) { fovea_ = fovea; }
    // Replaces the splats.
    void set(const SplatCloud& cloud);
    // Asynchronous variant: a thread uploads them while the old ones are drawn. adopt() returns
    // true when the new ones have replaced them.
    void prepare(std::shared_ptr<const SplatCloud> cloud);
    bool preparing() const { return coming_cloud_ != nullptr; }
    bool adopt();

    // `whole`: full resolution, regardless of the budget. `hidden`: tiles to skip; null: none.
    SplatLayer layer(const EyeView& view, const SplatMotion& motion, bool full_resolution = false,
                     HiddenTiles* hidden = nullptr);
    // Draws the layers of eyes 0 and 1 of a painter, or of 0 alone, without a copy through the host
    // if CUDA and OpenGL share memory. `hidden`: per eye; null: none.
    void draw(EyePainter& painter, const std::vector<EyeView>& views, const SplatMotion& motion,
              bool full_resolution = false, std::array<HiddenTiles, 2>* hidden = nullptr);

    double scale() const { return scale_; }      // linear resolution of the last layer, 0 to 1
    double seconds() const { return seconds_; }  // time of the last layer [s]

  private:
    std::unique_ptr<GpuRaster> raster_of(const SplatCloud& cloud, std::size_t instances) const;
    SplatFrame frame_of(const std::vector<EyeView>& views, const SplatMotion& motion,
                        HiddenTiles* hidden) const;

    Device device_;
    SplatCloud cloud_;  // for the CPU's rasteriser
    bool antialiased_;
    Fovea<float> fovea_;
    std::unique_ptr<GpuRaster> gpu_;
    std::shared_ptr<const SplatCloud> coming_cloud_;
    std::future<std::unique_ptr<GpuRaster>> coming_;
    std::future<void> going_;  // frees the old rasteriser, which waits for the device
    double budget_;
    Pace pace_;
    bool shared_ = false;  // the last picture was shared with OpenGL
    double scale_ = 1, seconds_ = 0;
};

// Converts a picture without background to a layer. Pixels too transparent to have a depth take the
// depth of their neighbours.
SplatLayer layer_of(const Picture& picture);

}  // namespace knead
