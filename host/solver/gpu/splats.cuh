// The Gaussians of a solver on the device. set() uploads all of them, sorted on the host; edit()
// appends.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "cuda/device/device_array.cuh"
#include "cuda/splats/deform.cuh"
#include "host/solver/gpu/state.cuh"

namespace knead::gpu {

class Splats {
  public:
    int count() const { return view_.count; }
    const GaussianView& view() const { return view_; }
    std::size_t bytes() const { return memory.bytes() + other.bytes() + drawn.bytes(); }
    const MovedGaussians& moved() const { return moved_; }

    // All Gaussians in the order of attachment; stored on the device by base node.
    // Waits for the copy; work on streams that uses the old ones must have ended.
    template <class R>
    void set(const std::vector<Gaussian<R>>& all, const Lattice<float>& lattice);
    std::vector<Gaussian<double>> all() const;
    // `particles`: those that GaussianEdits::added refers to. Returns true if the view captured by
    // graphs is invalid.
    bool edit(const GaussianEdits& edits, const ParticleView& particles, const WallOptions& walls,
              cudaStream_t stream);
    // Removes the Gaussians of marked objects; the others keep their order. Invalidates the view
    // captured by graphs.
    void erase(const std::vector<char>& objects, cudaStream_t stream);
    // Updates moved(), in stream order.
    void show(cudaStream_t stream);
    // Bounding box of an object's Gaussians after a motion.
    Extent extent(int object, const RigidMotion<double>& motion, cudaStream_t stream) const;

    std::shared_ptr<GaussianState> state(std::shared_ptr<Pool> pool, cudaStream_t stream) const;
    void put_back(const GaussianState& state, cudaStream_t stream);
    // Precondition: the same count.
    void copy_back(const GaussianState& state, cudaStream_t stream) const;

  private:
    void reserve(int count, int room);
    void set_count(int count, cudaStream_t stream);
    void make_room(int count, cudaStream_t stream);
    DeviceArray<unsigned char> memory, other;  // current and previous view, with spare capacity
    DeviceArray<unsigned char> sums;           // scratch
    DeviceArray<char> gone;                    // by object
    DeviceArray<int> live{1}, places;
    DeviceArray<GaussianSplit> splits;
    DeviceArray<GaussianBeside> added;
    DeviceArray<GaussianPlace> placed;
    GaussianView view_{};
    DeviceArray<float> drawn;
    MovedGaussians moved_{};
    // returned by state() if the capacity is 0, without CUDA calls
    std::shared_ptr<GaussianState> none = std::make_shared<GaussianState>();
};

// Host copy in the order of attachment, of memory laid out for `room` Gaussians. Precondition: the
// memory is written. Waits for the copy on the stream.
template <class R>
std::vector<Gaussian<R>> downloaded(const void* memory, int count, int room, cudaStream_t stream);

// Whether kernels captured with one view may run with the other.
inline bool same_view(const GaussianView& a, const GaussianView& b)
{
    return a.rows == b.rows && a.room == b.room && (a.count > 0) == (b.count > 0);
}

// The Gaussians of these objects; likewise.
SomeGaussians some_of(const GaussianState& state, std::span<const int> objects,
                      cudaStream_t stream);

}  // namespace knead::gpu
