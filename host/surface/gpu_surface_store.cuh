// All device memory of one scene's surfaces, and the view of it for kernels.
#pragma once
#include <map>

#include "cuda/device/device_array.cuh"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/surface/surface.cuh"
#include "host/surface/gpu_surface.h"

namespace knead::gpu {

// The particles of one category.
struct Kind {
    float volume = 0;   // of the largest at rest [m^3]
    double amount = 0;  // of all [nodes full]
};

// Throws as GpuSurface does.
class SurfaceStore {
  public:
    SurfaceStore(const std::vector<Particle<double>>& particles,
                 const std::vector<Material<double>>& materials, const SurfaceOptions& given,
                 SurfaceRoom room);

    // serves(): whether each category of these materials has a layer, with the scale that a new
    // store would give it. set_materials() sets the contribution of each material.
    bool serves(const std::vector<Material<double>>& materials) const;
    void set_materials(const std::vector<Material<double>>& materials);
    // Reallocates the mesh buffers; pointers change.
    void reserve(SurfaceRoom room);
    std::size_t bytes() const;

    SurfaceOptions options;
    std::map<int, Kind> kinds;  // by category
    int rounds = 1;             // smoothing rounds
    SurfaceView view{};
    ScanSpace space{};
    DeviceArray<float> densities;  // for all rounds
    DeviceArray<float> past;       // SurfaceOptions::moving: density of the previous surface
    DeviceArray<int> past_valid;
    DeviceArray<unsigned long long> before;
    DeviceArray<DrawCommand> draws;
    DeviceArray<SurfaceErrors> errors;
    DeviceArray<Progress> progress;
    DeviceArray<int> active;

  private:
    void sort_out(const std::vector<Particle<double>>& particles,
                  const std::vector<Material<double>>& materials);
    float cell() const;  // [m^3]
    float volume(const Material<double>& material) const;
    CategoryScale scale_of(float largest) const;
    void allocate();

    double amount = 0;  // of all clay [nodes full]
    std::vector<CategoryScale> each_scale;
    DeviceArray<ObjectDeposit> object_deposits;
    DeviceArray<CategoryScale> scales;
    DeviceArray<unsigned> sums, marks, occupied, dirty;
    DeviceArray<int> blocks, skin, work, last_substep, ring, next, last;
    DeviceArray<unsigned long long> counts;
    DeviceArray<float4> vertices[2], normals;
    DeviceArray<Int3> triangles;
    DeviceArray<unsigned char> scratch;
};

}  // namespace knead::gpu
