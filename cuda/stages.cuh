// The stages of a substep on the device, in their order, and all that their kernels see.
//   begin (once a frame) . sort . { pose . masks | p2g } . grid . g2p { next dt, again or not }
#pragma once
#include <cuda_runtime.h>

#include "contact.h"
#include "hand.h"
#include "material.h"
#include "particles.cuh"
#include "step.h"

namespace knead::gpu {

// What a scene uses; kernels are compiled for each case, so that it pays for nothing else.
enum class Flows { elastic, plastic, any };  // neo-Hookean without and with von Mises; everything
struct Needs {
    bool tools = false;
    bool fixed_point = false;  // sums that do not depend on their order
    bool blades = false;       // three velocity fields: see blade.h
    Flows flows = Flows::any;
};

// One frame's orders, written by the host before it starts.
struct Orders {
    double duration, tool_step;  // [s]
};

// Counted over a frame by the kernels; read by the host when it is over.
struct Counters {
    double dt_least, dt_most;  // [s]
    int substeps, limits[6];
    unsigned long long yielded, projected, clipped, confined, repaired;  // particle-substeps, nodes
    unsigned long long covered;  // particle-substeps with a blade beside them
    unsigned deepest;  // bits of the largest depth found [m]
    int active_blocks;
};

// Where a frame stands.
struct Clock {
    double elapsed, duration, tool_step, dt;  // [s]
    double speed_squared;                     // of the fastest particle [m^2/s^2]
    unsigned fastest;                         // bits of the same, while it is looked for
    unsigned finished;                        // blocks of g2p that are through
    int side;                                 // which of the two particle arrays is current
    int parity;                               // which of the two grids is current
    int active[2];                            // blocks that hold mass, per grid
    int limit;                                // what limits dt
    Counters counters;
};

// Materials by object. One that is alone travels with the kernel's arguments.
struct Materials {
    Material<float> first;
    const Material<float>* all;  // count
    int count;
    HD const Material<float>& operator[](int object) const
    {
        return count == 1 ? first : all[object];
    }
};

// Nodes in the order of Lattice::index. Two grids, so that one is cleared while the other is used.
// Each has one field, or with blades three: all clay, then that of uncut clay and each label.
struct GridView {
    int fields;            // 1 or 3
    float4* nodes[2];      // fields * node_count each: Node<float>; one array twice if fixed-point
    long long* sums[2];    // fixed-point: 4 * fields * node_count each: momentum, mass; else null
    unsigned* touched[2];  // block_count each: the block is in the list
    int* list[2];          // block_count each: blocks that hold mass, Clock::active of them
    float momentum_scale, mass_scale;  // fixed-point units per kg m/s and per kg: powers of two
};

// Indices of a stencil's nodes, axis by axis: the lattice's index is the sum of the three.
struct Offsets {
    int x[3], y[3], z[3];
    HD int at(Int3 step) const { return x[step.x] + y[step.y] + z[step.z]; }
};
HD Offsets offsets(const Lattice<float>& lattice, Int3 base)
{
    Offsets o;
    UNROLL
    for (int k = 0; k < 3; ++k) {
        o.x[k] = lattice.index({base.x + k, 0, 0});
        o.y[k] = lattice.index({0, base.y + k, 0});
        o.z[k] = lattice.index({0, 0, base.z + k});
    }
    return o;
}

// Where tools are kept, posed anew for every substep.
struct ToolView {
    const Joint<double>*from, *to;   // joints at both ends of the frame
    const Binding<float>* bindings;  // one per sphere
    Span<Sphere<float>> spheres;
    Span<Shape<float>> shapes;
    Span<const Primitive> primitives;
    Span<const Tool<float>> tools;
    Mask* masks;  // block_count
    bool grid_contact;
    int passes;
    HD Colliders<float> colliders() const
    {
        return {{spheres.data, spheres.count}, primitives, {shapes.data, shapes.count}, tools};
    }
};

struct Views {
    ParticleView particles[2];
    Materials materials;
    Lattice<float> lattice;
    Walls<float> walls;
    Vec3<float> gravity;  // [m/s^2]
    GridView grid;
    ToolView tools;
    Pace pace;
    Clock* clock;
    const Orders* orders;
    cudaGraphConditionalHandle again;  // set to 0 when the frame is over, if `looped`
    bool looped;
};

// Scratch of the sort: keys and orders before and after, and CUB's own.
struct SortSpace {
    unsigned *keys, *sorted_keys;  // count
    int *order, *sorted_order;     // count
    void* scratch;
    std::size_t scratch_bytes;
};
std::size_t sort_scratch_bytes(int count, const Lattice<float>& lattice);

// Orders the particles by the base node of their stencil, stably; flips Clock::side.
void sort(const Views& views, const SortSpace& space, cudaStream_t stream);
// Reads the orders and chooses the first substep.
void begin(const Views& views, cudaStream_t stream);
// Tools at the end of the substep, and the primitives near each block.
void pose(const Views& views, cudaStream_t stream);
// Adds mass and momentum to the current grid, which is clear, and lists its blocks.
void p2g(const Views& views, const Needs& needs, cudaStream_t stream);
// Momenta become velocities; clears the other grid.
void grid(const Views& views, const Needs& needs, int multiprocessors, cudaStream_t stream);
// Particles move; the clock moves on to the next substep.
void g2p(const Views& views, const Needs& needs, cudaStream_t stream);
// Depth [m] of every particle by id, 0 outside of all tools.
void penetration(const Views& views, float* depth, cudaStream_t stream);

}  // namespace knead::gpu
