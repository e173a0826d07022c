// What each stage's kernels are given, by value: what they read, then what they write or add to.
// Of the clock cuda/mpm/clock.cuh tells it field by field. Each view has one function that makes it
// of all there is on the device (stages.cuh).
#pragma once
#include <cuda_runtime.h>

#include "cuda/contact/contact.h"
#include "cuda/contact/skinning.h"
#include "cuda/math/span.h"
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

// Materials by object. One that is alone travels with the kernel's arguments.
struct Materials {
    Material<float> first;
    float per_density, per_mass;  // 1 over those of the first [m^3/kg, 1/kg]
    const Material<float>* all;   // count
    int count;
    HD Material<float> operator[](int object) const
    {
        if (count == 1) return first;
        return all[object];
    }
};

// Of a captured frame: whether it begins with a sort, by the side that the particles lie on, or the
// same twice; whether another substep follows.
struct Conditions {
    bool captured;
    cudaGraphConditionalHandle unsorted[2], again;
};

// A new frame, or what is left of one.
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

// Medial spheres and the joints that they hang on.
struct RigView {
    // reads
    const Joint<double>*from, *to;  // `joints` each: at the frame's beginning and its end
    int joints;
    const Binding<float>* bindings;  // one per sphere
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
};

// Where each primitive may be at any time of the frame.
struct SweepView : RigView {
    // writes
    Shape<float>* mid_frame;  // per primitive: in the frame's middle
    float* travel;            // per primitive: how far any point of it is from there, at most [m]
};
SweepView sweep_view(const Views& d);

// What a sweep has found.
struct SweptView {
    // reads
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    const Shape<float>* mid_frame;
    const float* travel;
};

// What may touch each block at any time of the frame.
struct MaskView : SweptView {
    // reads
    Lattice<float> lattice;
    const int* next_runs;  // lined up in the frame before
    int run_count;
    // writes
    Mask* masks;  // block_count
    int* runs;
};
MaskView mask_view(const Views& d);

// The tools posed for substep n; both sides of the ring, n % 2.
struct PoseView : RigView {
    // reads, and writes what it has posed for
    Clock* clock;
    // writes
    Sphere<float>* spheres[2];
    Shape<float>* shapes[2];
};
PoseView pose_view(const Views& d);

// The tools as they are in substep n.
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

// What tools may touch a particle.
struct NearView {
    // reads
    Region stored;      // elsewhere there are no masks
    const Mask* masks;  // block_count
    int passes;         // of projection; 0: no tools
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
    int* next_runs;            // those near tools first
};
LineUpView line_up_view(const Views& d);

// Sorting: the rows of one side, by its ids, to the other.
struct SortView {
    // writes: the row that is free, the ids that are not current, then row by row the other side
    ParticleView particles[2];
    Clock* clock;
};
SortView sort_view(const Views& d);

struct KeyView : SortView {
    // reads
    Lattice<float> lattice;
    // writes
    unsigned* fastest;  // block_count: bits of the largest speed squared; where clay may be still
};
KeyView key_view(const Views& d);

// Where clay may be still: which runs are looked at, which particles are held.
struct SettledView : SortView {
    // reads
    const int* activity;  // block_count
    // writes
    int2* range;  // block_count
    unsigned* run_listed;
    int* list;  // runs, as Clock::listed counts
};
SettledView settled_view(const Views& d);

// Where clay may be still: what each block's clay does in this frame, of itself ...
struct ActivityView : SweptView {
    // reads
    Lattice<float> lattice;
    Rest<float> options;
    // writes
    int* quiet;         // block_count each
    unsigned* fastest;  // reads it, and clears it
    int* activity;
    int2* range;
    unsigned* run_listed;
    Clock* clock;
};
ActivityView activity_view(const Views& d);

// ... and for its neighbours' sake ...
struct SpreadView {
    // reads
    Lattice<float> lattice;
    Rest<float> options;
    // writes
    int* activity;  // block_count
};
SpreadView spread_view(const Views& d);

// ... and what of it the substeps go by.
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

// A scatter for substep n.
struct ScatterView {
    // reads
    Lattice<float> lattice;
    const bool* rim;                   // block_count
    float momentum_scale, mass_scale;  // fixed-point units per kg m/s and per kg
    // writes
    float4* nodes[2];    // fields * node_count each: that of n % 2
    long long* sums[2];  // fixed-point: in their stead; else null
    int* marks;          // block_count
    int* list[3];        // block_count each: that of n % 3
    Clock* clock;
};

// Of a cell, its lowest stencils' node: sums of its particles in fixed point, see PressureSum.
struct CellPressure {
    long long pressure, volume;
};
// Where clay shares its cells' pressure.
struct PressureView {
    CellPressure* cells[2];              // node_count each, or none: sums for substep n, in n % 2
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
    const int* listed;    // runs, where clay may be still
    bool beside_sort;     // a sort may be under way: particles are taken from where they lay before
};
P2gView p2g_view(const Views& d, bool beside_sort);

// Where clay may be still: what is around blocks that have woken.
struct GuardView {
    // reads
    RestMode mode;
    int run;  // particles
    const int2* range;
    const int* woken[2];  // that of the substep before
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
    float4* nodes[2];    // of substep n, in n % 2: momenta become velocities; the other is cleared
    long long* sums[2];  // fixed-point momenta; else null
    int* marks;
    int* list[3];             // reads those of n - 1 and of n; writes that of n + 1
    Sliding<float>* sliding;  // sliding_places() in each velocity field
    Clock* clock;
    GuardView rest;
};
GridUpdateView grid_view(const Views& d);

// Where clay may be still: whether a block's is.
struct WakeView {
    // reads
    Rest<float> options;
    Vec3<float> gravity;  // [m/s^2]
    const int* guard;
    const int2* range;
    // writes
    int *free, *changed;
    int* woken[2];  // that of substep n
};

struct G2pView : ScatterView {
    // reads
    const float4* velocities[2];  // that of substep n, in n % 2
    Materials materials;
    Region free;  // see stored_region.h
    Walls<float> walls;
    ContactView contact;
    NearView near;
    PressureView pressure;  // adds to the sums for the next substep, too
    const int* runs;        // as they are lined up
    const int* listed;      // those of clay that may be still
    // writes
    ParticleView particles[2];
    PoseView pose;
    WakeView rest;
    bool captured;
    cudaGraphConditionalHandle again;
};
G2pView g2p_view(const Views& d);

// How deep particles are in the tools at the frame's end.
struct PenetrationView {
    // reads
    Lattice<float> lattice;
    ContactView contact;
    const Mask* masks;
    const Clock* clock;
    // writes: the row that is free
    ParticleView particles[2];
};
PenetrationView penetration_view(const Views& d);

// How the lattice moved the particles in the frame's last substep.
struct VelocityView : PenetrationView {
    // reads
    float skin;              // of (19) [m]
    const float4* nodes[2];  // velocities and masses of substep n, in n % 2
};
VelocityView velocity_view(const Views& d);

}  // namespace knead::gpu
