// Kernel arguments, passed by value: one view per stage, with what it reads, then what it writes or
// adds to. Access to the clock is listed field by field in cuda/mpm/clock.cuh. Each view has one
// function that makes it from all device data (stages.cuh).
#pragma once
#include <cuda_runtime.h>

#include "cuda/contact/contact.h"
#include "cuda/contact/skinning.h"
#include "cuda/math/span.h"
#include "cuda/mpm/body_contact.h"
#include "cuda/mpm/clock.cuh"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/mpm/project.h"
#include "cuda/mpm/sleep.h"
#include "cuda/mpm/sliding.h"
#include "cuda/mpm/stored_region.h"
#include "cuda/mpm/walls.h"

namespace knead::gpu {

struct Views;
struct FrameInput;

// Materials by object. A single material is passed in the kernel's arguments.
struct Materials {
    Material<float> first;
    float per_density, per_mass;  // reciprocals of the first's [m^3/kg, 1/kg]
    const Material<float>* all;   // count
    int count;
    const int* colours =
        nullptr;  // count, with bodies: their first velocity fields, body_contact.h
    HD Material<float> operator[](int object) const
    {
        if (count == 1) return first;
        return all[object];
    }
};

// Conditional nodes of a captured frame: whether it begins with a sort, one handle per particle
// side (or the same handle twice); whether another substep follows.
struct Conditions {
    bool captured;
    cudaGraphConditionalHandle unsorted[2], again;
};

// Starts a frame, or the remainder of one.
struct BeginView {
    // reads
    const FrameInput* input;
    StepLimits limits;
    RestMode rest;
    // writes
    Clock* clock;
    Conditions conditions;
};
BeginView begin_view(const Views& d);

// Medial spheres and the joints that they are bound to.
struct RigView {
    // reads
    const Joint<double>*from, *to;  // `joints` each: at the start and the end of the frame
    int joints;
    const Binding<float>* bindings;  // one per sphere
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
};

// Space swept by each primitive during the frame.
struct SweepView : RigView {
    // writes
    Shape<float>* mid_frame;  // per primitive: at mid-frame
    float* travel;            // per primitive: its largest displacement from there [m]
};
SweepView sweep_view(const Views& d);

// Result of the sweep.
struct SweptView {
    // reads
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    const Shape<float>* mid_frame;
    const float* travel;
};

// Contact candidates of each block for the whole frame.
struct MaskView : SweptView {
    // reads
    Lattice<float> lattice;
    // writes
    Mask* masks;  // block_count
};
MaskView mask_view(const Views& d);

// Poses the tools for substep n; both halves of the ring, n % 2.
struct PoseView : RigView {
    // reads; writes `posed`
    Clock* clock;
    // writes
    Sphere<float>* spheres[2];
    Shape<float>* shapes[2];
};
PoseView pose_view(const Views& d);

// The posed tools of substep n.
struct ContactView {
    // reads
    Span<const Sphere<float>> spheres[2];
    Span<const Shape<float>> shapes[2];
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    HD Colliders<float> colliders(int n) const
    {
        const int parity = n & 1;
        return {spheres[parity], primitives, shapes[parity], tools};
    }
};

// Contact candidates of particles.
struct NearView {
    // reads
    Box3<float> stored;  // no masks outside
    const Mask* masks;   // block_count
    int passes;          // of projection; 0: no tools
    PushoutLimits<float> pushout;
};

// Which runs of particles are near tools.
struct LineUpView {
    // reads
    ConstParticleView particles[2];
    Lattice<float> lattice;
    NearView near;
    int run_count;
    const Clock* clock;
    // writes
    unsigned char* near_runs;  // whether a run is near
    int* runs;                 // those near tools first
};
LineUpView line_up_view(const Views& d);

// Sorting: gathers the rows of one side by the sorted ids into the other side.
struct SortView {
    // writes: the free row, the ids that are not current, then row by row the other side
    ParticleView particles[2];
    Clock* clock;
};
SortView sort_view(const Views& d);

struct KeyView : SortView {
    // reads
    Lattice<float> lattice;
    // writes
    unsigned* fastest;  // block_count: bits of the largest speed squared; with sleep only
};
KeyView key_view(const Views& d);

// Sleep: selects the runs to process and the particles to hold.
struct SettledView : SortView {
    // reads
    const int* activity;  // block_count
    // writes
    int2* range;  // block_count
    unsigned* run_listed;
    int* list;  // runs; length Clock::listed
};
SettledView settled_view(const Views& d);

// Sleep, pass 1: activity of each block from its own particles and from nearby tools.
struct ActivityView : SweptView {
    // reads
    Lattice<float> lattice;
    Rest<float> options;
    // writes
    int* quiet;         // block_count each
    unsigned* fastest;  // read and cleared
    int* activity;
    int2* range;
    unsigned* run_listed;
    Clock* clock;
};
ActivityView activity_view(const Views& d);

// Sleep, pass 2: raises the activity of neighbours.
struct SpreadView {
    // reads
    Lattice<float> lattice;
    Rest<float> options;
    // writes
    int* activity;  // block_count
};
SpreadView spread_view(const Views& d);

// Sleep, pass 3: writes the activity as the per-block substep numbers used by the substeps.
struct StampView {
    // reads
    const Clock* clock;
    const int* activity;  // block_count each
    int blocks;
    // writes
    int *free, *guard, *changed;
    unsigned* reached;
};
StampView stamp_view(const Views& d);

// Scatter for substep n.
struct ScatterView {
    // reads
    Lattice<float> lattice;
    const bool* rim;                   // block_count
    float momentum_scale, mass_scale;  // fixed-point units per kg m/s and per kg
    // writes
    float4* nodes[2];    // fields * node_count each, in n % 2
    long long* sums[2];  // used instead in fixed point; else null
    int* marks;          // block_count
    int* list[3];        // block_count each, in n % 3
    Clock* clock;
};

// Sums over the particles of a cell in fixed point, stored at the base node of their stencils, see
// PressureSum.
struct CellPressure {
    long long pressure, volume;
};
// Cell-averaged pressure.
struct PressureView {
    CellPressure* cells[2];              // node_count each, or null: sums for substep n, in n % 2
    float pressure_scale, volume_scale;  // units per Pa m^3 and per m^3: powers of two
};

struct PressureFindView : PressureView {
    // reads
    ConstParticleView particles[2];
    Materials materials;
    Lattice<float> lattice;
    const Clock* clock;
};
PressureFindView pressure_find_view(const Views& d);

struct PressureClearView : PressureView {
    // reads
    const int* list[3];  // blocks that hold mass in substep n, in n % 3
    const Clock* clock;
};
PressureClearView pressure_clear_view(const Views& d);

struct P2gView : ScatterView {
    // reads
    ConstParticleView particles[2];
    Materials materials;
    RestMode mode;
    Vec3<float> gravity;  // [m/s^2]
    const int* listed;    // runs, with sleep only
};
P2gView p2g_view(const Views& d);

// Sleep: neighbourhoods of blocks that have woken.
struct GuardView {
    // reads
    RestMode mode;
    int run;  // particles
    const int2* range;
    const int* woken[2];  // in the previous substep
    // writes
    int* guard;
    unsigned *reached, *run_listed;
    int* list;
};

struct GridUpdateView {
    // reads
    ContactView contact;
    const Mask* masks;
    bool grid_contact;
    Lattice<float> lattice;
    Walls<float> walls;
    Vec3<float> gravity;  // [m/s^2]
    StepLimits limits;
    int fields;
    float momentum_scale, mass_scale, negligible_mass;
    const bool* rim;
    // writes
    float4* nodes[2];    // of substep n, in n % 2: velocities from momenta; the other is cleared
    long long* sums[2];  // fixed-point momenta; else null
    int* marks;
    int* list[3];             // reads lists n - 1 and n; writes list n + 1
    Sliding<float>* sliding;  // sliding_places() per velocity field
    Clock* clock;
    GuardView rest;
    bool contact_ahead;  // see overlap.h
};
GridUpdateView grid_view(const Views& d);

// Contact of bodies in substep n: changes momenta, and sums the masses of all fields into field 0.
struct BodyView {
    // reads
    Lattice<float> lattice;
    BodyFields<float> bodies;
    const int* list[3];  // blocks that hold mass in substep n, in n % 3
    const Clock* clock;
    float momentum_scale;            // fixed-point units per kg m/s
    float momentum_unit, mass_unit;  // one unit [kg m/s], [kg]: powers of two
    // writes
    float4* nodes[2];    // of substep n, in n % 2
    long long* sums[2];  // used instead in fixed point; else null
};
BodyView body_view(const Views& d);

// Sleep: wakes a block.
struct WakeView {
    // reads
    Rest<float> options;
    Vec3<float> gravity;  // [m/s^2]
    const int* guard;
    const int2* range;
    // writes
    int *free, *changed;
    int* woken[2];  // by substep n, in n % 2
};

struct G2pView : ScatterView {
    // reads
    const float4* velocities[2];  // of substep n, in n % 2
    Materials materials;
    Box3<float> free;  // see stored_region.h
    Walls<float> walls;
    ContactView contact;
    NearView near;
    PressureView pressure;  // adds to the sums of the next substep
    const int* runs;        // in order of contact
    const int* listed;      // runs, with sleep only
    // writes
    ParticleView particles[2];
    PoseView pose;
    WakeView rest;
    bool captured;
    cudaGraphConditionalHandle again;
    bool pose_ahead;  // see overlap.h
};
G2pView g2p_view(const Views& d);

// Penetration depth of particles in the tools at the end of the frame.
struct PenetrationView {
    // reads
    Lattice<float> lattice;
    ContactView contact;
    const Mask* masks;
    const Clock* clock;
    // writes: the free row
    ParticleView particles[2];
};
PenetrationView penetration_view(const Views& d);

// Particle velocities interpolated from the grid in the frame's last substep.
struct VelocityView : PenetrationView {
    // reads
    float skin;              // see (19) [m]
    const float4* nodes[2];  // velocities and masses of substep n, in n % 2
};
VelocityView velocity_view(const Views& d);

}  // namespace knead::gpu
