// The device memory of Gaussians that are kept.
#pragma once
#include "cuda/device/device_array.cuh"
#include "cuda/device/graph.cuh"
#include "cuda/splats/raster.cuh"
#include "host/splats/device_gaussians.h"

namespace knead::gpu {

struct KeptGaussians {
    // Whoever draws: launches wait(), what reads this, and then done(), on one stream.
    void wait(cudaStream_t stream) const
    {
        check(cudaStreamWaitEvent(stream, written, 0), "splats");
    }
    // `before`: the same Gaussians in the state before, from which they have gone on by so much
    // more; null: they are where they are.
    MovedSplats moved(const KeptGaussians* before, float extrapolation) const;
    void done(cudaStream_t stream) const { check(cudaEventRecord(read, stream), "splats"); }

    int device = 0, count = 0;
    DeviceArray<float> rows;
    Event written{cudaEventDisableTiming}, read{cudaEventDisableTiming};
};

}  // namespace knead::gpu
