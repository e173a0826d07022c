// Device memory of a snapshot of Gaussians.
#pragma once
#include "cuda/device/device_array.cuh"
#include "cuda/device/graph.cuh"
#include "cuda/splats/raster.cuh"
#include "host/splats/device_gaussians.h"

namespace knead::gpu {

struct KeptGaussians {
    // A renderer calls wait(), launches its reads, and calls done(), all on one stream.
    void wait(cudaStream_t stream) const
    {
        check(cudaStreamWaitEvent(stream, written, 0), "splats");
    }
    // `before`: the same Gaussians in the previous state, from which positions are extrapolated by
    // `extrapolation` of the last step; null: not extrapolated.
    MovedSplats moved(const KeptGaussians* before, float extrapolation) const;
    void done(cudaStream_t stream) const { check(cudaEventRecord(read, stream), "splats"); }

    int device = 0, count = 0;
    DeviceArray<float> rows;
    Event written{cudaEventDisableTiming}, read{cudaEventDisableTiming};
};

}  // namespace knead::gpu
