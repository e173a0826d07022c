// Gaussians on the device: three rows of 16 bytes and three words each, and their stage of a
// substep. When they are attached, the host orders them by the nodes around them; this order is
// kept, because neighbours stay neighbours while clay is kneaded. So no sort is needed.
#pragma once
#include <vector_types.h>

#include <bit>

#include "cuda/mpm/edit.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/splats/deform.h"

namespace knead::gpu {

constexpr int gaussian_rows = 3;
struct GaussianView {
    float4* rows;     // gaussian_rows * room: (x, F.a.x), (F.a.y F.a.z F.b.x F.b.y), (F.b.z, F.c)
    unsigned* sides;  // room each: Gaussian::sides
    int *objects, *ids;  // object of each; its index in the order of attaching
    int count, room;
    const int* live;  // the count in device memory, for captured kernels: it may change after the
                      // capture

    HD float4& row(int r, int i) const { return rows[std::size_t(r) * std::size_t(room) + i]; }
    HD void load_place(int i, Gaussian<float>& g) const
    {
        const float4 a = row(0, i);
        g.x = {a.x, a.y, a.z}, g.F.a.x = a.w;
    }
    HD void load_rest(int i, Gaussian<float>& g) const
    {
        const float4 b = row(1, i), c = row(2, i);
        g.F = {{g.F.a.x, b.x, b.y}, {b.z, b.w, c.x}, {c.y, c.z, c.w}};
    }
    HD Gaussian<float> load(int i) const
    {
        Gaussian<float> g{};
        load_place(i, g), load_rest(i, g);
        return g;
    }
    HD void store_place(int i, const Gaussian<float>& g) const
    {
        row(0, i) = {g.x.x, g.x.y, g.x.z, g.F.a.x};
    }
    HD void store(int i, const Gaussian<float>& g) const
    {
        store_place(i, g);
        row(1, i) = {g.F.a.y, g.F.a.z, g.F.b.x, g.F.b.y};
        row(2, i) = {g.F.b.z, g.F.c.x, g.F.c.y, g.F.c.z};
    }
    // Bytes per Gaussian.
    static constexpr std::size_t bytes_each = gaussian_rows * sizeof(float4) + 3 * sizeof(int);
};
// Lays out `room` Gaussians in memory of room * bytes_each.
inline GaussianView gaussians_in(void* memory, int count, int room, const int* live = nullptr)
{
    auto* const rows = static_cast<float4*>(memory);
    auto* const words =
        reinterpret_cast<int*>(rows + std::size_t(gaussian_rows) * std::size_t(room));
    return {rows,         reinterpret_cast<unsigned*>(words),
            words + room, words + 2 * std::size_t(room),
            count,        room,
            live};
}

// For rendering: in the order of attaching, as of the last frame or edit; valid for work launched
// on the stream.
struct MovedGaussians {
    static constexpr int floats_each = 12;  // x, then the columns of F
    const float* rows;
    int count;
    cudaStream_t stream;
};
void arrange(const GaussianView& gaussians, float* rows, cudaStream_t stream);

// Stage of the Gaussians: after grid in every follow_every-th substep of a frame, before or after
// g2p alike; and with `at_end` after the frame's last g2p, for the remainder.
void deform(const Views& views, const GaussianView& splats, float per_mass,
            const Features& features, bool at_end, cudaStream_t stream);
// Moves an object's Gaussians as part of a rigid body.
void move(const GaussianView& splats, int object, const RigidMotion<double>& motion,
          cudaStream_t stream);
// Their bounding box after that motion. Precondition: `to` holds Extent{}.
void extent(const GaussianView& splats, int object, const RigidMotion<double>& motion, Extent* to,
            cudaStream_t stream);

// Edits of GaussianEdits. Precondition: room for the new Gaussians, which follow the first `count`.
// `places` has one element per Gaussian or per particle.
void split(const GaussianView& splats, const GaussianSplit* splits, int count, int* places,
           const WallOptions& walls, cudaStream_t stream);
void add_beside(const GaussianView& splats, const ParticleView& particles,
                const GaussianBeside* added, int count, int* places, const WallOptions& walls,
                cudaStream_t stream);
void place(const GaussianView& splats, const GaussianPlace* placed, int count, cudaStream_t stream);

// Selects the Gaussians whose objects are not marked in `gone`. `places` has 2 (count + 1)
// elements: the new index of each, by index and then by id; each half ends with their number.
// `scratch` has keep_scratch_bytes(count + 1).
void choose(const GaussianView& splats, const char* gone, int* places, void* scratch,
            std::size_t scratch_bytes, cudaStream_t stream);
// Copies the selected Gaussians in order, with contiguous ids.
void copy_chosen(const GaussianView& from, const char* gone, const GaussianView& to,
                 const int* places, cudaStream_t stream);

}  // namespace knead::gpu
