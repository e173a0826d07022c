// Edits of particles on the device, between two frames: the kernels of edit.h.
#pragma once
#include <bit>

#include "cuda/mpm/edit.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Selects all objects.
constexpr int every_object = -1;

// The fastest and the stiffest of some particles and their bounding box, in the encoding of atomics
// (ordered.cuh).
struct Extent {
    Peak peak{};
    int low[3] = {0x7f7fffff, 0x7f7fffff, 0x7f7fffff};
    int high[3] = {~0x7f7fffff, ~0x7f7fffff, ~0x7f7fffff};  // [m]

    bool empty() const { return low[0] > high[0]; }
    Vec3<float> lowest() const { return place(low); }
    Vec3<float> highest() const { return place(high); }

  private:
    static Vec3<float> place(const int (&key)[3])
    {
        const auto at = [](int k) { return std::bit_cast<float>(k < 0 ? k ^ 0x7fffffff : k); };
        return {at(key[0]), at(key[1]), at(key[2])};
    }
};

// Extent of an object's particles after `motion`. Precondition: `to` holds Extent{}.
void extent(const ParticleView& particles, const Materials& materials, int object,
            const RigidMotion<double>& motion, Extent* to, cudaStream_t stream);
void move(const ParticleView& particles, int object, const RigidMotion<double>& motion,
          cudaStream_t stream);
void change_law(const ParticleView& particles, int object, Plasticity from, Plasticity to,
                cudaStream_t stream);
// Resets the rest counters of the blocks that contain an object's particles.
void wake(const ParticleView& particles, int object, const Lattice<float>& lattice, int* quiet,
          cudaStream_t stream);
// Copies all particles except those of objects marked in `gone`; keeps their order and makes ids
// contiguous. `places` holds twice the number of particles; `scratch` holds
// keep_scratch_bytes(count).
std::size_t keep_scratch_bytes(int count);
void keep_others(const ParticleView& from, const char* gone, const ParticleView& to, int* places,
                 void* scratch, std::size_t scratch_bytes, cudaStream_t stream);
// Continues restored Sliding records, saved after `then` substeps, at the clock's current substep.
void slide_on(Sliding<float>* all, int count, const int* then, const Clock* clock,
              cudaStream_t stream);
// Clay without velocities as planes of 32-bit words by id, `count` words each: x y z, e.xx yy zz xy
// xz yz, k, object, label.
constexpr int plane_words = 12;
void to_planes(const ConstParticleView& from, float* planes, cudaStream_t stream);
// Particles at rest, in order of id, from such planes. These may lie in `to` behind its first four
// rows.
void from_planes(const float* planes, const ParticleView& to, cudaStream_t stream);
// Copies all particles in order of id.
void order_by_id(const ParticleView& from, const ParticleView& to, cudaStream_t stream);

}  // namespace knead::gpu
