// Rounding of what the history keeps of clay: each number becomes the nearest multiple of a step.
// Steps and errors: docs/method/history.md.
#pragma once
#include <cmath>

#include "cuda/math/vec.h"

namespace knead {

struct QuantStep {
    float size, per;  // 1 / size
};
HD QuantStep quant_step(float size) { return {size, 1 / size}; }

// Numbers of this many steps or more are not rounded. Below, 3 roundings of floats err by less than
// half a step, so that number_of() and multiple_of() are inverse to each other for any step.
constexpr float most_multiple = 0x1p21f;

constexpr float k_step = 0x1p-10f;  // plastic strain [1]
constexpr float F_step = 0x1p-12f;  // deformation gradient of a splat [1]
constexpr float x_steps_a_cell = 1024;
// Strain of a material without yield stress. Also the default. [1]
constexpr float e_step = 0x1p-12f;

// The largest power of two that is at most 0.005 sqrt(2/3) Y/mu: half of it, times mu, is at most
// 0.2 % of the yield stress. `yield`: 0 without one.
inline float e_step_of(double mu, double yield)
{
    if (!(mu > 0 && yield > 0)) return e_step;
    const double most = 0.005 * 0.816496580927726 * yield / mu;
    return float(std::exp2(std::fmax(-18.0, std::fmin(std::floor(std::log2(most)), -6.0))));
}

// To even where two are equally near. Precondition: |v| < 2^22.
HD float nearest_whole(float v)
{
    constexpr float shift = 0x1.8p23f;  // floats of this size are whole numbers
    return (v + shift) - shift;
}

HD float number_of(int multiple, QuantStep step) { return float(multiple) * step.size; }
// The nearest multiple; 0 for numbers that are not rounded.
HD int multiple_of(float v, QuantStep step)
{
    const float r = v * step.per;
    return int(nearest_whole(std::fabs(r) < most_multiple ? r : 0));
}
// NaN and numbers of most_multiple steps or more stay as they are.
HD float quantised(float v, QuantStep step)
{
    const float r = v * step.per;
    return std::fabs(r) < most_multiple ? nearest_whole(r) * step.size : v;
}
// Between `low` and `high` steps: a position between walls. NaN stays.
HD float quantised_between(float v, QuantStep step, float low, float high)
{
    const float r = v * step.per, at = min(max(r, low - 1), high + 1);
    return r == r ? min(max(nearest_whole(at), low), high) * step.size : v;
}

// Whether b = e + I has positive eigenvalues only, by its leading minors.
HD bool positive_definite(const Sym3<float>& e)
{
    const float xx = 1 + e.xx, yy = 1 + e.yy, zz = 1 + e.zz;
    const float minor = xx * yy - e.xy * e.xy;
    const float all = xx * (yy * zz - e.yz * e.yz) - e.xy * (e.xy * zz - e.yz * e.xz) +
                      e.xz * (e.xy * e.yz - yy * e.xz);
    return (int(xx > 0) & int(minor > 0) & int(all > 0)) != 0;  // without branches
}
// Where rounding would make an eigenvalue of b negative, because it is below 1.5 steps, the
// diagonal has two steps more.
HD Sym3<float> quantised(const Sym3<float>& e, QuantStep step)
{
    const Sym3<float> nearest{quantised(e.xx, step), quantised(e.yy, step), quantised(e.zz, step),
                              quantised(e.xy, step), quantised(e.xz, step), quantised(e.yz, step)};
    const float more = positive_definite(e) && !positive_definite(nearest) ? 2 * step.size : 0;
    return {nearest.xx + more, nearest.yy + more, nearest.zz + more,
            nearest.xy,        nearest.xz,        nearest.yz};
}

}  // namespace knead
