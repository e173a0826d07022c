// Snapshots of a solver's Gaussians in device memory, for rendering on the same device.
#pragma once
#include <memory>

#include "host/solver/simulator.h"
#include "host/splats/raster.h"

namespace knead {
namespace gpu {
struct KeptGaussians;  // host/splats/device_gaussians.cuh
}  // namespace gpu

// A snapshot, in the order of attachment. Immutable. Thread-safe, including destruction.
class DeviceGaussians {
  public:
    // `before`: the same Gaussians in the previous state; null: unknown.
    explicit DeviceGaussians(std::shared_ptr<gpu::KeptGaussians> kept,
                             std::shared_ptr<gpu::KeptGaussians> before = nullptr);

    int device() const;
    std::size_t count() const;
    // Downloads into moved_centre and moved_F, extrapolated by `frame.extrapolation`, for rendering
    // elsewhere. Blocks.
    void fetch(SplatFrame& frame) const;
    gpu::KeptGaussians& kept() const { return *kept_; }
    gpu::KeptGaussians* before() const { return before_.get(); }

  private:
    std::shared_ptr<gpu::KeptGaussians> kept_, before_;
};

// Takes snapshots, reusing the memory of released ones.
class GaussianKeeper {
  public:
    GaussianKeeper();
    ~GaussianKeeper();
    GaussianKeeper(const GaussianKeeper&) = delete;

    // Takes a snapshot of the Gaussians after the last frame or edit: enqueued on the solver's
    // stream; does not block. `same`: they are the Gaussians of the previous snapshot.
    std::shared_ptr<const DeviceGaussians> kept(const gpu::MovedGaussians& moved, bool same);

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
