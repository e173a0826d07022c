// HD marks a function that means the same on the CPU and on the GPU; UNROLL a loop that must
// vanish, because it walks an array that must stay in registers. VECTOR_EXTENSION says whether the
// compiler knows vector registers as a type.
#pragma once

#ifdef __CUDACC__
#define HD __host__ __device__ inline
#define UNROLL _Pragma("unroll")
#define VECTOR_EXTENSION 0
#else
#define HD inline
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

// 2^x, on a GPU by the unit that is made for it: within 2^-22 of the value.
HD float fast_exp2(float x)
{
#ifdef __CUDA_ARCH__
    float y;
    asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(y) : "f"(x));
    return y;
#else
    return __builtin_exp2f(x);
#endif
}
HD double fast_exp2(double x) { return __builtin_exp2(x); }

// x / y within 2 ulp, y from 2^-126 to 2^126.
HD float fast_divide(float x, float y)
{
#ifdef __CUDA_ARCH__
    return __fdividef(x, y);
#else
    return x / y;
#endif
}
HD double fast_divide(double x, double y) { return x / y; }

// From low to high; low where x is not a number.
HD float fast_clamp(float x, float low, float high)
{
#ifdef __CUDA_ARCH__
    return fminf(fmaxf(x, low), high);
#else
    const float raised = x > low ? x : low;
    return raised < high ? raised : high;
#endif
}
HD double fast_clamp(double x, double low, double high)
{
    const double raised = x > low ? x : low;
    return raised < high ? raised : high;
}
