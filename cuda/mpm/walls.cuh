// Device code for nodes near walls, and functions shared by all node updates. Few nodes are near a
// wall, so their path is separate and short: values it loaded or held early would cost all other
// nodes registers, and rarely executed instructions still have to be fetched.
#pragma once
#include "cuda/mpm/grid.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Summed momentum and mass of a node.
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

// Counts a node whose speed was limited.
__device__ inline void count_slowed(const GridUpdateView& d, float mass)
{
    Counters& all = d.clock->counters;
    atomicAdd(mass > d.negligible_mass ? &all[Count::clipped] : &all[Count::clipped_negligible],
              1ull);
}

__device__ inline Node<float>& node_at(const GridUpdateView& d, int parity, int i)
{
    return reinterpret_cast<Node<float>&>(d.nodes[parity][i]);
}

// The mass of all clay at a node; an update does not change it.
template <bool fixed_point>
__device__ auto masses(const GridUpdateView& d, int parity)
{
    return [&d, parity](Int3 n) -> float {
        if (!d.lattice.stores(n)) return 0;
        return sum_of<fixed_point>(d, parity, d.lattice.index(n)).m;
    };
}

// Mirror nodes of a warp, by lane. Kept in shared memory: in global memory each of the many small
// accesses would wait for L2.
struct ImageSpace {
    float4 mirrors[7][32];
};

// A node and its mirror nodes: the node itself in registers, the mirror nodes in shared memory. The
// index of the k-th mirror node differs from the node's by the sum of the steps whose bits are set
// in k.
struct MirrorNodes {
    ImageSpace& space;
    const int lane = int(threadIdx.x & 31);
    Node<float> own{};
    Int3 mirror_offset{};  // from the node to its mirror nodes
    int i = 0, first = 0, second = 0, third = 0;

    __device__ explicit MirrorNodes(ImageSpace& space) : space(space) {}
    __device__ int count() const { return mirror_count(mirror_offset); }
    __device__ int index(int k) const
    {
        return i + (k & 1 ? first : 0) + (k & 2 ? second : 0) + (k & 4 ? third : 0);
    }
    __device__ Node<float> get(int k) const
    {
        if (k == 0) return own;
        const float4 n = space.mirrors[k - 1][lane];
        return {{n.x, n.y, n.z}, n.w};
    }
    __device__ void put(int k, const Node<float>& n)
    {
        if (k == 0)
            own = n;
        else
            space.mirrors[k - 1][lane] = {n.p.x, n.p.y, n.p.z, n.m};
    }
    // Sets the mirror nodes of node n (index `index_of_n`) at offset `towards`, only along axes
    // where they are stored.
    __device__ void find(const Lattice<float>& lattice, Int3 n, int index_of_n, Int3 towards)
    {
        const Int3 to = n + towards, at = to - lattice.low, stored = lattice.stored;
        const auto step = [](int wanted, int place, int count) {
            return unsigned(place) < unsigned(count) ? wanted : 0;
        };
        mirror_offset = {step(towards.x, at.x, stored.x), step(towards.y, at.y, stored.y),
                         step(towards.z, at.z, stored.z)};
        const int x = lattice.along_x(to.x) - lattice.along_x(n.x),
                  y = lattice.along_y(to.y) - lattice.along_y(n.y),
                  z = mirror_offset.z * lattice.along_z;
        i = index_of_n,
        first = mirror_offset.x   ? x
                : mirror_offset.y ? y
                                  : z,
        second = mirror_offset.x && mirror_offset.y ? y : z;
        third = z;
    }
};

// Loads the sums of some mirror nodes; all loads are issued before the first use.
template <int from, int end>
__device__ void load_some(const GridUpdateView& d, int parity, int field, MirrorNodes& mirrors)
{
    float4 sums[end - from];
    UNROLL
    for (int k = from; k < end; ++k) sums[k - from] = d.nodes[parity][field + mirrors.index(k)];
    UNROLL
    for (int k = from; k < end; ++k) mirrors.space.mirrors[k - 1][mirrors.lane] = sums[k - from];
}

// Loads the sums of all mirror nodes in the velocity field whose first node is `field`.
template <bool fixed_point>
__device__ void load_mirror_sums(const GridUpdateView& d, int parity, int field,
                                 MirrorNodes& mirrors)
{
    const int all = mirrors.count();
    if constexpr (fixed_point) {
        ROLLED
        for (int k = 1; k < all; ++k)
            mirrors.put(k, sum_of<fixed_point>(d, parity, field + mirrors.index(k)));
    } else {
        if (all > 1) load_some<1, 2>(d, parity, field, mirrors);
        if (all > 2) load_some<2, 4>(d, parity, field, mirrors);
        if (all > 4) load_some<4, 8>(d, parity, field, mirrors);
    }
}

// Finds and loads the mirror nodes of node n (index i). Returns true if n is updated with another
// node.
template <bool fixed_point>
__device__ bool load_mirrors(const GridUpdateView& d, int parity, Int3 n, int i,
                             MirrorNodes& mirrors)
{
    const MirrorSet how = mirror_set(n, d.walls, [&](Int3 mirror_offset) {
        mirrors.find(d.lattice, n, i, mirror_offset);
        load_mirror_sums<fixed_point>(d, parity, 0, mirrors);
        const bool whole = mirrors.mirror_offset == mirror_offset && !(mirror_offset == Int3{});
        return whole ? mirrors.get(mirrors.count() - 1).m : 0;
    });
    if (how.mirror_offset == Int3{}) mirrors.mirror_offset = {};
    return how.is_mirror;
}

// Sliding records, loaded past L1: its line may be two substeps old.
struct SlidingOnDevice {
    Sliding<float>* all;
    float dx;
    int substep;
    __device__ Sliding<float> get(int place) const
    {
        const int4 s = __ldcg(reinterpret_cast<const int4*>(all + place));
        return {__int_as_float(s.x), __int_as_float(s.y), s.z, __int_as_float(s.w)};
    }
    __device__ void put(int place, const Sliding<float>& s) const { all[place] = s; }
};
__device__ inline SlidingOnDevice sliding_in(const GridUpdateView& d, int field, int substep)
{
    return {d.sliding + field * sliding_places(d.walls), d.lattice.dx, substep};
}

// Updates node n and its mirror nodes in velocity field `field`. In: mirrors.own has the velocity
// after tools; `by_tool` if tools changed it. Writes the mirror nodes; the caller writes the node
// itself.
template <bool fixed_point>
__device__ void update_with_images(const GridUpdateView& d, int substep, float dt, Int3 n,
                                   int field, MirrorNodes& mirrors, bool by_tool)
{
    update_after_tools(
        n, mirrors.mirror_offset, d.lattice, d.walls, d.gravity, dt, mirrors, mirrors.own.p,
        by_tool, [&](float mass) { count_slowed(d, mass); }, sliding_in(d, field, substep),
        masses<fixed_point>(d, substep & 1));
    const int first = field * d.lattice.node_count();
    ROLLED
    for (int k = 1; k < mirrors.count(); ++k)
        node_at(d, substep & 1, first + mirrors.index(k)) = mirrors.get(k);
}

}  // namespace knead::gpu
