// The rasteriser on the device: the same pictures as cpu_raster() within the rounding of 16 bits.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "host/solver/solver.h"
#include "host/splats/raster.h"

namespace knead {
namespace gpu {
struct MovedSplats;   // cuda/splats/raster.cuh
struct RasterTarget;  // cuda/splats/raster.cuh
}  // namespace gpu

// How much there was of everything in the last frame.
struct RasterStats {
    std::size_t visible = 0;    // splats that an eye sees
    std::size_t instances = 0;  // pairs of tile and splat
    std::size_t dropped = 0;    // of these, the farthest, for which there was no room
};

// Draws one cloud. `instances` is for how many pairs of tile and splat of both eyes there is room;
// 0: for what pictures() meets, with a half more. Of the splats, those behind the first `movable`
// are kept in an order of their own, near ones beside each other. Throws std::invalid_argument for
// a cloud whose arrays do not belong together, std::runtime_error where there is no device or not
// enough memory.
class GpuRaster {
  public:
    explicit GpuRaster(const SplatCloud& cloud, std::size_t instances = 0, int device = -1);
    ~GpuRaster();

    // Draws, waits, downloads. Both eyes must have pictures of one size, of at most 65536 tiles of
    // 16 x 16 pixels together. Throws as check_frame(), too.
    std::vector<Picture> pictures(const SplatFrame& frame);

    // Queues a frame on a stream (a cudaStream_t) and waits for nothing: of `frame` the eyes, the
    // rule and the background count. Splats that move, and where the pictures go, one target for
    // each eye, are on the device already. `moved` may be null. Where `instances` was 0 and there
    // was not room enough, a later frame has it.
    void launch(const SplatFrame& frame, const gpu::MovedSplats* moved,
                const gpu::RasterTarget* targets, void* stream);
    RasterStats stats() const;  // waits

    // Seconds of each of `count` replays of the last frame, and of each stage within one.
    std::vector<double> replays(int count);
    std::vector<StageTime> stage_times();
    int device() const;
    std::size_t memory() const;  // bytes held on the device
    std::size_t room() const;    // instances

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
