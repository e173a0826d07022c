// HD marks a function that means the same on the CPU and on the GPU; UNROLL a loop that must
// vanish, because it walks an array that must stay in registers.
#pragma once

#ifdef __CUDACC__
#define HD __host__ __device__ inline
#define UNROLL _Pragma("unroll")
#else
#define HD inline
#define UNROLL
#endif

// The number of the lowest set bit; bits must not be 0.
HD int lowest_bit(unsigned bits)
{
#ifdef __CUDA_ARCH__
    return __ffs(int(bits)) - 1;
#else
    return __builtin_ctz(bits);
#endif
}
