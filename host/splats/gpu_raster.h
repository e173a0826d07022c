// The rasteriser on the GPU: the same pictures as cpu_raster() within 16-bit rounding.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "host/solver/simulator.h"
#include "host/splats/raster.h"

namespace knead {
namespace gpu {
struct MovedSplats;   // cuda/splats/raster.cuh
struct RasterTarget;  // cuda/splats/raster.cuh
}  // namespace gpu

// Counts of the last frame.
struct RasterStats {
    std::size_t visible = 0;    // splats visible to an eye
    std::size_t instances = 0;  // entries of the tile lists; in the first frame per tile part
    std::size_t dropped = 0;    // of these, the farthest, dropped for lack of memory
    std::size_t deferred = 0;   // tile parts whose lists were split among several blocks
};

// Draws one cloud. `instances` is the capacity for pairs of tile and splat of both eyes; 0: grown
// by pictures() to one and a half times what is needed. Throws std::invalid_argument for a cloud
// with inconsistent array sizes, std::runtime_error if there is no device or not enough memory.
class GpuRaster {
  public:
    // `splats`: capacity for later clouds.
    explicit GpuRaster(const SplatCloud& cloud, std::size_t instances = 0, int device = -1,
                       std::size_t splats = 0);
    ~GpuRaster();

    // Replaces the cloud in two steps: prepare() uploads it from any one thread while the current
    // one is drawn (allocates only the first time); show_prepared() makes it current from the next
    // frame on, without blocking. serves() returns true if a cloud fits. Throws
    // std::invalid_argument as the constructor, and for a cloud that does not fit.
    bool serves(const SplatCloud& cloud) const;
    void prepare(const SplatCloud& cloud);
    void show_prepared();
    // Reserves capacity for at least `instances`. Call before the first frame.
    void reserve(std::size_t instances);

    // Draws, waits, downloads. The pictures of both eyes must have one size, of at most 65536 tiles
    // of 16 x 16 pixels together. Also throws as check_frame().
    std::vector<Picture> pictures(const SplatFrame& frame);

    // Enqueues a frame on a stream (a cudaStream_t); does not block. Of `frame`, only the eyes,
    // options, background, hidden tiles and foveas are used. Moved splats and the targets of the
    // pictures, one per eye, are in device memory. `moved` may be null. If `instances` was 0 and
    // capacity was exceeded, a later frame has enough.
    void launch(const SplatFrame& frame, const gpu::MovedSplats* moved,
                const gpu::RasterTarget* targets, void* stream);
    RasterStats stats() const;  // blocks

    // Durations of `count` replays of the last frame, and of each stage within one [s].
    std::vector<double> replays(int count);
    std::vector<StageTime> stage_times();
    int device() const;
    std::size_t memory() const;  // device memory [bytes]
    std::size_t room() const;    // capacity in instances

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
