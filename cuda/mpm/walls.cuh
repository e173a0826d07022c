// Nodes near walls on the device, and what every update of a node does. Few nodes are near a wall,
// so their part is kept apart, and short: what it would load or hold early costs all others
// registers, and instructions that few run have to be fetched.
#pragma once
#include "cuda/mpm/grid.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Momentum and mass that a node got.
template <bool fixed_point>
__device__ Node<float> sum_of(const GridUpdateView& d, int parity, int i)
{
    if constexpr (fixed_point) {
        const longlong2* at =
            reinterpret_cast<const longlong2*>(d.sums[parity] + 4 * std::size_t(i));
        const longlong2 a = at[0], b = at[1];
        const double p = 1 / double(d.momentum_scale), m = 1 / double(d.mass_scale);
        return {{float(p * double(a.x)), float(p * double(a.y)), float(p * double(b.x))},
                float(m * double(b.y))};
    } else {
        const float4 n = d.nodes[parity][i];
        return {{n.x, n.y, n.z}, n.w};
    }
}

// Counts a node that was slowed.
__device__ inline void count_slowed(const GridUpdateView& d, float mass)
{
    Counters& all = d.clock->counters;
    atomicAdd(mass > d.trifle ? &all.clipped : &all.trimmed, 1ull);
}

__device__ inline Node<float>& node_at(const GridUpdateView& d, int parity, int i)
{
    return reinterpret_cast<Node<float>&>(d.nodes[parity][i]);
}

// A node by walls and its images, of the field that begins with node `field`. Tools leave it the
// velocity v; `led` if that is another.
template <bool fixed_point>
__device__ void update_with_images(const GridUpdateView& d, int parity, float dt, Int3 n, Int3 way,
                                   Vec3<float> v, bool led, int field)
{
    const auto node = [&](int k) -> Node<float>& {
        return node_at(d, parity, field + d.lattice.index(image(n, way, k)));
    };
    ROLLED
    for (int k = 0; fixed_point && k < image_count(way); ++k)
        node(k) = sum_of<fixed_point>(d, parity, field + d.lattice.index(image(n, way, k)));
    update_images(
        n, way, d.lattice, d.walls, d.gravity, dt, node,
        [=](Vec3<float>& of) { return of = v, led; }, [&](float mass) { count_slowed(d, mass); });
}

// How a node is updated. One that is not stored holds nothing.
template <bool fixed_point>
__device__ Together together(const GridUpdateView& d, int parity, Int3 n)
{
    const auto mass = [&](Int3 m) {
        return d.lattice.stores(m) ? sum_of<fixed_point>(d, parity, d.lattice.index(m)).m : 0;
    };
    Together how = knead::together(n, d.walls, mass);
    const Int3 far = n + how.way;
    if (!d.lattice.stores({far.x, n.y, n.z})) how.way.x = 0;
    if (!d.lattice.stores({n.x, far.y, n.z})) how.way.y = 0;
    if (!d.lattice.stores({n.x, n.y, far.z})) how.way.z = 0;
    return how;
}

// Node n, which holds mass and has a wall near; tools leave it the velocity v, `led` if that is
// another. What only walls need is loaded here: few nodes come this way, and what is held while
// tools act costs all nodes registers. All of them take the same way, for its instructions have to
// be fetched.
template <bool fixed_point>
__device__ void update_at_wall(const GridUpdateView& d, int parity, float dt, Int3 n, Vec3<float> v,
                               bool led)
{
    const Together how = together<fixed_point>(d, parity, n);
    if (!how.elsewhere) update_with_images<fixed_point>(d, parity, dt, n, how.way, v, led, 0);
}

}  // namespace knead::gpu
