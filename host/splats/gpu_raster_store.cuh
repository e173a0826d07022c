// All device memory of one cloud's rasteriser, and the view of it that kernels take.
#pragma once
#include "cuda/device/device_array.cuh"
#include "cuda/splats/raster.cuh"
#include "host/splats/raster.h"

namespace knead::gpu {

class RasterStore {
  public:
    // Throws std::invalid_argument as check_frame() does of the cloud.
    explicit RasterStore(const SplatCloud& cloud);

    // Other buffers for the instances, or for pictures of another size; where they are changes.
    void reserve(std::size_t instances);
    void resize(const SplatFrame& frame);
    std::size_t bytes() const;

    RasterView view{};
    RasterScratch scratch{};
    DeviceArray<RasterFrame> frame;
    DeviceArray<RasterCounts> counts;

  private:
    void upload_splats(const SplatCloud& cloud);

    DeviceArray<float4> place, turn, scale;
    DeviceArray<uint4> sh;
    DeviceArray<std::uint32_t> depth_keys, sorted_keys;
    DeviceArray<TileBoxes> boxes;
    DeviceArray<SplatShape> shapes;
    DeviceArray<SplatRest> rests;
    DeviceArray<int> numbers, order, records[2];
    DeviceArray<unsigned long long> candidate_starts, chunk_states;
    DeviceArray<std::uint16_t> tiles[2];
    DeviceArray<unsigned> digit_counts, digit_starts;
    DeviceArray<uint2> ranges;
    DeviceArray<unsigned char> scratch_memory;
};

}  // namespace knead::gpu
