// All device memory of one simulation, and the views of it that kernels take. Allocated when it is
// made, when clay spreads, and where an edit needs more: what an edit has got, the next one reuses.
#pragma once
#include <memory>

#include "cuda/device/device_array.cuh"
#include "cuda/mpm/edit.cuh"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stages.cuh"
#include "host/solver/edits.h"
#include "host/solver/gpu/region_padding.h"
#include "host/solver/gpu/state.cuh"
#include "host/solver/substep.h"

namespace knead::gpu {

// What there is for every node that is stored, or every block.
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
    DeviceArray<unsigned> fastest, reached;  // RestView, as those that follow
    DeviceArray<int> quiet, activity, free, guard, woken[2], changed;
    DeviceArray<int2> ranges;
};

// What kernels are compiled for that run the scene.
Features features_of(const Setup& setup);
// Throws std::invalid_argument where tools are more than the device takes, or do not hang together.
void check_tools(const Setup& setup);

// By id, of rows and ids that were downloaded.
std::vector<Particle<double>> in_double(const ParticleView& on_host);

// The device's form of a scene. Throws std::invalid_argument for one that does not hang together
// and std::runtime_error where the device has not enough memory.
class Store {
  public:
    explicit Store(const Setup& setup, RegionPadding room = {}, int device = 0);

    Views views() const { return all; }
    Features features() const { return used; }
    SortSpace sort_space() const { return {box.counts.data(), scratch.data(), scratch.bytes()}; }
    std::size_t bytes() const;

    // Writes a frame's input into one of two places; true if a tool is active. The other
    // copies them to the device, in stream order: until that is over the place must not be used
    // again.
    bool write_input(const Setup& setup, const Motion& motion, double duration, int slot);
    void send_input(int slot, cudaStream_t stream) const;

    std::vector<Particle<double>> particles() const;
    std::vector<Vec3<double>> places_in(Vec3<double> low, Vec3<double> high) const;
    std::vector<float> depths(cudaStream_t stream) const;       // of penetration(), by id [m]
    std::vector<float4> velocities(cudaStream_t stream) const;  // of velocities(), by id [m/s]
    void set_sides(const std::vector<Particle<double>>& particles) const;
    // The particles, how long blocks have been at rest, and how clay slides; put back into a store
    // that has room for them, the same box of nodes and the same particles on `side`.
    std::shared_ptr<DeviceState> state(int side, cudaStream_t stream) const;
    void put_back(const DeviceState& state, int side, cudaStream_t stream) const;
    // In plain values: ids in the order that particles lie in, quiet blocks.
    std::vector<int> order(int side) const;
    std::vector<int> quiet() const { return box.quiet.downloaded(); }
    // Clears both grids, whatever they hold.
    void clear_grids() const;
    void set_clock(const Clock& clock) const;
    Clock clock(cudaStream_t stream = nullptr) const;  // when all of the stream is done
    // Stores more nodes beyond the ends that clay has come to; views() are others then, and the
    // grids clear. Throws std::runtime_error where the device has not enough memory, and leaves
    // all as it is.
    void grow();

    // Edits (edit.cu), between frames. Views and features may be others afterwards.
    // What follows from materials, gravity and walls; from tools.
    void set_rules(const SceneState& rules);
    void set_tools(const SceneState& rules);
    // Stores at least the nodes that particles between these places reach.
    void hold(Vec3<float> low, Vec3<float> high);
    void set_box(const Lattice<float>& box);
    // Of the particles that lie on `side`; all lie on side 0 afterwards. Stores their nodes.
    void append(Clays clays, const std::vector<int>& objects, int side, cudaStream_t stream);
    // All of objects that are marked; so many are left.
    void erase(const std::vector<char>& objects, long left, int side, cudaStream_t stream);
    void arrange_as_new(const Extent& around, int side, cudaStream_t stream);
    // Makes room for so many particles, and forgets those that there are.
    void resize(int count);
    void upload(const std::vector<Particle<double>>& particles, const std::vector<int>& order);
    void set_quiet(const std::vector<int>& quiet) const;
    // Clay that slid along walls when the last substep ended; sliding clay begins anew.
    std::vector<SlidingNode> sliding_now(int done) const;
    void slide_on(const std::vector<SlidingNode>& nodes, int done) const;
    void forget_sliding(cudaStream_t stream) const;
    // Of an object, as it will be after a motion; or of all.
    Extent extent(int object, const RigidMotion<double>& motion, int side,
                  cudaStream_t stream) const;
    int count() const { return all.particles[0].count; }
    const std::shared_ptr<Pool>& snapshot_pool() const { return pool; }

    DeviceArray<float4> rows;  // row_places(), or more
    NodeArrays box;
    DeviceArray<int> ids[2];

  private:
    void point();
    void point_at_tools(const Setup& setup);
    void set_features(const Features& features);
    void set_count(int count);
    void reserve_runs();
    void reserve_scratch(int count);
    void reserve_others(std::size_t count);
    void swap_in(int count);
    std::vector<float4> rows_on(int side) const;

    DeviceArray<Material<float>> materials;
    DeviceArray<Binding<float>> bindings;
    DeviceArray<Primitive> primitives;
    DeviceArray<Sphere<float>> spheres[2];
    DeviceArray<Shape<float>> shapes[2], mid_frame;
    DeviceArray<float> travel;
    DeviceArray<unsigned> run_listed;
    DeviceArray<int> runs, in_line[2];
    DeviceArray<Sliding<float>> sliding;
    DeviceArray<Clock> clocks;
    DeviceArray<FrameInput> input;
    DeviceArray<unsigned char> scratch, near_runs;
    DeviceArray<Extent> found;
    // Where an edit puts the particles that it leaves; then the two are swapped.
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
