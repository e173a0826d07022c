// All device memory of one cloud's rasteriser, and the view of it for kernels.
#pragma once
#include "cuda/device/device_array.cuh"
#include "cuda/splats/raster.cuh"
#include "host/splats/raster.h"

namespace knead::gpu {

// Splats at rest, with spare capacity.
class SplatTable {
  public:
    // Uploads a cloud. Throws std::invalid_argument as check_frame() does for an inconsistent
    // cloud.
    void fill(const SplatCloud& cloud, std::size_t room, cudaStream_t stream);
    const SplatView& view() const { return seen; }
    std::size_t bytes() const;

  private:
    SplatView seen{};
    DeviceArray<float4> place, turn, scale;
    DeviceArray<uint4> sh;
};

// Per tile, as in RasterView::seen_parts; `hidden`: as in RasterFrame, or empty.
std::vector<unsigned char> seen_parts(const RasterView& d, const std::vector<char>& hidden);

class RasterStore {
  public:
    RasterStore(std::size_t splats, int degree);

    // Reallocate the buffers for instances, or for pictures of another size; pointers change.
    void reserve(std::size_t instances);
    void resize(const SplatFrame& frame);
    std::size_t bytes() const;

    RasterView view{};
    RasterScratch scratch{};
    DeviceArray<RasterFrame> frame;
    DeviceArray<RasterCounts> counts;
    DeviceArray<unsigned char> seen_parts_of;  // per tile

  private:
    DeviceArray<std::uint32_t> depth_keys, sorted_keys;
    DeviceArray<TileBoxes> boxes;
    DeviceArray<SplatShape> shapes;
    DeviceArray<SplatRest> rests;
    DeviceArray<int> numbers, order, records[2];
    DeviceArray<unsigned long long> candidate_starts, chunk_states;
    DeviceArray<std::uint16_t> keys[2];
    DeviceArray<unsigned> digit_counts, digit_starts;
    DeviceArray<uint2> ranges;
    DeviceArray<TileSample> samples;
    DeviceArray<TileOptions> rules;
    DeviceArray<int> deferred;
    DeviceArray<unsigned char> scratch_memory;
};

}  // namespace knead::gpu
