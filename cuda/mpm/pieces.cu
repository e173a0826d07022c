// Union-find over occupied cells: hooking of the larger root to the smaller one by
// compare-and-swap, and halving of paths, which may race, as a stale write still names an ancestor.
// The result does not depend on the order.
#include <algorithm>

#include "cuda/contact/cut.h"
#include "cuda/device/launch.cuh"
#include "cuda/mpm/pieces.cuh"
#include "cuda/mpm/substep.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;
using Key = unsigned long long;

// What a key consists of; 1 is added, as 0 is a free place.
struct CellClay {
    Int3 cell;
    unsigned label;
    int group;
};
__device__ Key key_of(const CellClay& c, Int3 size)
{
    const Key cell = (Key(c.cell.z) * Key(size.y) + Key(c.cell.y)) * Key(size.x) + Key(c.cell.x);
    return ((cell * 4 + c.label) * Key(most_groups) + Key(c.group)) + 1;
}
__device__ CellClay clay_of(Key key, Int3 size)
{
    const Key all = (key - 1) / most_groups, cell = all / 4;
    return {{int(cell % Key(size.x)), int(cell / Key(size.x) % Key(size.y)),
             int(cell / Key(size.x) / Key(size.y))},
            unsigned(all % 4),
            int((key - 1) % most_groups)};
}

__device__ int first_place(Key key, int places)
{
    return int((key * 0x9e3779b97f4a7c15ull) >> 32) & (places - 1);
}

// The key's place, taken if it is new; -1: the table is full.
__device__ int taken(const PieceTable& t, Key key)
{
    int at = first_place(key, t.places);
    for (int k = 0; k < t.places; ++k, at = (at + 1) & (t.places - 1)) {
        Key there = __ldcg(t.keys + at);
        if (there == 0) there = atomicCAS(t.keys + at, 0ull, key);
        if (there == 0) t.parents[at] = at, t.sizes[at] = 0;
        if (there == 0 || there == key) return at;
    }
    *t.full = 1;
    return -1;
}
__device__ int found(const PieceTable& t, Key key)
{
    int at = first_place(key, t.places);
    for (int k = 0; k < t.places; ++k, at = (at + 1) & (t.places - 1)) {
        const Key there = t.keys[at];
        if (there == key) return at;
        if (there == 0) return -1;
    }
    return -1;
}

__device__ bool filled(const PieceTable& t, int at, const PieceLimits& limits)
{
    return unsigned(t.sums[at]) > limits.filled;
}

__device__ int root(int* parents, int v)
{
    int up = __ldcg(parents + v);
    while (up != v) {
        const int next = __ldcg(parents + up);
        if (next != up) parents[v] = next;
        v = up, up = next;
    }
    return v;
}
__device__ void join(int* parents, int a, int b)
{
    for (;;) {
        a = root(parents, a), b = root(parents, b);
        if (a == b) return;
        const int larger = max(a, b), smaller = min(a, b);
        if (atomicCAS(parents + larger, larger, smaller) == larger) return;
    }
}

// Lanes whose particles share a cell add together.
__global__ void __launch_bounds__(threads)
    occupy_kernel(const ConstParticleView particles, const Materials materials,
                  const Lattice<float> lattice, const int* group, const PieceLimits limits,
                  const PieceTable t)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    Key key = 0;
    unsigned share = 0;
    if (i < particles.count) {
        const int object = __float_as_int(particles.row(1, i).w);
        const int own = object < limits.objects ? group[object] : -1;
        if (own >= 0) {
            const Particle<float> q{.sides = __float_as_uint(particles.row(2, i).w)};
            key = key_of({lattice.cell_of(particles.position(i)), q.label(), own}, lattice.size);
            share = __float2uint_rn(65536 * limits.per_cell * materials[object].volume);
        }
    }
    const unsigned lanes = __match_any_sync(all_lanes, key);
    const unsigned sum = __reduce_add_sync(lanes, share);
    if (key == 0 || (threadIdx.x & 31) != unsigned(__ffs(int(lanes)) - 1)) return;
    const int at = taken(t, key);
    if (at >= 0) atomicAdd(t.sums + at, Key(__popc(lanes)) << 32 | Key(sum));
}

// One place of the table per thread: the cell itself, and half of its neighbours.
__global__ void __launch_bounds__(threads)
    connect_kernel(const Int3 size, const PieceLimits limits, const PieceTable t)
{
    const int at = int(blockIdx.x * threads + threadIdx.x);
    if (at >= t.places || t.keys[at] == 0 || !filled(t, at, limits)) return;
    const CellClay own = clay_of(t.keys[at], size);
    for (int k = 0; k < 14; ++k) {
        const Int3 n = own.cell + Int3{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= size.x || n.y >= size.y) continue;
        for (unsigned label = uncut; label <= below; ++label) {
            if (label != uncut && own.label != uncut && label != own.label) continue;
            if (k == 13 && label >= own.label) continue;
            const int other = found(t, key_of({n, label, own.group}, size));
            if (other >= 0 && filled(t, other, limits)) join(t.parents, at, other);
        }
    }
}

__global__ void __launch_bounds__(threads)
    weigh_kernel(const PieceLimits limits, const PieceTable t)
{
    const int at = int(blockIdx.x * threads + threadIdx.x);
    int to = -1, particles = 0;
    if (at < t.places && t.keys[at] != 0 && filled(t, at, limits))
        to = root(t.parents, at), particles = int(t.sums[at] >> 32);
    const unsigned lanes = __match_any_sync(all_lanes, to);
    const int sum = __reduce_add_sync(lanes, particles);
    if (to >= 0 && (threadIdx.x & 31) == unsigned(__ffs(int(lanes)) - 1))
        atomicAdd(t.sizes + to, sum);
}

__global__ void __launch_bounds__(threads)
    count_kernel(const Int3 size, const PieceLimits limits, const PieceTable t)
{
    const int at = int(blockIdx.x * threads + threadIdx.x);
    if (at >= t.places || t.keys[at] == 0 || !filled(t, at, limits)) return;
    if (t.parents[at] != at || t.sizes[at] < limits.fewest) return;
    atomicAdd(t.counts + clay_of(t.keys[at], size).group, 1);
}

int blocks_of(int count) { return (count + threads - 1) / threads; }

}  // namespace

// Twice what clay of two particles per cell needs; sparser clay may fill it.
int piece_places(int particles)
{
    int places = 1024;
    while (places < particles / 2 + 1) places *= 2;
    return places;
}

void count_pieces(const ConstParticleView& particles, const Materials& materials,
                  const Lattice<float>& lattice, const int* group, const PieceLimits& limits,
                  const PieceTable& table, cudaStream_t stream)
{
    const int places = blocks_of(table.places);
    launch("pieces: occupy", occupy_kernel, blocks_of(particles.count), threads, stream, particles,
           materials, lattice, group, limits, table);
    launch("pieces: connect", connect_kernel, places, threads, stream, lattice.size, limits, table);
    launch("pieces: weigh", weigh_kernel, places, threads, stream, limits, table);
    launch("pieces: count", count_kernel, places, threads, stream, lattice.size, limits, table);
}

}  // namespace knead::gpu
