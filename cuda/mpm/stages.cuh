// The stages of a substep on the device, in order, and all device data; each kernel gets its part
// of it (views.cuh).
//   masks . begin . pose . sort { settle } . line_up . p2g, once a frame; then, substep by substep,
//   [ separate . ] grid { next dt } . g2p { pose and scatter for the next }
#pragma once
#include "cuda/mpm/features.h"
#include "cuda/mpm/overlap.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Stored nodes in the order of Lattice::index. Two grids, so that one is cleared while the other is
// used; substep n uses grid n % 2. Each has one velocity field, of all clay; with blades two more,
// one per label, of uncut clay and clay with this label; with bodies one more per colour.
struct GridView {
    int fields;          // field_count()
    float4* nodes[2];    // fields * node_count each: Node<float>; one array twice if fixed-point
    long long* sums[2];  // fixed-point: 4 * fields * node_count each: momentum, mass; else null
    int* marks;          // block_count: what the block was last listed for, see listed_for()
    int* list[3];        // block_count each: blocks that may hold mass in substep n, in n % 3
    const bool* rim;     // block_count: block is at an end of the stored box (stored_region.h)
    float momentum_scale, mass_scale;  // fixed-point units per kg m/s and per kg: powers of two
    float negligible_mass;             // clipped nodes below it are counted apart [kg]
};

constexpr int max_boxes = 32;  // tools

// Sleep state by block (sleep.h), and the runs of particles to process: a run is the particles of
// one thread block, listed if one of them is in a block that is not asleep.
struct RestView {
    Rest<float> options;
    int run;            // particles
    int* quiet;         // block_count: consecutive frames at rest
    unsigned* fastest;  // block_count: bits of the largest speed squared at a frame's start
    int* activity;      // block_count: Activity at the frame's start
    int *free, *guard;  // block_count: the substep from which its clay moves, wakes if pushed
    int2* range;        // block_count: its particles, in the order of the sort
    unsigned *reached, *run_listed;  // block_count, per run: it is in the list
    int* list;                       // runs; length Clock::listed
    int* woken[2];                   // block_count: blocks that substep n woke, in n % 2
    int* changed;  // block_count: substeps completed when a particle there may last have moved
};

constexpr int max_joints = 1024, max_tools = 256;

// Input of one frame, written by the host before it starts; only the part in use is copied.
struct FrameInput {
    double duration, tool_step;  // [s]
    int most_substeps;           // after which the frame ends, as bounded; 0: any number
    Tool<float> tools[max_tools];
    // All joints at the start of the frame, then all at its end: ToolView::joints each.
    Joint<double> joints[2 * max_joints];
};

// The tools; posed for every substep.
struct ToolView {
    const Joint<double>*from, *to;  // of the frame's input, `joints` each
    int joints;
    const Binding<float>* bindings;  // one per sphere
    Span<Sphere<float>> spheres[2];
    Span<Shape<float>> shapes[2];  // both of substep n in n % 2
    Span<Shape<float>> mid_frame;  // at mid-frame
    float* travel;  // per primitive: the largest displacement of any of its points from mid-frame
                    // [m]
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    Mask* masks;  // block_count: contact candidates during the frame
    int* runs;    // of particles, those near tools first; not with sleep
    int run_count;
    unsigned char* near_runs;  // whether each run is near
    bool grid_contact;
    int passes;
    PushoutLimits<float> pushout;
    bool fast;  // see clears_each_time() (lag.h)
};

// All device data; each stage gets a part of it.
struct Views {
    ParticleView particles[2];  // their rows may overlap: see particles.cuh
    Materials materials;
    Lattice<float> lattice;
    Box3<float> stored, free;  // see stored_region.h
    Walls<float> walls;
    Sliding<float>* sliding;
    Vec3<float> gravity;  // [m/s^2]
    GridView grid;
    ToolView tools;
    RestView rest;
    PressureView pressure;
    BodyFields<float> bodies;
    StepLimits limits;
    Clock* clock;
    const FrameInput* input;
    Conditions conditions;
    unsigned overlaps = overlap::all;  // see overlap.h
};

// Scratch memory of a sort besides the free row and the ids that are not current.
struct SortSpace {
    int* counts;  // one per stored node: zero before and after; or null
    void* scratch;
    std::size_t scratch_bytes;
};
std::size_t sort_scratch_bytes(int count, const Lattice<float>& lattice, const Features& features);
// Whether a sort needs the current side at launch.
inline bool side_at_launch(const Features& features) { return features.fixed_point; }

// Sorts the particles by the base node of their stencil; within a node stably with `fixed_point`,
// else in any order. Flips Clock::side. In two parts: sort_particles() finds the order, arrange()
// moves the particles. `side` is used only if side_at_launch().
void sort_particles(const Views& views, const Features& features, const SortSpace& space, int side,
                    cudaStream_t stream);
void arrange(const Views& views, const Features& features, cudaStream_t stream);
// Sleep: computes the activity of each block in this frame. Call between sort_particles() and
// arrange(), after masks().
void update_activity(const Views& views, cudaStream_t stream);
// Reads the frame's input and chooses the first substep.
void begin(const Views& views, cudaStream_t stream);
// Contact candidates of each block during the frame, and the tools at the end of the first substep.
void masks(const Views& views, cudaStream_t stream);
void pose(const Views& views, cudaStream_t stream);
// Orders the runs of particles, those near tools first. After masks() and the sort; not with sleep.
void line_up(const Views& views, const Features& features, cudaStream_t stream);
// Cell-averaged pressure: sums for a frame's first substep, before grid().
void find_pressures(const Views& views, cudaStream_t stream);
// Scatters mass and momentum to the current grid, which must be clear, and lists its blocks.
void p2g(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream);
// With bodies: contact between them; before grid(). Does nothing without.
void separate(const Views& views, const Features& features, int multiprocessors,
              cudaStream_t stream);
// Computes velocities from momenta, clears the other grid, and chooses the next substep. `begins`:
// first of a frame, which never overlaps.
void grid(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream,
          bool begins = false);
// Cell-averaged pressure: clears the sums for the next substep, before g2p().
void clear_pressures(const Views& views, int multiprocessors, cudaStream_t stream);
// Advances the particles, scatters them to the other grid for the next substep, and advances the
// clock.
void g2p(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream);
// Depth [m] of every particle by id, 0 outside of all tools; into the free row.
void penetration(const Views& views, cudaStream_t stream);
// Velocity [m/s] of every particle by id, interpolated from the grid in the last substep; into the
// free row.
void velocities(const Views& views, cudaStream_t stream);

}  // namespace knead::gpu
