// Splats of a live scene as an eye sees them, for a live painter.
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

// Where the first splats are, as many as there are Gaussians: those of one of these, or none.
struct SplatMotion {
    const std::vector<Gaussian<double>>* host = nullptr;
    const DeviceGaussians* device = nullptr;
    // They have gone on as they came, by so much of their way since `before`, or the device's.
    const std::vector<Gaussian<double>>* host_before = nullptr;
    float extrapolation = 0;
    bool any() const { return host || device; }
};

class SplatDrawer {
  public:
    // By the rasteriser of that device, with fewer pixels where a picture would take longer than
    // `budget` [s]. Throws std::runtime_error where the device cannot.
    SplatDrawer(const SplatCloud& cloud, Device device, double budget);

    // Coarse beside what an eye looks at, from now on.
    void foveate(const Fovea<float>& fovea) { fovea_ = fovea; }
    // Others from now on: the clay's were split, or some came or went.
    void set(const SplatCloud& cloud);
    // The same without making the caller wait: a thread of its own brings them to the device, while
    // those before are drawn. adopt() is true when they are drawn from now on.
    void prepare(std::shared_ptr<const SplatCloud> cloud);
    bool preparing() const { return coming_cloud_ != nullptr; }
    bool adopt();

    // `whole`: with all pixels, however long that takes. `hidden`: what nobody sees; null: nothing.
    SplatLayer layer(const EyeView& view, const SplatMotion& motion, bool whole = false,
                     HiddenTiles* hidden = nullptr);
    // The same to eyes 0 and 1 of a painter, or 0 alone: shared with it where that can be.
    // `hidden`: of each eye; null: nothing.
    void draw(EyePainter& painter, const std::vector<EyeView>& views, const SplatMotion& motion,
              bool whole = false, std::array<HiddenTiles, 2>* hidden = nullptr);

    double scale() const { return scale_; }      // of the last layer, share of the view's sides
    double seconds() const { return seconds_; }  // that it took [s]

  private:
    std::unique_ptr<GpuRaster> raster_of(const SplatCloud& cloud, std::size_t instances) const;
    SplatFrame frame_of(const std::vector<EyeView>& views, const SplatMotion& motion,
                        HiddenTiles* hidden) const;

    Device device_;
    SplatCloud cloud_;  // of the CPU's
    bool antialiased_;
    Fovea<float> fovea_;
    std::unique_ptr<GpuRaster> gpu_;
    std::shared_ptr<const SplatCloud> coming_cloud_;
    std::future<std::unique_ptr<GpuRaster>> coming_;
    std::future<void> going_;  // of what was drawn before: to free memory waits for the device
    double budget_;
    Pace pace_;
    bool shared_ = false;  // so was the last picture
    double scale_ = 1, seconds_ = 0;
};

// A rasteriser's picture before nothing, as a layer. What is too thin to have a depth takes that of
// what is beside it.
SplatLayer layer_of(const Picture& picture);

}  // namespace knead
