// Gaussians on the device: three rows of 16 bytes and three words each, and their stage of a
// substep. They keep the order that they are given, which the host makes that of the nodes around
// them when they are attached: neighbours of an object stay neighbours while it is kneaded, so no
// substep and no frame pays for a sort.
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
    int *objects, *ids;  // whose each is, and its place in the order of attaching
    int count, room;
    const int* live;  // the count, where a captured kernel finds it: it may change behind its back

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
    // All of one, in one piece of memory.
    static constexpr std::size_t bytes_each = gaussian_rows * sizeof(float4) + 3 * sizeof(int);
};
// Lays out room for so many in memory of room * bytes_each.
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

// For who draws them: in the order of attaching, as the last frame or edit left them. What is
// launched on the stream finds them there.
struct MovedGaussians {
    static constexpr int floats_each = 12;  // x, then the columns of F
    const float* rows;
    int count;
    cudaStream_t stream;
};
void arrange(const GaussianView& gaussians, float* rows, cudaStream_t stream);

// The Gaussians' stage, after grid in every follow_every-th substep of a frame, before or after g2p
// is the same; and `at_end`, after the frame's last g2p, for what is left.
void deform(const Views& views, const GaussianView& splats, float per_mass,
            const Features& features, bool at_end, cudaStream_t stream);
// Those of an object, as part of a rigid body.
void move(const GaussianView& splats, int object, const RigidMotion<double>& motion,
          cudaStream_t stream);
// The box around them after that; `to` holds Extent{} before.
void extent(const GaussianView& splats, int object, const RigidMotion<double>& motion, Extent* to,
            cudaStream_t stream);

// Edits as of GaussianEdits, of Gaussians for which there is room: they follow the first `count`.
// `places` is for as many as there are Gaussians, or particles.
void split(const GaussianView& splats, const GaussianSplit* splits, int count, int* places,
           const WallOptions& walls, cudaStream_t stream);
void add_beside(const GaussianView& splats, const ParticleView& particles,
                const GaussianBeside* added, int count, int* places, const WallOptions& walls,
                cudaStream_t stream);
void place(const GaussianView& splats, const GaussianPlace* placed, int count, cudaStream_t stream);

// Those stay whose objects are not marked in `gone`. `places` has room for 2 (count + 1): where
// each of them comes, by place and then by id; each half ends with how many there are. `scratch` is
// for keep_scratch_bytes(count + 1).
void choose(const GaussianView& splats, const char* gone, int* places, void* scratch,
            std::size_t scratch_bytes, cudaStream_t stream);
// These, in their order, with ids that leave no gap.
void copy_chosen(const GaussianView& from, const char* gone, const GaussianView& to,
                 const int* places, cudaStream_t stream);

}  // namespace knead::gpu
