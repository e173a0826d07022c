// Spreading of depths over a picture on the device.
#pragma once
#include <cuda_runtime.h>

#include "cuda/splats/spread.h"

namespace knead::gpu {

// Of one eye. `colour` has four halves a pixel, the last what is covered; `depth` is changed; as
// much as it is `spare`, whose values do not matter.
struct DepthView {
    int width, height;
    const uint2* colour;
    float *depth, *spare;
    DepthSum* sum;
};
void spread(const DepthView& view, int processors, cudaStream_t stream);

}  // namespace knead::gpu
