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

// Node i at x, which tools of the mask may touch: apply_tools() by all lanes of a warp, of tools
// without blades. If `early`, the first tool is looked for before the end of the substep before is
// waited for, at the nodes that held clay then; at others after. (Where another warp clears them
// meanwhile, they are looked at after, too.)
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
        in = d.nodes[n & 1 ^ 1][i].w > 0;
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
            if (early) wait_for_upstream(), take();
            if (hit.phi < 0 && sum.m > 0) v = apply_contact(v, hit.n, hit.v, mode, friction);
            if (early) early = false, missed = sum.m > 0 && !in;
        }
        in = missed, missed = false;
    } while (__any_sync(0xffffffffu, in));
    return {{v, sum.m}, sum.m > 0 && differ(v, apply_gravity(sum, d.gravity, dt))};
}

}  // namespace knead::gpu
