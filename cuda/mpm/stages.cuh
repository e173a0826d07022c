// The stages of a substep on the device, in their order, and all that their kernels see.
//   begin . sort { settle } . masks . pose . p2g, once a frame; then, substep by substep,
//   grid { next dt } . g2p { pose and scatter for the next }
#pragma once
#include <cuda_runtime.h>

#include "cuda/contact/contact.h"
#include "cuda/contact/skinning.h"
#include "cuda/math/node4.h"
#include "cuda/math/span.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/mpm/sleep.h"
#include "cuda/mpm/stored_region.h"
#include "cuda/mpm/time_step.h"
#include "cuda/mpm/walls.h"

namespace knead::gpu {

// What a scene uses; kernels are compiled for each case, so that it pays for nothing else.
enum class PlasticityClass {
    elastic,
    plastic,
    any
};  // neo-Hookean without and with von Mises; everything
struct Features {
    bool tools = false;
    bool fixed_point = false;  // sums that do not depend on their order
    bool blades = false;       // three velocity fields: see cuda/contact/cut.h
    bool rests = false;        // clay may be still
    PlasticityClass plasticity = PlasticityClass::any;
};

// Particles that a thread block takes at a time: three fields fill shared memory sooner.
constexpr int run_length(bool blades) { return blades ? 64 : 128; }
inline int run_length(const Features& features) { return run_length(features.blades); }

// Counted over a frame by the kernels; read by the host when it is over.
struct Counters {
    double dt_min, dt_max;  // [s]
    int substeps, limits[6];
    unsigned long long yielded, projected, clipped, confined, repaired;  // particle-substeps, nodes
    unsigned long long covered;  // particle-substeps with a blade beside them
    unsigned long long moved;    // particle-substeps; of a scene in which clay may be still
    unsigned long long woken;    // blocks
    unsigned deepest;            // bits of the largest depth found [m]
    int active_blocks;
};

// What a frame does: nothing where the one before it has stopped (stored_region.h), and what that
// one has left where it is told to go on.
enum class Mode : int { running, stopped, going_on };

// Where the simulation stands. Substeps are counted through all frames; what belongs to substep n
// is kept in place n of a ring. Nothing is written by a kernel that reads it in the same place, so
// that no thread has to wait for all others: `done` is what grid goes by and g2p writes, `begun` is
// what g2p goes by and grid writes.
struct Clock {
    int done, begun;  // substeps through; the one under way
    float dt[2];      // of the one under way and of the one after it [s]; 0: there is none
    Step steps[3];
    int active[3];               // blocks listed of substep n, in n % 3
    unsigned fastest[2];         // bits of the largest speed squared that a substep left [m^2/s^2]
    int listed, woken[2];        // where clay may be still: as RestView has them
    int near_runs, far_runs;     // lined up so far in ToolView::runs
    double duration, tool_step;  // of the frame [s]
    int side;                    // on which of their two sides the particles lie
    int sorted_from;             // on which they lay before the last sort
    double drift;                // how far a particle may have come since the last sort [m]
    bool unsorted;               // they are sorted again in this frame
    Mode mode;
    bool crowded[2];  // a block of the rim is listed, as substep n noticed, in n % 2
    Step resume;      // before which the frame has stopped
    Counters counters;
    HD Step& step(int n) { return steps[n % 3]; }
};

// Materials by object. One that is alone travels with the kernel's arguments.
struct Materials {
    Material<float> first;
    const Material<float>* all;  // count
    int count;
    HD Material<float> operator[](int object) const
    {
        if (count == 1) return first;
        return all[object];
    }
};

// Nodes in the order of Lattice::index, of those that are stored. Two grids, so that one is cleared
// while the other is used; substep n has that of n % 2. Each has one field, or with blades three:
// all clay, then that of uncut clay and each label.
struct GridView {
    int fields;          // 1 or 3
    float4* nodes[2];    // fields * node_count each: Node<float>; one array twice if fixed-point
    long long* sums[2];  // fixed-point: 4 * fields * node_count each: momentum, mass; else null
    int* marks;          // block_count: what the block was last listed for, see listed_for()
    int* list[3];        // block_count each: blocks that may hold mass in substep n, in n % 3
    const bool* rim;     // block_count: the block is at an end of what is stored (stored_region.h)
    float momentum_scale, mass_scale;  // fixed-point units per kg m/s and per kg: powers of two
};

// A frame's first substep lists its blocks anew. Each later one begins with those of the one
// before, so that hardly anyone finds a block that is not listed yet: the atomic that finds out has
// high latency.
HD int listed_for(int n, bool first) { return 2 * n + first; }

// Where a stencil's columns along z begin among the nodes, axis by axis: the lattice's index is the
// sum of the three.
struct Offsets {
    int x[3], y[3], z;
    HD int column(Int3 step) const { return x[step.x] + y[step.y] + z; }
};
HD Offsets offsets(const Lattice<float>& lattice, Int3 base)
{
    Offsets o{{}, {}, lattice.index({0, 0, base.z})};
    UNROLL
    for (int k = 0; k < 3; ++k) {
        o.x[k] = lattice.along_x(base.x + k);
        o.y[k] = lattice.along_y(base.y + k);
    }
    return o;
}

// How far particles may have come when they are sorted again [cells]. Sums do not depend on the
// order, only their cost does.
constexpr double max_drift = 0.5;

constexpr int max_boxes = 32;  // tools

// Which clay is still (sleep.h), block by block, and which particles are looked at: a run of as
// many as a thread block takes is listed where one of them is in a block that is not asleep.
struct RestView {
    Rest<float> rule;
    int run;            // particles
    int* quiet;         // block_count: frames on end at rest
    unsigned* fastest;  // block_count: bits of the largest speed squared at a frame's start
    int* activity;      // block_count: Activity at the frame's start
    int *free, *guard;  // block_count: the substep from which its clay moves, wakes if pushed
    int2* range;        // block_count: its particles, in the order of the sort
    unsigned *reached, *run_listed;  // block_count, per run: it is in the list
    int* list;                       // runs, as Clock::listed counts
    int* woken[2];                   // block_count: blocks that substep n woke, in n % 2
    int* changed;  // block_count: substeps through when a particle there may last have moved
};

constexpr int max_joints = 1024, max_tools = 256;

// One frame's input, written by the host before it starts, and copied to the device at once, as far
// as a scene uses it.
struct FrameInput {
    double duration, tool_step;  // [s]
    Tool<float> tools[max_tools];
    // All of a motion at the frame's beginning, then all at its end: ToolView::joints each.
    Joint<double> joints[2 * max_joints];
};

// Where tools are kept, posed anew for every substep.
struct ToolView {
    const Joint<double>*from, *to;  // of the orders, `joints` each
    int joints;
    const Binding<float>* bindings;  // one per sphere
    Span<Sphere<float>> spheres[2];
    Span<Shape<float>> shapes[2];  // both of substep n in n % 2
    Span<Shape<float>> amid;       // of the frame's middle
    float* travel;  // per primitive: how far any point of it is from there, at most [m]
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    Mask* masks;  // block_count: what may touch the block at any time of the frame
    int* runs;    // of particles, those near tools first; where no clay may be still
    bool grid_contact;
    int passes;
    HD Colliders<float> colliders(int n) const
    {
        const int parity = n & 1;
        return {{spheres[parity].data, spheres[parity].count},
                primitives,
                {shapes[parity].data, shapes[parity].count},
                tools};
    }
};

struct Views {
    ParticleView particles[2];  // of the same seven rows: see particles.cuh
    Materials materials;
    Lattice<float> lattice;
    Region stored, free;  // see stored_region.h
    Walls<float> walls;
    Vec3<float> gravity;  // [m/s^2]
    GridView grid;
    ToolView tools;
    RestView rest;
    StepLimits limits;
    Clock* clock;
    const FrameInput* input;
    // Of a captured frame: whether it begins with a sort, by the side that the particles lie on,
    // or the same twice; whether another substep follows.
    bool captured;
    cudaGraphConditionalHandle unsorted[2], again;
};

// Where a sort works besides the row that is free and the ids that are not current.
struct SortSpace {
    int* counts;  // nodes that are stored: zero before and after; or none
    void* scratch;
    std::size_t scratch_bytes;
};
std::size_t sort_scratch_bytes(int count, const Lattice<float>& lattice, const Features& features);
// Whether a sort must be told, when it is launched, on which side the particles lie.
inline bool told_side(const Features& features) { return features.fixed_point; }

// Orders the particles by the base node of their stencil; those of one node stay in the order they
// came in where sums must not depend on it (`fixed_point`), else they come in any. Flips
// Clock::side. In two halves: what the first finds is carried out by the second. The first may have
// to be told the side.
void sort_particles(const Views& views, const Features& features, const SortSpace& space, int side,
                    cudaStream_t stream);
void arrange(const Views& views, const Features& features, cudaStream_t stream);
// Between them, where clay may be still: what each block's clay does in this frame. Needs masks().
void update_activity(const Views& views, cudaStream_t stream);
// Reads the orders and chooses the first substep.
void begin(const Views& views, cudaStream_t stream);
// What may touch each block during the frame, and the tools at the end of the first substep.
void masks(const Views& views, cudaStream_t stream);
void pose(const Views& views, cudaStream_t stream);
// Adds mass and momentum to the current grid, which is clear, and lists its blocks.
void p2g(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream);
// Momenta become velocities; the other grid is cleared; the next substep is chosen.
void grid(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream);
// Particles move, and are added to the other grid for the next substep, to which the clock moves
// on.
void g2p(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream);
// Depth [m] of every particle by id, 0 outside of all tools; into the row that is free.
void penetration(const Views& views, cudaStream_t stream);

}  // namespace knead::gpu
