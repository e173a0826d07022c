// Seeding of activated cubes with particles under the surface of the frozen splats.
#include <algorithm>
#include <cmath>

#include "host/base/parallel.h"
#include "host/paging/local_clay.h"
#include "host/paging/local_surface.h"
#include "host/scene/strata.h"

namespace knead {
namespace {

constexpr double too_near = 0.6;  // least distance to an existing particle [spacings]

}  // namespace

// Index of the first stratum of a cube along an axis.
int LocalClay::first_stratum(int cube) const
{
    return int(std::ceil(cube * tiling.edge / spacing - 0.5));
}

// Layer z of a cube: one particle in each stratum that is under the surface and has no particle
// nearby.
std::vector<Vec3<double>> LocalClay::seeds(Int3 cube, int z, const CubeHeights& heights,
                                           const Cells& there) const
{
    std::vector<Vec3<double>> all;
    for (int y = first_stratum(cube.y); y < first_stratum(cube.y + 1); ++y)
        for (int x = first_stratum(cube.x); x < first_stratum(cube.x + 1); ++x) {
            const Vec3<double> p = stratum_place(seed, 0, {x, y, z}, spacing, per_cell);
            if (!between_walls(p)) continue;
            const std::optional<double> h = heights.height(p);
            if (!h || *h > 0 || *h < -depth) continue;
            bool taken = false;
            const double near = too_near * spacing;
            there.each_near(p, {near, near, near}, [&](std::uint32_t j) {
                taken = taken || length(there.point(j) - p) < near;
            });
            if (!taken) all.push_back(p);
        }
    return all;
}

// Particles of each cube. On the critical path of a frame: threads work on layers, because most
// particles are in few cubes.
std::vector<std::vector<Particle<double>>> LocalClay::all_seeds(const std::vector<Key>& cubes,
                                                                const LocalSurface& surface,
                                                                const Cells& there) const
{
    const std::vector<CubeHeights> heights = CubeHeights::of(surface, cubes, tiling.edge);
    std::vector<std::pair<std::size_t, int>> layers;
    std::vector<std::size_t> first_layer;  // of each cube
    for (std::size_t k = 0; k < cubes.size(); ++k) {
        const int z = Cubes::at(cubes[k]).z;
        first_layer.push_back(layers.size());
        for (int s = first_stratum(z); s < first_stratum(z + 1); ++s) layers.emplace_back(k, s);
    }
    first_layer.push_back(layers.size());
    std::vector<std::vector<Vec3<double>>> of_layers(layers.size());
    std::vector<std::vector<Particle<double>>> all(cubes.size());
    const int count = int(layers.size());
    parallel_for(count, LoopOptions{.chunk = 1}, [&](int l) {
        const auto [k, z] = layers[std::size_t(l)];
        of_layers[std::size_t(l)] = seeds(Cubes::at(cubes[k]), z, heights[k], there);
    });
    const int cube_count = int(cubes.size());
    parallel_for(cube_count, LoopOptions{.chunk = 1}, [&](int k) {
        const auto cube = std::size_t(k);
        std::size_t sum = 0;
        for (std::size_t l = first_layer[cube]; l < first_layer[cube + 1]; ++l)
            sum += of_layers[l].size();
        all[cube].reserve(sum);
        for (std::size_t l = first_layer[cube]; l < first_layer[cube + 1]; ++l)
            for (const Vec3<double>& p : of_layers[l])
                all[cube].push_back({p, {}, {}, {}, 0, 0, 0});
    });
    return all;
}

// Adds the clay of these cubes, each as its own object; empty cubes are recorded as -1.
void LocalClay::add_clay(const std::vector<Key>& cubes,
                         std::vector<std::vector<Particle<double>>> found,
                         EditableSimulator& solver)
{
    std::vector<Key> filled;
    for (std::size_t k = 0; k < cubes.size(); ++k) {
        state_.clay[cubes[k]] = -1;
        if (!found[k].empty()) filled.push_back(cubes[k]);
    }
    std::erase_if(found, [](const auto& of_cube) { return of_cube.empty(); });
    if (filled.empty()) return;
    const std::vector<int> objects = solver.add_each(material, found);
    for (std::size_t k = 0; k < filled.size(); ++k) state_.clay[filled[k]] = objects[k];
    state_.objects = std::max(state_.objects, objects.back() + 1);
}

}  // namespace knead
