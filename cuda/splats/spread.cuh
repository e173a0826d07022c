// Depth filling of a frame on the device.
#pragma once
#include <cuda_runtime.h>

#include "cuda/splats/spread.h"

namespace knead::gpu {

// Of one eye. `colour` has four halves per pixel, the last is coverage; `depth` is modified;
// `spare` is scratch of the same size.
struct DepthView {
    int width, height;
    const uint2* colour;
    float *depth, *spare;
    DepthSum* sum;
};
void spread(const DepthView& view, int processors, cudaStream_t stream);

}  // namespace knead::gpu
