// Where Gaussians are, kept on the device where a solver moves them, for who draws them there.
#pragma once
#include <memory>

#include "host/solver/solver.h"
#include "host/splats/raster.h"

namespace knead {
namespace gpu {
struct KeptGaussians;  // host/splats/device_gaussians.cuh
}  // namespace gpu

// In the order of attaching. Never changes. May be read by any thread, and let go of by any.
class DeviceGaussians {
  public:
    // `before`: the same Gaussians in the state before; null: nothing is known of it.
    explicit DeviceGaussians(std::shared_ptr<gpu::KeptGaussians> kept,
                             std::shared_ptr<gpu::KeptGaussians> before = nullptr);

    int device() const;
    std::size_t count() const;
    // Into a frame that is drawn elsewhere: moved_centre and moved_F, as its `ahead` asks. Waits.
    void fetch(SplatFrame& frame) const;
    gpu::KeptGaussians& kept() const { return *kept_; }
    gpu::KeptGaussians* before() const { return before_.get(); }

  private:
    std::shared_ptr<gpu::KeptGaussians> kept_, before_;
};

// Keeps them in memory that nobody reads any more.
class GaussianKeeper {
  public:
    GaussianKeeper();
    ~GaussianKeeper();
    GaussianKeeper(const GaussianKeeper&) = delete;

    // As the last frame or edit left them, launched behind it; waits for nothing. `same`: they are
    // those that were kept last.
    std::shared_ptr<const DeviceGaussians> kept(const gpu::MovedGaussians& moved, bool same);

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
