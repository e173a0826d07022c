// HD marks a function that means the same on the CPU and on the GPU; UNROLL a loop that must
// vanish, because it walks an array that must stay in registers; ROLLED one that must stay, because
// few come there and instructions have to be fetched. VECTOR_EXTENSION says whether the
// compiler knows vector registers as a type.
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

// Shared memory of a multiprocessor [KiB], where device code is compiled: the cards for the desk
// (sm_89, sm_120) have less than half of an sm_90's.
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ != 900
#define SHARED_KIB 100
#else
#define SHARED_KIB 228
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
