// Functions with hardware units on the GPU, and their host equivalents.
#pragma once
#include <cmath>

#include "cuda/math/hd.h"
#if !VECTOR_EXTENSION  // CUDA's compiler
#include <nv/target>
#define FAST_ON_GPU
#endif

namespace knead {

// 2^x, within 2^-22 of the value.
HD float fast_exp2(float x)
{
#ifdef FAST_ON_GPU
    NV_IF_TARGET(NV_IS_DEVICE, (float y; asm("ex2.approx.ftz.f32 %0, %1;"
                                             : "=f"(y)
                                             : "f"(x));
                                return y;))
#endif
    return __builtin_exp2f(x);
}
HD double fast_exp2(double x) { return std::exp2(x); }

// x / y within 2 ulp, y from 2^-126 to 2^126.
HD float fast_divide(float x, float y)
{
#ifdef FAST_ON_GPU
    NV_IF_TARGET(NV_IS_DEVICE, (return __fdividef(x, y);))
#endif
    return x / y;
}
HD double fast_divide(double x, double y) { return x / y; }

// x y + z. On the GPU always rounded once: if left to the compiler, rounding could differ between
// kernels, and a splat could reach a pixel in one way of listing but not in the other.
HD float fast_fma(float x, float y, float z)
{
#ifdef FAST_ON_GPU
    NV_IF_TARGET(NV_IS_DEVICE, (return __fmaf_rn(x, y, z);))
#endif
    return x * y + z;
}
HD double fast_fma(double x, double y, double z) { return x * y + z; }

// Clamps x to [low, high]; NaN becomes low.
HD float fast_clamp(float x, float low, float high)
{
#ifdef FAST_ON_GPU
    NV_IF_TARGET(NV_IS_DEVICE, (return fminf(fmaxf(x, low), high);))
#endif
    const float raised = x > low ? x : low;
    return raised < high ? raised : high;
}
HD double fast_clamp(double x, double low, double high)
{
    const double raised = x > low ? x : low;
    return raised < high ? raised : high;
}

}  // namespace knead
