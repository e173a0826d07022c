// One particle, then one bin per thread; bits that are set already are not set again.
#include "cuda/device/launch.cuh"
#include "cuda/mpm/body_graph.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;
using Mask = unsigned long long;

__device__ void set_bits(Mask* at, Mask bits)
{
    if ((__ldcg(at) & bits) != bits) atomicOr(at, bits);
}

__global__ void __launch_bounds__(threads)
    bin_kernel(const ConstParticleView particles, const Lattice<float> lattice, const int* body,
               Mask* masks)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= particles.count) return;
    const int own = body[__float_as_int(particles.row(1, i).w)];
    if (own < 0) return;
    const Int3 c = lattice.cell_of(particles.position(i));
    const int at =
        bin_index({c.x / bin_edge, c.y / bin_edge, c.z / bin_edge}, bins_of(lattice.size));
    set_bits(masks + at, Mask(1) << own);
}

__global__ void __launch_bounds__(threads)
    graph_kernel(const Int3 bins, const Mask* masks, Mask* graph)
{
    const int at = int(blockIdx.x * threads + threadIdx.x);
    if (at >= bins.x * bins.y * bins.z || masks[at] == 0) return;
    const Int3 bin = {at % bins.x, at / bins.x % bins.y, at / bins.x / bins.y};
    const BodiesAround around =
        bodies_around(bin, bins, [&](Int3 n) { return std::uint64_t(masks[bin_index(n, bins)]); });
    for (Mask own = masks[at]; own; own &= own - 1) {
        const int b = __ffsll((long long)own) - 1;
        const Mask others = ~(Mask(1) << b);
        set_bits(graph + b, around.touching & others);
        set_bits(graph + most_bodies + b, around.near & others);
    }
}

int blocks_of(int count) { return (count + threads - 1) / threads; }

}  // namespace

void body_graph(const ConstParticleView& particles, const Lattice<float>& lattice, const int* body,
                unsigned long long* masks, unsigned long long* graph, cudaStream_t stream)
{
    const Int3 bins = bins_of(lattice.size);
    launch("bodies: bin", bin_kernel, blocks_of(particles.count), threads, stream, particles,
           lattice, body, masks);
    launch("bodies: graph", graph_kernel, blocks_of(bins.x * bins.y * bins.z), threads, stream,
           bins, masks, graph);
}

}  // namespace knead::gpu
