#include "profiling/micro/rebin.cuh"

namespace knead::micro {
namespace {

__device__ int block_of(const BinView& d, const gpu::ParticleView& from, int i)
{
    return d.lattice.block_of(base_node(from.position(i), d.lattice.dx));
}

__device__ void copy(const gpu::ParticleView& to, int i, const gpu::ParticleView& from, int j)
{
    UNROLL
    for (int r = 0; r < gpu::particle_rows; ++r) to.row(r, i) = from.row(r, j);
    to.ids[i] = from.ids[j];
}

// A thread block a bin. Slots of those that stay but lie behind the new end go to gaps before it.
__global__ void __launch_bounds__(threads) leave_kernel(const __grid_constant__ BinView d)
{
    __shared__ int gone, gaps, strays, first_left;
    __shared__ short gone_from[bin_room], gap[bin_room], stray[bin_room];
    __shared__ bool left[bin_room];
    const int bin = int(blockIdx.x), first = bin * bin_room, count = d.counts[bin];
    if (threadIdx.x == 0) gone = gaps = strays = 0;
    __syncthreads();
    for (int slot = int(threadIdx.x); slot < count; slot += threads) {
        left[slot] = d.bin_of[block_of(d, d.particles, first + slot)] != bin;
        if (left[slot]) gone_from[atomicAdd(&gone, 1)] = short(slot);
    }
    __syncthreads();
    if (gone == 0) return;
    const int stay = count - gone;
    for (int slot = int(threadIdx.x); slot < count; slot += threads) {
        if (left[slot] && slot < stay) gap[atomicAdd(&gaps, 1)] = short(slot);
        if (!left[slot] && slot >= stay) stray[atomicAdd(&strays, 1)] = short(slot);
    }
    if (threadIdx.x == 0) first_left = atomicAdd(d.left, gone), d.counts[bin] = stay;
    __syncthreads();
#pragma unroll 1  // or the copies' addresses do not fit into registers
    for (int k = int(threadIdx.x); k < gone; k += threads)
        copy(d.leaving, first_left + k, d.particles, first + gone_from[k]);
    __syncthreads();
#pragma unroll 1
    for (int k = int(threadIdx.x); k < gaps; k += threads)
        copy(d.particles, first + gap[k], d.particles, first + stray[k]);
}

__global__ void __launch_bounds__(threads) arrive_kernel(const __grid_constant__ BinView d)
{
    const int left = *d.left;
    for (int i = int(blockIdx.x * threads + threadIdx.x); i < left; i += int(gridDim.x * threads)) {
        const int bin = d.bin_of[block_of(d, d.leaving, i)];
        const int slot = bin < 0 ? bin_room : atomicAdd(d.counts + bin, 1);
        if (slot < bin_room)
            copy(d.particles, bin * bin_room + slot, d.leaving, i);
        else
            *d.crowded = 1;
    }
}

}  // namespace

void rebin(const BinView& bins, cudaStream_t stream)
{
    check(cudaMemsetAsync(bins.left, 0, sizeof(int), stream), "rebin");
    must_not_spill("leave", leave_kernel);
    must_not_spill("arrive", arrive_kernel);
    launch("leave", leave_kernel, bins.bins, threads, stream, bins);
    launch("arrive", arrive_kernel, 264, threads, stream, bins);
}

}  // namespace knead::micro
