// Atomic additions to the cache of level 2, by where they go and by how many lanes agree.
#pragma once
#include <nv/target>

#include "profiling/micro/bench.cuh"

namespace knead::micro {

// The most float4 additions per second, to neighbouring nodes.
double max_adds(Bench& bench);

// An addition of four numbers to a node: one vector atomic where the card has it.
__device__ inline void add(float4* to, const float4& n)
{
    NV_IF_ELSE_TARGET(NV_PROVIDES_SM_90, (atomicAdd(to, n);),
                      (atomicAdd(&to->x, n.x); atomicAdd(&to->y, n.y); atomicAdd(&to->z, n.z);
                       atomicAdd(&to->w, n.w);))
}

}  // namespace knead::micro
