// The stages of a surface on the device, in their order, and all that their kernels see.
//   clear . splat . list . soften, as often as it takes . count . scan . march . relax ... . shade
// Categories lie one behind the other: block b of category c is block c * padded.block_count() + b,
// so one launch serves them all, and the triangles of each are one stretch.
#pragma once
#include <cuda_runtime.h>

#include "particles.cuh"
#include "ring.h"

namespace knead::gpu {

// Particles as a solver keeps them: two arrays, and on the device which one is current.
struct Clay {
    ParticleView particles[2];
    const int* side;                // null: the first
    cudaStream_t stream = nullptr;  // on which they are moved
};

// What a particle of an object adds to the density.
struct Grain {
    float units;   // its rest volume in units of its category's sums; 0: it cannot be used
    int category;  // index
};

// Densities are summed as whole numbers: any order gives the same bits.
struct Layer {
    float quantum;   // density of one unit, a power of two
    int softenings;  // passes
};

// Of one category, as glDrawElementsIndirect reads it.
struct DrawCommand {
    unsigned count, instances, first_index;
    int base_vertex;
    unsigned base_instance;
};

// What went wrong in the last surface.
struct Faults {
    unsigned unusable, outside;  // particles left out
    unsigned crowded;            // a sum has overflowed
};

struct SurfaceView {
    Lattice<float> lattice;  // of the density
    Lattice<float> padded;   // the same in an empty layer: node n of `lattice` is n + 1 here
    int categories, blocks;  // blocks of all categories
    float iso;
    Grain first;               // of the first object: the only one, mostly
    Span<const Grain> grains;  // per object
    const Layer* layers;       // per category

    // categories * padded.node_count() each; 0 but in the active blocks
    unsigned* sums;
    float* density[2];
    unsigned* marks;

    unsigned* touched;  // blocks: holds mass
    int *list, *skin;   // blocks each: not empty; with vertices or triangles
    int* active;        // 3: how many there are of either, in any order; `list` of the last surface
    unsigned long long *counts, *before;  // blocks + 1 each: vertices + (triangles << 32)

    int vertex_room, triangle_room;
    float4 *vertices[2], *normals;  // vertex_room each: (x, 1) [m], (unit, 0)
    Int3* triangles;                // triangle_room
    int* ring;                      // vertex_room: triangles around a vertex
    int *next, *last;               // most_ring rows of vertex_room: their other vertices
    DrawCommand* draws;             // per category
    Faults* faults;

    HD std::size_t at_ring(int v, int k) const  // the k-th triangle around vertex v
    {
        return std::size_t(k) * std::size_t(vertex_room) + std::size_t(v);
    }
    HD int layer_nodes() const { return padded.node_count(); }
    HD int layer_blocks() const { return padded.block_count(); }
};

struct Amounts {
    unsigned vertices, triangles;
};
HD Amounts unpacked(unsigned long long both) { return {unsigned(both), unsigned(both >> 32)}; }

// Vertices that there are; none of a surface for which there is not room.
HD int vertex_count(const SurfaceView& d)
{
    const Amounts all = unpacked(d.before[d.blocks]);
    const bool fits =
        all.vertices <= unsigned(d.vertex_room) && all.triangles <= unsigned(d.triangle_room);
    return fits ? int(all.vertices) : 0;
}

struct ScanSpace {
    void* scratch;
    std::size_t bytes;
};
std::size_t scan_scratch_bytes(int blocks);

// Empties the blocks of the last surface.
void clear(const SurfaceView& view, int processors, cudaStream_t stream);
// Particles to sums.
void splat(const SurfaceView& view, const Clay& clay, cudaStream_t stream);
// Blocks that the density will reach, with the cells around it.
void list(const SurfaceView& view, cudaStream_t stream);
// The round-th couple of binomial passes: sums or density[from] to the other density.
constexpr int passes_a_round = 2;
void soften(const SurfaceView& view, int round, int processors, cudaStream_t stream);
// Marks every node with its crossed edges and its cell's case; counts them by block.
void count(const SurfaceView& view, int from, int processors, cudaStream_t stream);
// Where every block's vertices and triangles begin.
void scan(const SurfaceView& view, const ScanSpace& space, cudaStream_t stream);
// Vertices into vertices[to], with their rings; triangles; the draw commands.
void march(const SurfaceView& view, int from, int to, int processors, cudaStream_t stream);
// Every vertex looks at its ring: from vertices[from] to the other.
void relax(const SurfaceView& view, int from, float factor, int processors, cudaStream_t stream);
// Normals of vertices[0].
void shade(const SurfaceView& view, int processors, cudaStream_t stream);

}  // namespace knead::gpu
