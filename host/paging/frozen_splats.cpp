#include "host/paging/frozen_splats.h"

#include <algorithm>

#include "host/base/parallel.h"

namespace knead {
namespace {

Vec3<double> least_axis(const Sym3<double>& spread)
{
    const Eigen<double> e = eigen(spread);
    if (e.value.z < e.value.x && e.value.z < e.value.y) return e.axes.c;
    return e.value.y < e.value.x ? e.axes.b : e.axes.a;
}

// The axis, oriented towards the box with the nearest centre.
Vec3<double> outward(Vec3<double> axis, Vec3<double> from, const Boxes& boxes)
{
    double nearest = 1e300, side = 1;
    for (const Box3<double>& box : boxes) {
        const Vec3<double> to = centre(box) - from;
        if (dot(to, to) < nearest) nearest = dot(to, to), side = dot(to, axis);
    }
    return side < 0 ? -axis : axis;
}

bool none(Vec3<float> normal) { return dot(normal, normal) == 0; }

std::vector<Vec3<double>> centres_of(const std::vector<std::uint32_t>& slots,
                                     const SplatCloud& cloud)
{
    std::vector<Vec3<double>> x;
    x.reserve(slots.size());
    for (const std::uint32_t i : slots) x.push_back(cast<double>(cloud.centre[i]));
    return x;
}

// Normals of patches, fitted to the neighbouring patches.
struct NormalsAround {
    const SplatCloud& cloud;
    const Boxes& hands;
    double reach;  // [m]
    std::vector<Patch> patches;

    // Normal of patch `of`, whose splats are among `slots`.
    Vec3<float> at(const Patch& of, const std::vector<std::uint32_t>& slots,
                   const Cells& cells) const
    {
        Vec3<double> sum{};
        Sym3<double> square{};
        double count = 0;
        cells.each_near(of.mean, {reach, reach, reach}, [&](std::uint32_t j) {
            const Patch& p = patches[j];
            const Vec3<double> d = p.mean - of.mean;
            if (dot(d, d) > reach * reach) return;
            sum = sum + p.count * d, count += p.count;
            square = square + p.spread + squared(d, p.count);
        });
        Sym3<double> spread = square + squared(sum, -1 / count);
        if (count < 6) {  // too few: the splat's own
            const std::size_t i = slots[of.first];
            spread = covariance(
                Ellipsoid<double>{cast<double>(cloud.rotation[i]), cast<double>(cloud.scale[i])});
        }
        return cast<float>(outward(least_axis(spread), of.mean, hands));
    }
};

}  // namespace

void FrozenSplats::put(std::uint32_t slot, Vec3<double> x)
{
    Cube& cube = all[cubes.key_of(x)];
    cube.slots.push_back(slot), cube.known = false;
}

void FrozenSplats::remove(std::vector<std::uint32_t> slots, const SplatCloud& cloud)
{
    std::sort(slots.begin(), slots.end());
    std::vector<Cubes::Key> keys;
    keys.reserve(slots.size());
    for (const std::uint32_t i : slots) keys.push_back(cubes.key_of(cast<double>(cloud.centre[i])));
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    for (const Cubes::Key key : keys) {
        const auto found = all.find(key);
        if (found == all.end()) continue;
        found->second.known = false;
        std::erase_if(found->second.slots, [&](std::uint32_t i) {
            return std::binary_search(slots.begin(), slots.end(), i);
        });
    }
}

void FrozenSplats::touch(Cubes::Key cube)
{
    if (const auto found = all.find(cube); found != all.end()) found->second.known = false;
}

const std::vector<std::uint32_t>& FrozenSplats::in(Cubes::Key cube) const
{
    static const std::vector<std::uint32_t> empty;
    const auto found = all.find(cube);
    return found == all.end() ? empty : found->second.slots;
}

std::vector<FrozenSplats::Cube*> FrozenSplats::there(const std::vector<Cubes::Key>& at)
{
    std::vector<Cube*> cubes_there;
    for (const Cubes::Key key : at)
        if (const auto found = all.find(key); found != all.end() && !found->second.slots.empty())
            cubes_there.push_back(&found->second);
    return cubes_there;
}

void FrozenSplats::fit_patches(const std::vector<Cubes::Key>& at, const SplatCloud& cloud,
                               std::vector<Vec3<float>>& normal, const Boxes& hands)
{
    const std::vector<Cube*> near = there(at);
    std::vector<Cube*> fresh;
    std::copy_if(near.begin(), near.end(), std::back_inserter(fresh),
                 [](const Cube* cube) { return !cube->known; });
    if (fresh.empty()) return;
    const int count = int(fresh.size());
    std::vector<Patches> fine(fresh.size());
    parallel_for(count, LoopOptions{.chunk = 1}, [&](int k) {
        Cube& cube = *fresh[std::size_t(k)];
        std::sort(cube.slots.begin(), cube.slots.end());
        fine[std::size_t(k)] = patches(centres_of(cube.slots, cloud), dx / 2);
        cube.patches = fine[std::size_t(k)].all;
    });
    NormalsAround around{cloud, hands, 2.5 * dx, {}};
    for (const Cube* cube : near)
        around.patches.insert(around.patches.end(), cube->patches.begin(), cube->patches.end());
    std::vector<Vec3<double>> middles;
    for (const Patch& p : around.patches) middles.push_back(p.mean);
    const Cells cells(middles, around.reach);
    parallel_for(count, LoopOptions{.chunk = 1}, [&](int k) {
        Cube& cube = *fresh[std::size_t(k)];
        const Patches& own = fine[std::size_t(k)];
        std::vector<Vec3<float>> of_patch(own.all.size(), {0, 0, 0});
        std::vector<Vec3<double>> of_slots;
        for (std::size_t s = 0; s < cube.slots.size(); ++s) {
            const std::uint32_t i = cube.slots[s], patch = own.of[s];
            if (none(normal[i])) {
                Vec3<float>& n = of_patch[patch];
                if (none(n)) n = around.at(own.all[patch], cube.slots, cells);
                normal[i] = n;
            }
            of_slots.push_back(cast<double>(normal[i]));
        }
        cube.surface = surface_patches(centres_of(cube.slots, cloud), of_slots, dx);
        cube.known = true;
    });
}

std::vector<SurfacePatch> FrozenSplats::surface(const std::vector<Cubes::Key>& at) const
{
    std::vector<SurfacePatch> found;
    for (const Cubes::Key key : at) {
        const auto cube = all.find(key);
        if (cube == all.end() || cube->second.slots.empty()) continue;
        found.insert(found.end(), cube->second.surface.begin(), cube->second.surface.end());
    }
    return found;
}

}  // namespace knead
