// What the length of the next substep goes by.
#pragma once
#include "cuda/mpm/clock.cuh"

namespace knead::gpu {

// The substep under way; what the one before it has left, of which the next one's length follows.
struct Outlook {
    int n;
    Step step;
    Extremes clay;
    double tool_step, duration;  // [s]
    __device__ Step next(const StepLimits& limits) const
    {
        return step_after(step, limits, clay, tool_step, duration);
    }
};

// Once the substep before is over. All is asked for at once, not what belongs to n when n is known,
// and past L1, which may hold what was there before.
__device__ inline Outlook outlook(const Clock& c)
{
    const int n = __ldcg(&c.done);
    uint4 peaks[peak_places];
    UNROLL
    for (int k = 0; k < peak_places; ++k)
        peaks[k] = __ldcg(reinterpret_cast<const uint4*>(c.peaks[k].of));
    double start[3], dt[3];
    int limit[3];
    UNROLL
    for (int k = 0; k < 3; ++k) {
        start[k] = __ldcg(&c.steps[k].start), dt[k] = __ldcg(&c.steps[k].dt);
        limit[k] = __ldcg(reinterpret_cast<const int*>(&c.steps[k].limit));
    }
    const double tool_step = __ldcg(&c.tool_step), duration = __ldcg(&c.duration);
    const Step now{in_ring(n, start), in_ring(n, dt), Limit(in_ring(n, limit))};
    Peak left{};
    UNROLL
    for (const uint4& p : peaks) left = largest(left, n & 1 ? Peak{p.x, p.y} : Peak{p.z, p.w});
    return {n, now, extremes_of(left), tool_step, duration};
}

}  // namespace knead::gpu
