// The stages of a surface on the device, in their order, and all that their kernels see.
//   renew . clear . deposit . list . soften, as often as it takes . count . scan . march . relax
//   ... . shade
// and first of all, where it is asked how the surface moves, remember.
// Where no clay has moved since the last surface, all up to the count stays as it is; where none
// has anywhere, so does the mesh. Categories lie one behind the other: block b of category c is
// block c * padded.block_count() + b, so one launch serves them all, and the triangles of each are
// one stretch.
#pragma once
#include <cuda_runtime.h>

#include "cuda/math/span.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/surface/ring.h"

namespace knead::gpu {

// Particles as a solver keeps them, on one of two sides; which one is known on the device.
struct Clay {
    ParticleView particles[2];
    const int* side;                // null: the first
    cudaStream_t stream = nullptr;  // on which they are moved
    // Where some may have lain still: how many substeps are through, of all frames, and per block
    // of the lattice that they are simulated on how many were when a particle there may last have
    // moved. Null: all may have moved.
    const int *substeps = nullptr, *changed = nullptr;
    Lattice<float> lattice{};
    int solver = 0;  // which of the process; 0: none that tells what moves
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

// What of a block of the padded lattice is recomputed, as bits.
enum Anew : unsigned {
    sums_anew = 1,   // clay that may have moved reaches one of its nodes
    near_anew = 2,   // particles whose stencils begin in it reach such a block
    nodes_anew = 4,  // densities, or the cases of its cells, may change
    all_anew = 7
};

// How much of the last surface was recomputed.
struct Progress {
    int anew;                 // 1: something
    int deposited, softened;  // blocks that are not empty, with sums_anew and nodes_anew
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
    int rounds;              // of softening
    bool whole;              // nothing is kept: all is recomputed
    int reach;               // nodes: how far from a sum densities and cases depend on it
    float iso;
    Grain first;               // of the first object: the only one, mostly
    Span<const Grain> grains;  // per object
    const Layer* layers;       // per category

    // categories * padded.node_count() each; 0 but in the active blocks
    unsigned* sums;
    float* density;  // of every round, one behind the other: blocks are softened one by one
    unsigned* marks;
    // The final densities of the surface before, as they lie; null: nobody asks how it moves.
    float* past;
    int* past_known;  // 0: there was none that counts

    unsigned* occupied;  // blocks: holds mass
    unsigned* anew;      // layer_blocks(): bits of Anew
    int* seen;           // Clay::substeps at the last surface; -1: there is none
    Progress* progress;
    int *list, *skin;  // blocks each: not empty; with vertices or triangles
    int* work;         // blocks: of the list those with nodes_anew, Progress::softened of them
    int* active;       // 3: how many there are of either, in any order; `list` of the last surface
    unsigned long long *counts, *before;  // blocks + 1 each: vertices + (triangles << 32)

    int vertex_room, triangle_room;
    // vertex_room each: (x, 1) [m]; normal and advance (advance.h) [m], 0 without `past`.
    float4 *vertices[2], *normals;
    Int3* triangles;     // triangle_room
    int* ring;           // vertex_room: triangles around a vertex
    int *next, *last;    // max_ring rows of vertex_room: their other vertices
    DrawCommand* draws;  // per category
    Faults* faults;

    HD std::size_t at_ring(int v, int k) const  // the k-th triangle around vertex v
    {
        return std::size_t(k) * std::size_t(vertex_room) + std::size_t(v);
    }
    HD int layer_nodes() const { return padded.node_count(); }
    HD int layer_blocks() const { return padded.block_count(); }
    HD float* density_of(int round) const
    {
        return density + std::size_t(round) * std::size_t(categories) * std::size_t(layer_nodes());
    }
    HD const float* final_density() const { return density_of(rounds - 1); }
};

// The mesh is as it was.
HD bool idle(const SurfaceView& d) { return !d.whole && d.progress->anew == 0; }
// Of a block of one category.
HD unsigned anew_of(const SurfaceView& d, int block)
{
    return d.whole ? unsigned(all_anew) : d.anew[block];
}

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

// What must be recomputed, where not all is.
void renew(const SurfaceView& view, const Clay& clay, cudaStream_t stream);
// Keeps the densities of the last surface, where view.past is.
void remember(const SurfaceView& view, int processors, cudaStream_t stream);
// Empties what of the last surface's blocks is.
void clear(const SurfaceView& view, int processors, cudaStream_t stream);
// Particles to sums.
void deposit(const SurfaceView& view, const Clay& clay, cudaStream_t stream);
// Blocks that the density will reach, with the cells around it.
void list(const SurfaceView& view, cudaStream_t stream);
// The round-th couple of binomial passes: from the sums, or from the round before.
constexpr int passes_a_round = 2;
void soften(const SurfaceView& view, int round, int processors, cudaStream_t stream);
// Marks every node with its crossed edges and its cell's case; counts them by block.
void count(const SurfaceView& view, int processors, cudaStream_t stream);
// Where every block's vertices and triangles begin.
void scan(const SurfaceView& view, const ScanSpace& space, cudaStream_t stream);
// Vertices into vertices[to], with their rings; triangles; the draw commands.
void march(const SurfaceView& view, int to, int processors, cudaStream_t stream);
// Every vertex looks at its ring: from vertices[from] to the other.
void relax(const SurfaceView& view, int from, float factor, int processors, cudaStream_t stream);
// Normals of vertices[0], and their advance.
void shade(const SurfaceView& view, int processors, cudaStream_t stream);

}  // namespace knead::gpu
