// The stages of a substep on the device, in their order, and all there is on the device, of which
// each stage's kernels are given their part (views.cuh).
//   begin . sort { settle } . masks . line_up . pose . p2g, once a frame; then, substep by substep,
//   grid { next dt } . g2p { pose and scatter for the next }
#pragma once
#include "cuda/mpm/features.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

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
    float negligible_mass;             // of a node: slowed it is trimmed, not clipped [kg]
};

constexpr int max_boxes = 32;  // tools

// Which clay is still (sleep.h), block by block, and which particles are looked at: a run of as
// many as a thread block takes is listed where one of them is in a block that is not asleep.
struct RestView {
    Rest<float> options;
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

// Where tools are kept, posed again for every substep.
struct ToolView {
    const Joint<double>*from, *to;  // of the frame's input, `joints` each
    int joints;
    const Binding<float>* bindings;  // one per sphere
    Span<Sphere<float>> spheres[2];
    Span<Shape<float>> shapes[2];  // both of substep n in n % 2
    Span<Shape<float>> mid_frame;  // of the frame's middle
    float* travel;  // per primitive: how far any point of it is from there, at most [m]
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    Mask* masks;  // block_count: what may touch the block at any time of the frame
    int* runs;    // of particles, those near tools first; where no clay may be still
    int run_count;
    int* next_runs;            // likewise, for the next frame,
    unsigned char* near_runs;  // of whether each is near
    bool grid_contact;
    int passes;
    PushoutLimits<float> pushout;
    bool fast;  // as clears_each_time() has it (lag.h)
};

// All that there is, of which each stage takes its part.
struct Views {
    ParticleView particles[2];  // their rows overlap, or not: see particles.cuh
    Materials materials;
    Lattice<float> lattice;
    Region stored, free;  // see stored_region.h
    Walls<float> walls;
    Sliding<float>* sliding;
    Vec3<float> gravity;  // [m/s^2]
    GridView grid;
    ToolView tools;
    RestView rest;
    PressureView pressure;
    StepLimits limits;
    Clock* clock;
    const FrameInput* input;
    Conditions conditions;
};

// Where a sort works besides a row that is free and the ids that are not current.
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
// Reads the frame's input and chooses the first substep.
void begin(const Views& views, cudaStream_t stream);
// What may touch each block during the frame, and the tools at the end of the first substep.
// masks() also puts runs of particles in the order that line_up() has found.
void masks(const Views& views, cudaStream_t stream);
void pose(const Views& views, cudaStream_t stream);
// Lines up runs of particles for the next frame, those near tools first. Tools come on little in a
// frame, and so nothing of this one has to wait for it. After masks(), once the particles are
// sorted; not where clay may be still.
void line_up(const Views& views, const Features& features, cudaStream_t stream);
// Where clay shares its cells' pressure: sums for a frame's first substep, before grid().
void find_pressures(const Views& views, cudaStream_t stream);
// Adds mass and momentum to the current grid, which is clear, and lists its blocks. `beside_sort`:
// of particles as they lay before a sort that may be under way, which leaves those alone.
void p2g(const Views& views, const Features& features, int multiprocessors, bool beside_sort,
         cudaStream_t stream);
// Momenta become velocities; the other grid is cleared; the next substep is chosen. `begins`: a
// frame does, for which several stages have to be over, not the one before it alone.
void grid(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream,
          bool begins = false);
// Where clay shares its cells' pressure: sums for the next substep are cleared, before g2p().
void clear_pressures(const Views& views, int multiprocessors, cudaStream_t stream);
// Particles move, and are added to the other grid for the next substep, to which the clock moves
// on.
void g2p(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream);
// Depth [m] of every particle by id, 0 outside of all tools; into the row that is free.
void penetration(const Views& views, cudaStream_t stream);
// Velocity [m/s] of every particle by id, as the lattice gave it in the last substep; into the row
// that is free.
void velocities(const Views& views, cudaStream_t stream);

}  // namespace knead::gpu
