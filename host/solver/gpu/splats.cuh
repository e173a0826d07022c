// The Gaussians of a solver on the device. All come by way of the host, sorted there; some that
// join them are put behind.
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

    // All of them, in the order of attaching; on the device in that of their nodes.
    void set(const std::vector<Gaussian<double>>& all, const Lattice<float>& lattice);
    std::vector<Gaussian<double>> all() const;
    // Of these particles. True where what a graph was captured of is
    // somewhere else now.
    bool edit(const GaussianEdits& edits, const ParticleView& particles, const WallOptions& walls,
              cudaStream_t stream);
    // Those of objects that are marked go; the others keep their order. What a graph was captured
    // of is somewhere else then.
    void erase(const std::vector<char>& objects, cudaStream_t stream);
    // What moved() says is so from here on.
    void show(cudaStream_t stream);
    // The box around an object's, as they will be after a motion.
    Extent extent(int object, const RigidMotion<double>& motion, cudaStream_t stream) const;

    std::shared_ptr<GaussianState> state(std::shared_ptr<Pool> pool, cudaStream_t stream) const;
    void put_back(const GaussianState& state, cudaStream_t stream);
    // Of as many as there are.
    void copy_back(const GaussianState& state, cudaStream_t stream) const;
    // From there, once it is written.
    static std::vector<Gaussian<double>> downloaded(const unsigned char* from, int count, int room);

  private:
    void reserve(int count, int room);
    void set_count(int count, cudaStream_t stream);
    void make_room(int count, cudaStream_t stream);
    DeviceArray<unsigned char> memory, other;  // of view_, and more; of the view before
    DeviceArray<unsigned char> sums;           // scratch
    DeviceArray<char> gone;                    // by object
    DeviceArray<int> live{1}, places;
    DeviceArray<GaussianSplit> splits;
    DeviceArray<GaussianBeside> added;
    DeviceArray<GaussianPlace> placed;
    GaussianView view_{};
    DeviceArray<float> drawn;
    MovedGaussians moved_{};
    // What state() is where there is no room for any: no call of CUDA.
    std::shared_ptr<GaussianState> none = std::make_shared<GaussianState>();
};

// The Gaussians of these objects, once the state is written.
SomeGaussians some_of(const GaussianState& state, std::span<const int> objects);

}  // namespace knead::gpu
