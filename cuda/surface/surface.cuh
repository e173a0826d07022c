// The stages of a surface on the device, in order, and the data of their kernels.
//   renew . clear . deposit . list . soften, repeated . count . scan . march . relax ... . shade
// If the motion of the surface is needed, `remember` comes first. In blocks where no clay has moved
// since the last surface, the results of the stages up to `count` are reused; if no clay has moved
// at all, so is the mesh. Categories are stored one after the other: block b of category c is block
// c * padded.block_count() + b, so one launch serves all of them, and the triangles of each are
// contiguous.
#pragma once
#include <cuda_runtime.h>

#include "cuda/math/span.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/surface/ring.h"

namespace knead::gpu {

// Particles of a solver, which alternate between two buffers.
struct Clay {
    ParticleView particles[2];
    const int* side;                // index of the current buffer, in device memory; null: 0
    cudaStream_t stream = nullptr;  // the stream that moves them
    // With sleep: the number of substeps completed, over all frames, and its value per block of the
    // simulation lattice when a particle there may last have moved. Null: all particles may have
    // moved.
    const int *substeps = nullptr, *changed = nullptr;
    Lattice<float> lattice{};
    int solver = 0;  // number of the solver in this process; 0: `changed` is not recorded
};

// Contribution of an object's particles to the density.
struct ObjectDeposit {
    float units;   // rest volume in units of its category's sums; 0: unusable
    int category;  // index
};

// Densities are summed as integers: bitwise independent of the order.
struct CategoryScale {
    float quantum;         // density of one unit, a power of two
    int smoothing_passes;  // passes
};

// Draw command of one category, in the layout of glDrawElementsIndirect.
struct DrawCommand {
    unsigned count, instances, first_index;
    int base_vertex;
    unsigned base_instance;
};

// Which parts of a block of the padded lattice are recomputed, as bits.
enum Dirty : unsigned {
    sums_dirty = 1,   // moved clay may reach one of its nodes
    near_dirty = 2,   // particles whose stencils start in it reach such a block
    nodes_dirty = 4,  // densities, or the cases of its cells, may change
    all_dirty = 7
};

// The part of the last surface that was recomputed.
struct Progress {
    int dirty;                // 1: at least one block is recomputed; 0: none
    int deposited, smoothed;  // number of non-empty blocks with sums_dirty, and with nodes_dirty
};

// Errors of the last surface.
struct SurfaceErrors {
    unsigned unusable, outside;  // particles skipped
    unsigned overflowed;         // a sum has overflowed
};

struct SurfaceView {
    Lattice<float> lattice;  // of the density
    Lattice<float> padded;   // with one more layer of empty nodes on each side: node n of `lattice`
                             // is node n + 1
    int categories, blocks;  // blocks of all categories
    int rounds;              // of softening
    bool whole;              // all blocks are recomputed
    int reach;               // distance over which densities and cases depend on a sum [nodes]
    float iso;
    ObjectDeposit first;                        // of the first object, in most scenes the only one
    Span<const ObjectDeposit> object_deposits;  // per object
    const CategoryScale* scales;                // per category

    // categories * padded.node_count() each; 0 outside the active blocks
    unsigned* sums;
    float* density;  // one array per round: a block reads its neighbours' values of the previous
                     // round
    unsigned* marks;
    // Final densities of the previous surface; null: the surface's motion is not needed.
    float* past;
    int* past_valid;  // 0: `past` is not valid

    unsigned* occupied;  // blocks: holds mass
    unsigned* dirty;     // layer_blocks(): bits of Dirty
    int* last_substep;   // value of Clay::substeps at the last surface; -1: no surface yet
    Progress* progress;
    int *list, *skin;  // room for `blocks` each: non-empty blocks; blocks with vertices or
                       // triangles
    int* work;    // room for `blocks`: the Progress::smoothed blocks of `list` with nodes_dirty
    int* active;  // 3 numbers: entries of `list`, of `skin`, and of the last surface's `list`;
                  // entries are unordered
    unsigned long long *counts, *before;  // blocks + 1 each: vertices + (triangles << 32) per
                                          // block, and their prefix sums

    int vertex_room, triangle_room;
    // vertex_room each: (x, 1) [m]; normal and advance (advance.h) [m], 0 without `past`.
    float4 *vertices[2], *normals;
    Int3* triangles;     // triangle_room
    int* ring;           // vertex_room: triangles around a vertex
    int *next, *last;    // max_ring rows of vertex_room: the other two vertices of each of these
                         // triangles
    DrawCommand* draws;  // per category
    SurfaceErrors* errors;

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

// Whether the mesh is unchanged.
HD bool unchanged(const SurfaceView& d) { return !d.whole && d.progress->dirty == 0; }
// The Dirty bits of a block, numbered over all categories.
HD unsigned dirty_of(const SurfaceView& d, int block)
{
    return d.whole ? unsigned(all_dirty) : d.dirty[block];
}

struct Amounts {
    unsigned vertices, triangles;
};
HD Amounts unpacked(unsigned long long both) { return {unsigned(both), unsigned(both >> 32)}; }

// Number of vertices; 0 if the surface does not fit.
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

// Selects the blocks to recompute, unless all are.
void mark_dirty(const SurfaceView& view, const Clay& clay, cudaStream_t stream);
// Saves the densities of the last surface to view.past.
void save_densities(const SurfaceView& view, int processors, cudaStream_t stream);
// Clears the blocks of the last surface.
void clear(const SurfaceView& view, int processors, cudaStream_t stream);
// Deposits the particles.
void deposit(const SurfaceView& view, const Clay& clay, cudaStream_t stream);
// Lists the blocks that the smoothed density reaches, including the cells next to it.
void list(const SurfaceView& view, cudaStream_t stream);
// The round-th pair of binomial passes: from the sums, or from the round before.
constexpr int passes_a_round = 2;
void smooth_density(const SurfaceView& view, int round, int processors, cudaStream_t stream);
// Marks each node with its crossed edges and the case of its cell; counts vertices and triangles
// per block.
void count(const SurfaceView& view, int processors, cudaStream_t stream);
// Prefix sums: the first vertex and triangle of each block.
void scan(const SurfaceView& view, const ScanSpace& space, cudaStream_t stream);
// Writes the vertices into vertices[to], their rings, the triangles and the draw commands.
void march(const SurfaceView& view, int to, int processors, cudaStream_t stream);
// Moves every vertex by its ring: from vertices[from] to the other buffer.
void relax(const SurfaceView& view, int from, float factor, int processors, cudaStream_t stream);
// Computes the normals of vertices[0], and their advance.
void shade(const SurfaceView& view, int processors, cudaStream_t stream);

}  // namespace knead::gpu
