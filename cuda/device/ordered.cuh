// Maps floats to integers of the same order, for atomic minima and maxima.
#pragma once
#include <cuda_runtime.h>

namespace knead::gpu {

// Negative ones have all bits but the sign inverted.
__device__ inline int ordered(float x)
{
    const int bits = __float_as_int(x);
    return bits < 0 ? bits ^ 0x7fffffff : bits;
}
__host__ __device__ inline int from_ordered(int key) { return key < 0 ? key ^ 0x7fffffff : key; }
__device__ inline float unordered(int key) { return __int_as_float(from_ordered(key)); }

}  // namespace knead::gpu
