// All device memory of one simulation, and the views of it that kernels take. Allocated at
// construction, when clay spreads, and by edits that need more; later edits reuse it.
#pragma once
#include <memory>

#include "cuda/device/device_array.cuh"
#include "cuda/math/box.h"
#include "cuda/mpm/edit.cuh"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stages.cuh"
#include "host/solver/bodies.h"
#include "host/solver/edits.h"
#include "host/solver/gpu/region_padding.h"
#include "host/solver/gpu/state.cuh"
#include "host/solver/substep.h"

namespace knead::gpu {

// Arrays with one entry per stored node or block.
struct NodeArrays {
    NodeArrays() = default;
    NodeArrays(const Lattice<float>& lattice, const Features& features);
    static std::size_t bytes_for(const Lattice<float>& lattice, const Features& features);
    std::size_t bytes() const;

    DeviceArray<float4> nodes[2];
    DeviceArray<long long> sums[2];
    DeviceArray<int> marks, list[3];     // GridView
    DeviceArray<CellPressure> cells[2];  // PressureView
    DeviceArray<int> counts;             // SortSpace
    DeviceArray<bool> rim;
    DeviceArray<Mask> masks;
    DeviceArray<unsigned> fastest, reached;  // RestView, with the next two lines
    DeviceArray<int> quiet, activity, free, guard, woken[2], changed;
    DeviceArray<int2> ranges;
};

// Grows an array with spare capacity: allocating and freeing synchronise the whole device. Contents
// are lost.
template <class T>
void reserve(DeviceArray<T>& array, std::size_t count)
{
    constexpr std::size_t few = std::size_t(64) << 20;  // bytes
    const std::size_t more = count * sizeof(T) < few ? count / 2 : count / 4;
    if (array.size() < count) array = DeviceArray<T>(count + more);
}

// The kernel variants that a scene needs.
Features features_of(const SimulationConfig& config, bool deterministic);
// Throws std::invalid_argument if the tools are inconsistent or exceed the limits of the device.
void check_tools(const SimulationConfig& config);

// Particles by id, from downloaded rows and ids.
std::vector<Particle<double>> in_double(const ParticleView& on_host);

// A scene on the device. Throws std::invalid_argument for inconsistent scenes and
// std::runtime_error when out of device memory.
class Store {
  public:
    explicit Store(const Setup& setup, RegionPadding room = {}, int device = 0);

    Views views() const { return all; }
    Features features() const { return used; }
    SortSpace sort_space() const { return {box.counts.data(), scratch.data(), scratch.bytes()}; }
    std::size_t bytes() const;

    // write_input() writes a frame's input to one of two pinned slots and returns whether a tool is
    // active; `bound`: FrameInput::most_substeps. send_input() copies a slot to the device in
    // stream order; do not reuse the slot before that copy is complete.
    bool write_input(const SimulationConfig& config, const Motion& motion, double duration,
                     int bound, int slot);
    void send_input(int slot, cudaStream_t stream) const;

    std::vector<Particle<double>> particles() const;
    std::vector<Vec3<double>> places_in(const Box3<double>& within) const;
    std::vector<float> depths(cudaStream_t stream) const;       // of penetration(), by id [m]
    std::vector<float4> velocities(cudaStream_t stream) const;  // of velocities(), by id [m/s]
    void set_sides(const std::vector<Particle<double>>& particles) const;
    // Copy of the particles, of the blocks' frames at rest, and of sliding. put_back() requires a
    // store with the same box of nodes and room for the particles, which it writes to `side`.
    std::shared_ptr<DeviceState> state(int side, cudaStream_t stream) const;
    void put_back(const DeviceState& state, int side, cudaStream_t stream) const;
    StateView state_view(int side) const;
    std::vector<int> order(int side) const;  // ids in particle order
    // Clears both grids.
    void clear_grids() const;
    void set_clock(const Clock& clock) const;
    Clock clock(cudaStream_t stream = nullptr) const;  // waits for the stream
    // Enlarges the stored box of nodes beyond the blocks that clay has reached. Changes views() and
    // clears the grids. Throws std::runtime_error when out of device memory. Strong guarantee.
    void grow();

    // Edits (edit.cu), between frames; they may change views() and features(). set_rules() applies
    // materials, gravity and walls; set_tools() the tools.
    void set_rules(const SceneState& rules);
    void set_tools(const SceneState& rules);
    // Bodies that share colours get those of where they are. Returns whether any has changed: then
    // captured graphs are stale, and what slides at walls was that of other clay. Waits.
    bool recolour(const SimulationConfig& config, int side, cudaStream_t stream);
    int welded_bodies() const { return bodies.welded; }
    bool shares_colours() const { return bodies.shared(); }
    // Captured graphs remain valid: no kernel reads the category.
    void set_category(int object, int category);
    // Enlarges the stored box to the stencils of particles in `clay`.
    void hold(const Box3<float>& clay);
    // Stores the box of a new store with its particles in `clay`: in fixed point, because the
    // partial sums of warps depend on it; else only if the present one does not hold them.
    void enclose(const Box3<float>& clay);
    void set_box(const Lattice<float>& box);
    // Appends to the particles on `side`; all are on side 0 afterwards. Enlarges the stored box as
    // needed.
    void append(Clays clays, const std::vector<int>& objects, int side, cudaStream_t stream);
    // Removes the particles of marked objects; `left` is the number that remains.
    void erase(const std::vector<char>& objects, long left, int side, cudaStream_t stream);
    void arrange_as_new(const Extent& around, int side, cudaStream_t stream);
    // Allocates for `count` particles; discards the current ones. Strong guarantee.
    void resize(int count);
    // All particles, at rest, to side 0. Precondition: resized to their number.
    void put(const ClayRows& clay, cudaStream_t stream) const;
    void upload(const std::vector<Particle<double>>& particles, const std::vector<int>& order);
    void set_quiet(const std::vector<int>& quiet) const;
    void forget_quiet(cudaStream_t stream) const;  // all 0: no block has been at rest
    // Restores the nodes whose clay slid along walls in the last substep; forget_sliding() resets
    // all.
    void slide_on(const std::vector<SlidingNode>& nodes, int done) const;
    void forget_sliding(cudaStream_t stream) const;
    // Bounding box of an object (or of all) after a motion.
    Extent extent(int object, const RigidMotion<double>& motion, int side,
                  cudaStream_t stream) const;
    int count() const { return all.particles[0].count; }
    const std::shared_ptr<Pool>& snapshot_pool() const { return pool; }

    DeviceArray<float4> rows;  // row_places() or more
    NodeArrays box;
    DeviceArray<int> ids[2];

  private:
    void point();
    void set_colours(const SimulationConfig& config);
    void point_at_tools(const SimulationConfig& config);
    void set_features(const Features& features);
    void set_count(int count);
    void reserve_runs();
    void reserve_scratch(int count);
    void reserve_others(std::size_t count);
    bool holds(const Box3<float>& clay) const;
    void swap_in(int count);
    std::vector<float4> rows_on(int side) const;

    DeviceArray<Material<float>> materials;
    Bodies bodies;
    DeviceArray<int> colours, body_of;                  // by object, see Bodies
    DeviceArray<unsigned long long> bins_masks, graph;  // see body_graph()
    DeviceArray<Binding<float>> bindings;
    DeviceArray<Primitive> primitives;
    DeviceArray<Sphere<float>> spheres[2];
    DeviceArray<Shape<float>> shapes[2], mid_frame;
    DeviceArray<float> travel;
    DeviceArray<unsigned> run_listed;
    DeviceArray<int> runs, in_line;
    DeviceArray<Sliding<float>> sliding;
    DeviceArray<Clock> clocks;
    DeviceArray<FrameInput> input;
    DeviceArray<unsigned char> scratch, near_runs;
    DeviceArray<Extent> found;
    // Target of edits that copy the remaining particles; then swapped with the current arrays.
    DeviceArray<float4> other_rows;
    DeviceArray<int> other_ids, places;
    DeviceArray<char> gone;  // by object
    std::shared_ptr<Pool> pool;
    Pinned<FrameInput> next_input[2];
    Views all{};
    Features used;
    RegionPadding room;
};

}  // namespace knead::gpu
