// HD marks a function with the same meaning on CPU and GPU. UNROLL marks a loop that must be
// unrolled, because it indexes an array that must stay in registers. ROLLED marks a loop that must
// not be unrolled, because it is rarely executed and its instructions have to be fetched.
// VECTOR_EXTENSION: the compiler supports vector types.
#pragma once

#ifdef __CUDACC__
#define HD __host__ __device__ inline
#define UNROLL _Pragma("unroll")
#define ROLLED _Pragma("unroll 1")
#define VECTOR_EXTENSION 0
#else
#define HD inline
#define ROLLED
#define VECTOR_EXTENSION 1
#ifdef __clang__
#define UNROLL _Pragma("unroll")
#else
#define UNROLL _Pragma("GCC unroll 32")
#endif
#endif

// Shared memory of a multiprocessor [KiB] in device code: desktop GPUs (sm_89, sm_120) have less
// than half of an sm_90's.
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ != 900
#define SHARED_KIB 100
#else
#define SHARED_KIB 228
#endif

// Index of the lowest set bit; precondition: bits != 0.
HD int lowest_bit(unsigned bits)
{
#ifdef __CUDA_ARCH__
    return __ffs(int(bits)) - 1;
#else
    return __builtin_ctz(bits);
#endif
}
