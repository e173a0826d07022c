// Splats of a live scene as an eye sees them, for a live painter.
#pragma once
#include <memory>
#include <vector>

#include "cuda/splats/deform.h"
#include "host/session/device.h"
#include "host/session/hidden_tiles.h"
#include "host/splats/gpu_raster.h"
#include "host/splats/raster.h"
#include "render/eye_painter.h"
#include "render/pace.h"

namespace knead {

class SplatDrawer {
  public:
    // By the rasteriser of that device, with fewer pixels where a picture would take longer than
    // `budget` [s]. Throws std::runtime_error where the device cannot.
    SplatDrawer(const SplatCloud& cloud, Device device, double budget);

    // Others from now on: the clay's were split, or some came or went.
    void set(const SplatCloud& cloud);

    // Of the first splats, as many as there are Gaussians are where these are. `whole`: with all
    // pixels, however long that takes. `hidden`: what nobody sees; null: nothing.
    SplatLayer layer(const EyeView& view, const std::vector<Gaussian<double>>& gaussians,
                     bool whole = false, HiddenTiles* hidden = nullptr);

    double scale() const { return scale_; }      // of the last layer, share of the view's sides
    double seconds() const { return seconds_; }  // that it took [s]

  private:
    Device device_;
    SplatCloud cloud_;  // of the CPU's
    bool antialiased_;
    std::unique_ptr<GpuRaster> gpu_;
    Pace pace_;
    double scale_ = 1, seconds_ = 0;
};

// A rasteriser's picture before nothing, as a layer. What is too thin to have a depth takes that of
// what is beside it.
SplatLayer layer_of(const Picture& picture);

}  // namespace knead
