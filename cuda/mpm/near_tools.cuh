// Contact of a warp's nodes with tools, warp-collective.
#pragma once
#include "cuda/contact/contact.cuh"
#include "cuda/mpm/substep_sync.cuh"
#include "cuda/mpm/walls.cuh"

namespace knead::gpu {

// Nodes per warp near tools: its lanes share their closest points.
constexpr int shared_nodes = 16;
using SharedSpace = ContactSpace<shared_nodes>;

// A node after gravity and tools.
struct AfterTools {
    Node<float> node;
    bool by_tool;  // a tool changed its velocity
};

// Whether the lane's node i or a neighbour in its block held clay in the previous substep, so that
// clay may reach it. A warp has the nodes of one index along z.
__device__ inline bool held_clay(const float4* before, int i)
{
    const int along_z = i % block_nodes / shared_nodes;
    const int less = along_z > 0 ? i - shared_nodes : i,
              more = along_z < block_edge - 1 ? i + shared_nodes : i;
    const bool own = before[i].w > 0, beside = before[less].w > 0 || before[more].w > 0;
    constexpr unsigned not_last = 0x7777;  // along x
    const unsigned held = __ballot_sync(0xffffffffu, own) & 0xffff;
    const unsigned around = held | (held & not_last) << 1 | (held >> 1 & not_last) |
                            held << block_edge | held >> block_edge;
    return beside || around >> i % shared_nodes & 1;
}

// apply_tools() for node i at x with contact candidates `mask`, without blades. Warp-collective. If
// `early`, contact with the first tool is evaluated before the wait for the end of the previous
// substep, at the nodes that clay may reach from its positions in that substep. At all other nodes,
// and at nodes that another warp clears meanwhile, it is evaluated after the wait.
template <bool fixed_point>
__device__ AfterTools near_tools(const GridUpdateView& d, SharedSpace& space, int n, float dt,
                                 int i, Vec3<float> x, const Mask& mask, bool early)
{
    const Colliders<float> c = d.contact.colliders(n);
    WarpContact<shared_nodes> contact(space, c);
    Node<float> sum{};
    Vec3<float> v{};
    const auto take = [&] {
        sum = sum_of<fixed_point>(d, n & 1, i);
        if (sum.m > 0) v = apply_gravity(sum, d.gravity, dt);
    };
    bool in, missed = false;
    if (early) {
        acquire_posed();
        in = held_clay(d.nodes[n & 1 ^ 1], i);
    } else {
        take();
        in = sum.m > 0;
    }
    do {
        const int near =
            contact.find_near(mask, in, x, [&c](int k) { return c.primitives[k].tool; });
        for (int from = 0, to; from < near || early; from = to) {
            Contact<float> hit{};
            ContactMode mode{};
            float friction = 0;
            to = near;
            if (from < near) {
                to = contact.run_end(from, near);
                const Tool<float>& tool = c.tools[contact.label(from)];
                mode = tool.mode, friction = tool.friction;
                hit = contact.deepest(from, to, in, x);
            }
            if (early) wait_for_previous_stage(), take();
            if (hit.phi < 0 && sum.m > 0) v = apply_contact(v, hit.n, hit.v, mode, friction);
            if (early) early = false, missed = sum.m > 0 && !in;
        }
        in = missed, missed = false;
    } while (__any_sync(0xffffffffu, in));
    return {{v, sum.m}, sum.m > 0 && differ(v, apply_gravity(sum, d.gravity, dt))};
}

}  // namespace knead::gpu
