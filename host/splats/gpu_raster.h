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
    std::size_t instances = 0;  // entries of the tiles' lists: by parts in the first frame
    std::size_t dropped = 0;    // of these, the farthest, for which there was no room
    std::size_t put_off = 0;    // parts of tiles whose lists were shared out among more blocks
};

// Draws one cloud. `instances` is for how many pairs of tile and splat of both eyes there is room;
// 0: for what pictures() meets, with a half more. Of the splats, those behind the first `movable`
// are kept in an order of their own, near ones beside each other. Throws std::invalid_argument for
// a cloud whose arrays do not belong together, std::runtime_error where there is no device or not
// enough memory.
class GpuRaster {
  public:
    // `splats`: room for so many, in clouds to come.
    explicit GpuRaster(const SplatCloud& cloud, std::size_t instances = 0, int device = -1,
                       std::size_t splats = 0);
    ~GpuRaster();

    // Another cloud, in two halves: brought to the device by any one thread, while others are drawn
    // (all is allocated at the first time); then shown from the next frame on, without a wait.
    // Throws std::invalid_argument as the constructor, and for a cloud that does not fit.
    bool serves(const SplatCloud& cloud) const;
    void prepare(const SplatCloud& cloud);
    void show_prepared();
    // Room for so many instances at least, before the first frame.
    void reserve(std::size_t instances);

    // Draws, waits, downloads. Both eyes must have pictures of one size, of at most 65536 tiles of
    // 16 x 16 pixels together. Throws as check_frame(), too.
    std::vector<Picture> pictures(const SplatFrame& frame);

    // Queues a frame on a stream (a cudaStream_t) and waits for nothing: of `frame` the eyes, the
    // rule, the background and what is hidden count. Splats that move, and where the pictures go,
    // one target for each eye, are on the device already. `moved` may be null. Where `instances`
    // was 0 and there was not room enough, a later frame has it.
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
