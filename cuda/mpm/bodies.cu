// Contact between bodies, on the momenta of a substep: after all particles have scattered, before
// the grid update.  (25a)
#include "cuda/device/launch.cuh"
#include "cuda/mpm/body_contact.h"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

// A field's sums in fixed point.
template <bool fixed_point>
struct Fields {
    const BodyView& d;
    int parity, i;  // of the thread's node

    __device__ int at(int field, int node) const { return field * d.lattice.node_count() + node; }
    __device__ long long* sums(int place) const { return d.sums[parity] + 4 * std::size_t(place); }
    __device__ float mass(int field, int node) const
    {
        if constexpr (fixed_point)
            return d.mass_unit * __ll2float_rn(sums(at(field, node))[3]);
        else
            return d.nodes[parity][at(field, node)].w;
    }
    __device__ Vec3<float> momentum(int field) const
    {
        if constexpr (fixed_point) {
            const long long* s = sums(at(field, i));
            const float p = d.momentum_unit;
            return {p * __ll2float_rn(s[0]), p * __ll2float_rn(s[1]), p * __ll2float_rn(s[2])};
        } else {
            const float4 n = d.nodes[parity][at(field, i)];
            return {n.x, n.y, n.z};
        }
    }
    // Impulses of a pair are opposite numbers: in fixed point, too, they cancel exactly.
    __device__ void add(int field, Vec3<float> impulse) const
    {
        if constexpr (fixed_point) {
            long long* s = sums(at(field, i));
            const float scale = d.momentum_scale;
            s[0] += __float2ll_rn(scale * impulse.x);
            s[1] += __float2ll_rn(scale * impulse.y);
            s[2] += __float2ll_rn(scale * impulse.z);
        } else {
            float4& n = d.nodes[parity][at(field, i)];
            n.x += impulse.x, n.y += impulse.y, n.z += impulse.z;
        }
    }
    __device__ void sum_masses() const
    {
        if constexpr (fixed_point) {
            long long all = 0;
            for (int f = 1; f < d.bodies.count(); ++f) all += sums(at(f, i))[3];
            sums(i)[3] = all;
        } else {
            float all = 0;
            for (int f = 1; f < d.bodies.count(); ++f) all += mass(f, i);
            d.nodes[parity][i] = {0, 0, 0, all};
        }
    }
};

// One node per thread. Threads change the momenta of their own node; masses, which they read around
// it, stay as they are.
template <bool fixed_point, int labels>
__global__ void __launch_bounds__(block_nodes, 8) body_kernel(const __grid_constant__ BodyView d)
{
    const Clock& clock = *d.clock;
    const int n = clock.done, listed = clock.active[n % 3];
    const float dt = float(clock.step(n).dt);
    if (!(dt > 0)) return;
    for (int k = int(blockIdx.x); k < listed; k += int(gridDim.x)) {
        const int i = block_of(d.list[n % 3][k]) * block_nodes + int(threadIdx.x);
        const Int3 at = d.lattice.node_at(i);
        const Fields<fixed_point> fields{d, n & 1, i};
        fields.sum_masses();
        separate_fields<labels>(
            d.bodies, d.lattice.dx, dt,
            [&](int f, Int3 step) {
                const Int3 to = at + step;
                return d.lattice.stores(to) ? fields.mass(f, d.lattice.index(to)) : 0.0f;
            },
            [&](int f) { return fields.momentum(f); },
            [&](int f, Vec3<float> impulse) { fields.add(f, impulse); });
    }
}

}  // namespace

void separate(const Views& views, const Features& features, int multiprocessors,
              cudaStream_t stream)
{
    if (!features.bodies) return;
    constexpr int labelled = labels_of_clay;
    const auto kernel = features.blades        ? features.fixed_point ? body_kernel<true, labelled>
                                                                      : body_kernel<false, labelled>
                               : features.fixed_point ? body_kernel<true, 1>
                                               : body_kernel<false, 1>;
    const int blocks = min(views.lattice.block_count(), 16 * multiprocessors);
    launch("separate", kernel, blocks, block_nodes, stream, body_view(views));
}

}  // namespace knead::gpu
