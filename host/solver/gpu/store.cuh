// All device memory of one simulation, allocated once, and the views of it that kernels take.
#pragma once
#include "cuda/device/device_array.cuh"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stages.cuh"
#include "host/solver/gpu/room.h"
#include "host/solver/substep.h"

namespace knead::gpu {

// The particles of a scene, and what is noted of blocks that lie still, on the host.
struct Saved {
    int side;
    std::vector<float4> rows;
    std::vector<int> ids, quiet;
};

// What there is for every node that is stored, or every block.
struct NodeArrays {
    NodeArrays() = default;
    NodeArrays(const Lattice<float>& lattice, const Features& features);
    static std::size_t bytes_for(const Lattice<float>& lattice, const Features& features);
    std::size_t bytes() const;

    DeviceArray<float4> nodes[2];
    DeviceArray<long long> sums[2];
    DeviceArray<int> marks, list[3];  // GridView
    DeviceArray<int> counts;          // SortSpace
    DeviceArray<bool> rim;
    DeviceArray<Mask> masks;
    DeviceArray<unsigned> fastest, reached;  // RestView, as those that follow
    DeviceArray<int> quiet, activity, free, guard, woken[2], changed;
    DeviceArray<int2> ranges;
};

// The device's form of a scene. Throws std::invalid_argument for one that does not hang together
// and std::runtime_error where the device has not enough memory.
class Store {
  public:
    explicit Store(const Setup& setup, Room room = {});

    Views views() const { return all; }
    Features features() const { return used; }
    SortSpace sort_space() const { return {box.counts.data(), scratch.data(), scratch.bytes()}; }
    std::size_t bytes() const;

    // Writes a frame's orders down, in one of two places; true if a tool is active. The other
    // copies them to the device, in stream order: until that is over the place must not be used
    // again.
    bool write_input(const Setup& setup, const Motion& motion, double duration, int slot);
    void send_input(int slot, cudaStream_t stream) const;

    std::vector<Particle<double>> particles() const;
    std::vector<float> depths(cudaStream_t stream) const;  // of penetration(), by id [m]
    void set_sides(const std::vector<Particle<double>>& particles) const;
    // For whoever lets them move, to put them back.
    Saved resume() const;
    void put_back(const Saved& resume) const;
    // Clears both grids, whatever they hold.
    void clear_grids() const;
    void set_clock(const Clock& clock) const;
    Clock clock(cudaStream_t stream = nullptr) const;  // when all of the stream is done
    // Stores more nodes beyond the ends that clay has come to; views() are others then, and the
    // grids clear. Throws std::runtime_error where the device has not enough memory, and leaves
    // all as it is.
    void grow();

    DeviceArray<float4> rows;  // row_places * count
    NodeArrays box;
    DeviceArray<int> ids[2];

  private:
    void allocate(const Setup& setup);
    void upload(const Setup& setup) const;
    void point();
    std::vector<float4> rows_on(int side) const;

    DeviceArray<Material<float>> materials;
    DeviceArray<Binding<float>> bindings;
    DeviceArray<Primitive> primitives;
    DeviceArray<Sphere<float>> spheres[2];
    DeviceArray<Shape<float>> shapes[2], amid;
    DeviceArray<float> travel;
    DeviceArray<unsigned> run_listed;
    DeviceArray<int> runs, in_line;
    DeviceArray<Clock> clocks;
    DeviceArray<FrameInput> input;
    DeviceArray<unsigned char> scratch;
    Pinned<FrameInput> next_input[2];
    Views all{};
    Features used;
    Room room;
};

}  // namespace knead::gpu
