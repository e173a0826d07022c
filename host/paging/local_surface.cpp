#include "host/paging/local_surface.h"

#include <algorithm>
#include <tuple>

#include "host/base/parallel.h"
#include "host/paging/patches.h"

namespace knead {
namespace {

int corner_at(int x, int y, int z)
{
    return x + CubeHeights::corners * (y + CubeHeights::corners * z);
}

}  // namespace

std::vector<SurfacePatch> surface_patches(const std::vector<Vec3<double>>& centres,
                                          const std::vector<Vec3<double>>& normals, double edge)
{
    const Patches of = patches(centres, edge);
    std::vector<SurfacePatch> made;
    for (const Patch& p : of.all) made.push_back({p.mean, {0, 0, 0}, p.count});
    for (std::size_t i = 0; i < normals.size(); ++i)
        made[of.of[i]].n = made[of.of[i]].n + normals[i];
    for (std::size_t k = 0; k < made.size(); ++k) {
        Vec3<double>& n = made[k].n;
        const double size = length(n);
        n = size > 0 ? (1 / size) * n : normals[of.all[k].first];
    }
    return made;
}

LocalSurface::LocalSurface(const std::vector<SurfacePatch>& of, double depth, double width)
    : patches(of), far(depth + width), wide(width)
{
    for (const SurfacePatch& p : patches) middles.push_back(p.x);
    cells.emplace(middles, width);
}

// Searches in growing boxes: most points are near the surface.
double LocalSurface::nearest_squared(Vec3<double> at) const
{
    double nearest = far * far;
    for (double reach = wide;; reach = min(2 * reach, far)) {
        cells->each_near(at, {reach, reach, reach}, [&](std::uint32_t j) {
            const Vec3<double> d = at - middles[j];
            nearest = min(nearest, dot(d, d));
        });
        if (nearest <= reach * reach || reach >= far) return nearest;
    }
}

std::optional<double> LocalSurface::height(Vec3<double> at) const
{
    const double nearest = nearest_squared(at);
    if (nearest >= far * far) return {};
    const double reach = std::sqrt(nearest) + wide;
    double sum = 0, weight = 0;
    cells->each_near(at, {reach, reach, reach}, [&](std::uint32_t j) {
        const SurfacePatch& p = patches[j];
        const Vec3<double> d = at - p.x;
        const double w = p.count * (1 - dot(d, d) / (reach * reach));
        if (w > 0) sum += w * dot(d, p.n), weight += w;
    });
    const double h = sum / weight;
    if (nearest - h * h > wide * wide) return {};  // beyond the surface's edge
    return h;
}

std::vector<CubeHeights> CubeHeights::of(const LocalSurface& surface,
                                         const std::vector<Cubes::Key>& cubes, double edge)
{
    std::vector<CubeHeights> all;
    std::vector<Cubes::Key> places;
    constexpr int each = int(std::tuple_size_v<Corners>);
    for (const Cubes::Key key : cubes) {
        all.push_back(CubeHeights(surface, Cubes::at(key), edge));
        for (int k = 0; k < each; ++k) places.push_back(Cubes::key(all.back().first + corner(k)));
    }
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    std::vector<std::optional<double>> found(places.size());
    const int count = int(places.size()), cube_count = int(cubes.size());
    parallel_for(count, LoopOptions{.chunk = 8}, [&](int k) {
        const Int3 at = Cubes::at(places[std::size_t(k)]);
        found[std::size_t(k)] =
            surface.height(edge / parts * Vec3<double>{double(at.x), double(at.y), double(at.z)});
    });
    parallel_for(cube_count, [&](int c) {
        CubeHeights& cube = all[std::size_t(c)];
        for (int k = 0; k < each; ++k) {
            const auto at =
                std::lower_bound(places.begin(), places.end(), Cubes::key(cube.first + corner(k)));
            cube.heights[std::size_t(k)] = found[std::size_t(at - places.begin())];
        }
    });
    return all;
}

std::optional<double> CubeHeights::height(Vec3<double> at) const
{
    const Vec3<double> r =
        (1 / step) * at - Vec3<double>{double(first.x), double(first.y), double(first.z)};
    const auto part = [](double along) { return int(clamp(along, 0.0, parts - 0.5)); };
    const int x = part(r.x), y = part(r.y), z = part(r.z);
    const auto share = [](double along, int from) { return clamp(along - from, 0.0, 1.0); };
    const Vec3<double> t = {share(r.x, x), share(r.y, y), share(r.z, z)};
    double sum = 0, least = 1e30;
    int known = 0;
    for (int k = 0; k < 8; ++k) {
        const int i = k & 1, j = k >> 1 & 1, l = k >> 2;
        const std::optional<double>& h = heights[std::size_t(corner_at(x + i, y + j, z + l))];
        if (!h) continue;
        ++known, least = min(least, *h);
        sum += (i ? t.x : 1 - t.x) * (j ? t.y : 1 - t.y) * (l ? t.z : 1 - t.z) * *h;
    }
    if (known == 0) return {};
    if (known < 8 && least > 2 * step) return least;  // far above
    if (known < 8 || std::abs(sum) < 0.35 * step) return surface->height(at);
    return sum;
}

}  // namespace knead
