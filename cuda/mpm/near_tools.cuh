// What tools do to a warp's nodes, by all its lanes.
#pragma once
#include "cuda/contact/contact.cuh"
#include "cuda/mpm/pose.cuh"
#include "cuda/mpm/walls.cuh"

namespace knead::gpu {

// So many nodes a warp has near tools: its lanes share their closest points.
constexpr int shared_nodes = 16;
using SharedSpace = ContactSpace<shared_nodes>;

// What tools leave of a node, or gravity alone.
struct AfterTools {
    Node<float> node;
    bool led;  // by a tool: its velocity is not what it would be without
};

// Whether clay was at the lane's node i in the substep before, or beside it, as far as the block
// goes: it may have come to the node. A warp has the nodes of one place along z.
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

// Node i at x, which tools of the mask may touch: apply_tools() by all lanes of a warp, of tools
// without blades. If `early`, the first tool is looked for before the end of the substep before is
// waited for, at the nodes that clay may come to by what it held then; at others after. (Where
// another warp clears them meanwhile, they are looked at after, too.)
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
        saw_posed();
        in = held_clay(d.nodes[n & 1 ^ 1], i);
    } else {
        take();
        in = sum.m > 0;
    }
    do {
        const int near = contact.look(mask, in, x, [&c](int k) { return c.primitives[k].tool; });
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
            if (early) wait_upstream_and_trigger(), take();
            if (hit.phi < 0 && sum.m > 0) v = apply_contact(v, hit.n, hit.v, mode, friction);
            if (early) early = false, missed = sum.m > 0 && !in;
        }
        in = missed, missed = false;
    } while (__any_sync(0xffffffffu, in));
    return {{v, sum.m}, sum.m > 0 && differ(v, apply_gravity(sum, d.gravity, dt))};
}

}  // namespace knead::gpu
