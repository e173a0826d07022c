// Photographs show a surface from outside, so the visible side of a splat is the outer side of the
// solid. Light from all directions determines it for all splats at once; the visible splats become
// a layer of dipoles of unit strength, whose potential is the winding number. Derived in
// docs/method/splats.md.
#include "host/assets/solid.h"

#include <algorithm>
#include <array>

#include "cuda/math/box.h"
#include "cuda/mpm/stencil.h"
#include "host/assets/light.h"
#include "host/assets/poisson.h"
#include "host/assets/samples.h"
#include "host/base/errors.h"
#include "host/base/parallel.h"

namespace knead {
namespace {

using Indices = std::vector<std::uint32_t>;
constexpr double opaque = 6;         // minimum optical depth of the thinner parts of a surface
constexpr double max_depth = 12;     // per spacing
constexpr float dark = 0.005f;       // fraction of the sky below which light counts as leakage
constexpr double max_samples = 2e7;  // over all splats

// Bounding box of the ellipsoids of one standard deviation.
Box3<double> box_of(const SplatCloud& cloud, const Indices& kept)
{
    Box3<double> box = empty_box<double>();
    for (std::uint32_t i : kept) {
        const Sym3<double> c = covariance(
            Ellipsoid<double>{cast<double>(cloud.rotation[i]), cast<double>(cloud.scale[i])});
        const Vec3<double> x = cast<double>(cloud.centre[i]),
                           s{std::sqrt(c.xx), std::sqrt(c.yy), std::sqrt(c.zz)};
        grow(box, Box3<double>{x - s, x + s});
    }
    return box;
}

// Number of cells of edge h that contain a centre; h is at least 2^-20 of the box.
std::size_t occupied(const SplatCloud& cloud, const Indices& kept, const Box3<double>& box,
                     double h)
{
    std::vector<std::uint64_t> keys;
    keys.reserve(kept.size());
    for (std::uint32_t i : kept) {
        const Vec3<double> u = (1 / h) * (cast<double>(cloud.centre[i]) - box.low);
        keys.push_back(std::uint64_t(u.x) << 42 | std::uint64_t(u.y) << 21 | std::uint64_t(u.z));
    }
    std::sort(keys.begin(), keys.end());
    return std::size_t(std::unique(keys.begin(), keys.end()) - keys.begin());
}

// The finest spacing whose occupied cells contain 1.5 distinct centres on average, so that a
// surface covered by splines three cells wide has no gap; between the box's longest edge /
// max_cells and / 16.
double covering_spacing(const SplatCloud& cloud, const Indices& kept, const Box3<double>& box,
                        int max_cells)
{
    const double longest = longest_edge(box);
    const std::size_t different = occupied(cloud, kept, box, longest * 0x1p-20);
    double cells = max_cells;
    while (cells > 16 && 3 * occupied(cloud, kept, box, longest / cells) > 2 * different)
        cells /= 1.15;
    return longest / max(cells, 16.0);
}

// Grid with a margin for the potential to decay, and edges that multigrid can halve.
Grid grid_over(const Box3<double>& box, double h)
{
    const double margin = max(6 * h, longest_edge(box) / 6);
    Grid grid;
    grid.h = h;
    const auto nodes = [&](double length) {
        const int cells = int(std::ceil((length + 2 * margin) / h));
        return (cells + poisson_edge - 1) / poisson_edge * poisson_edge + 1;
    };
    const Vec3<double> edge = edges(box);
    grid.size = {nodes(edge.x), nodes(edge.y), nodes(edge.z)};
    const Vec3<double> room =
        h * Vec3<double>{grid.size.x - 1.0, grid.size.y - 1.0, grid.size.z - 1.0};
    grid.origin = box.low - 0.5 * (room - edge);
    return grid;
}

// Area occluded by a splat along its shortest axis: the integral of alpha exp(-r^2 / 2) over the
// plane [m^2]. Half axes are at least `floor`, a quarter of the median longest one.
double hidden_area(const SplatCloud& cloud, std::uint32_t i, double floor)
{
    const Vec3<float> s = cloud.scale[i];
    std::array<double, 3> a{max(double(s.x), floor), max(double(s.y), floor),
                            max(double(s.z), floor)};
    std::sort(a.begin(), a.end());
    return 2 * 3.14159265358979 * a[1] * a[2] * cloud.opacity[i];
}

// Extinction of the splats, per spacing, scaled so that three quarters of the nodes next to a
// centre belong to a surface of optical depth `opaque` or more: a photographed object is opaque,
// and the number of splats that cover a place is arbitrary.
std::vector<float> extinction(const SplatCloud& cloud, const Indices& kept, const Grid& grid)
{
    std::vector<float> sizes;
    for (std::uint32_t i : kept)
        sizes.push_back(max(cloud.scale[i].x, max(cloud.scale[i].y, cloud.scale[i].z)));
    std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2), sizes.end());
    const double typical = sizes[sizes.size() / 2], h = grid.h;
    const double floor = typical > 0 ? typical / 4 : h / 4;
    const int most = std::max(1, std::min(8, int(std::cbrt(max_samples / double(kept.size())))));

    std::vector<float> tau(grid.count());
    std::vector<char> beside(grid.count());
    for (std::uint32_t i : kept) {
        const double mass = hidden_area(cloud, i, floor) / (h * h);
        each_sample(cloud, i, h, most, [&](Vec3<double> x, double weight, double) {
            const Stencil<double> s = stencil(x - grid.origin, h);
            for_each_node(s, h, [&](Int3 step, double w, Vec3<double>) {
                const Int3 n = s.base + step;
                if (grid.within(n, 1)) tau[grid.at(n)] += float(mass * weight * w);
            });
        });
        const Vec3<double> u = grid.local(cast<double>(cloud.centre[i]));
        beside[grid.at({int(u.x + 0.5), int(u.y + 0.5), int(u.z + 0.5)})] = 1;
    }
    std::vector<float> depths;  // optical depth of a layer with 3/4 of its sum here
    for (std::size_t i = 0; i < tau.size(); ++i)
        if (beside[i]) depths.push_back(tau[i] / 0.75f);
    const auto quarter = depths.begin() + std::ptrdiff_t(depths.size() / 4);
    std::nth_element(depths.begin(), quarter, depths.end());
    const float gain = *quarter > 0 ? float(max(1.0, opaque / double(*quarter))) : 1.0f;
    for (float& t : tau) t = min(gain * t, float(max_depth));
    return tau;
}

float fade(float x, float low, float high)  // smooth step
{
    const float t = clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

Vec3<float> gradient(const Grid& grid, const std::vector<float>& f, std::size_t i)
{
    const std::size_t up = std::size_t(grid.size.x), out = up * grid.size.y;
    const float per = float(0.5 / grid.h);
    return {per * (f[i + 1] - f[i - 1]), per * (f[i + up] - f[i - up]),
            per * (f[i + out] - f[i - out])};
}

// Outward normal of the layer of splats around node n: the net pressure P of the light, rotated
// towards the direction across the layer, normal ~ J^2 P with J the sum of (grad tau)(grad tau)^T.
Vec3<float> normal_at(const Grid& grid, const std::vector<float>& tau, const Light& light, Int3 n)
{
    constexpr std::array<float, 5> weight{1, 4, 6, 4, 1};
    Vec3<float> pressed{};
    Sym3<float> J{};
    for (int k = 0; k < 125; ++k) {
        const Int3 d{k % 5, k / 5 % 5, k / 25};
        const std::size_t i = grid.at(n + d - Int3{2, 2, 2});
        const float w =
            weight[std::size_t(d.x)] * weight[std::size_t(d.y)] * weight[std::size_t(d.z)];
        const Vec3<float> g = gradient(grid, tau, i);
        pressed = pressed + w * light.pressure[i];
        J = J + w * Sym3<float>{g.x * g.x, g.y * g.y, g.z * g.z, g.x * g.y, g.x * g.z, g.y * g.z};
    }
    const float t = trace(J);
    const Mat3<float> across = full(t > 0 ? (1 / t) * J : isotropic(1.0f));
    const Vec3<float> v = -(across * (across * pressed));
    const float l = length(v);
    return l > 0 ? (1 / l) * v : Vec3<float>{};
}

// Target gradient of the indicator: through the visible layer it falls from 1 to 0 along the
// normal, in proportion to tau. Where the net pressure along the normal is below a few thousandths
// of that on an open surface, splats are inside and contribute nothing.
std::vector<Vec3<float>> dipoles(const Grid& grid, const std::vector<float>& tau,
                                 const Light& light)
{
    std::vector<Vec3<float>> v(grid.count());
    parallel_for(grid.size.z - 6, LoopOptions{.chunk = 1}, [&](int layer) {
        const int z = layer + 3;
        for (int y = 3; y < grid.size.y - 3; ++y)
            for (int x = 3; x < grid.size.x - 3; ++x) {
                const Int3 n{x, y, z};
                const std::size_t i = grid.at(n);
                if (!(tau[i] > 0)) continue;
                const Vec3<float> normal = normal_at(grid, tau, light, n);
                float thickness = 0, push = 0;
                for (int k = -4; k <= 4; ++k) {
                    const Vec3<double> at =
                        grid.position(n) + (k * grid.h / 2) * cast<double>(normal);
                    thickness += sampled(grid, tau, at);
                    push -= dot(sampled(grid, light.pressure, at), normal);
                }
                const float step = float(grid.h / 2);
                const float strength = fade(push * step, 0.001f, 0.003f);
                v[i] = (-strength * tau[i] / (thickness * step)) * normal;
            }
    });
    return v;
}

std::vector<float> divergence(const Grid& grid, const std::vector<Vec3<float>>& v)
{
    std::vector<float> f(grid.count());
    const std::size_t up = std::size_t(grid.size.x), out = up * grid.size.y;
    const float per = float(0.5 / grid.h);
    parallel_for(grid.size.z - 2, [&](int layer) {
        const int z = layer + 1;
        for (int y = 1; y < grid.size.y - 1; ++y)
            for (int x = 1; x < grid.size.x - 1; ++x) {
                const std::size_t i = grid.at({x, y, z});
                f[i] = per * (v[i + 1].x - v[i - 1].x + v[i + up].y - v[i - up].y + v[i + out].z -
                              v[i - out].z);
            }
    });
    return f;
}

// Isovalue at the visible splats: the mean of the indicator at their centres, weighted by their
// light.
float level_at(const SplatCloud& cloud, const Indices& kept, const Solid& solid)
{
    double sum = 0, weights = 0;
    for (std::uint32_t i : kept) {
        const double w = solid.lit[i];
        sum += w * sampled(solid.grid, solid.indicator, cast<double>(cloud.centre[i]));
        weights += w;
    }
    return weights > 0 ? float(clamp(sum / weights, 0.15, 0.7)) : 0.5f;
}

// Volumes from the fraction of each node's cube above the level, for an indicator extrapolated
// linearly by its gradient.
void measure(Solid& solid, const std::vector<float>& tau)
{
    const Grid grid{{}, 1, solid.grid.size};
    double inside = 0, unlit = 0, both = 0;
    for (std::size_t i = 0; i < grid.count(); ++i) {
        if (!grid.within(grid.node(i), 1)) continue;
        const float over = solid.indicator[i] - solid.level;
        const float slope = length(gradient(grid, solid.indicator, i));
        const double share = slope > 0 ? clamp(over / slope + 0.5f, 0.0f, 1.0f) : over > 0;
        inside += share;
        if (solid.seen[i] >= dark || tau[i] > 0) continue;
        unlit += 1;
        both += over > 0;
    }
    const double cube = std::pow(solid.grid.h, 3);
    solid.volume = cube * inside;
    solid.unlit = cube * unlit;
    solid.found = unlit > 0 ? both / unlit : 1;
}

// Maximum over two nodes to each side along each axis, one axis after the other.
void dilate(const Grid& grid, std::vector<float>& f)
{
    const std::array<std::ptrdiff_t, 3> step{1, grid.size.x,
                                             std::ptrdiff_t(grid.size.x) * grid.size.y};
    for (std::ptrdiff_t s : step) {
        const std::vector<float> before = f;
        for (std::ptrdiff_t i = 2 * s; i < std::ptrdiff_t(f.size()) - 2 * s; ++i)
            for (std::ptrdiff_t k : {-2 * s, -s, s, 2 * s})
                f[std::size_t(i)] = max(f[std::size_t(i)], before[std::size_t(i + k)]);
    }
}

// The skin: splats that receive at least `share` of the light of the best lit splat around them.
// The others lie below it.
Indices skin(const SplatCloud& cloud, const Indices& kept, const Grid& grid, const Light& light)
{
    constexpr float share = 0.05f;
    const auto node = [&](std::uint32_t i) {
        const Vec3<double> u = grid.local(cast<double>(cloud.centre[i]));
        return grid.at({int(u.x + 0.5), int(u.y + 0.5), int(u.z + 0.5)});
    };
    const auto seen = [&](std::uint32_t i) {
        return sampled(grid, light.seen, cast<double>(cloud.centre[i]));
    };
    std::vector<float> best(grid.count());
    for (std::uint32_t i : kept) best[node(i)] = max(best[node(i)], seen(i));
    dilate(grid, best);
    Indices all;
    for (std::uint32_t i : kept)
        if (seen(i) >= share * best[node(i)]) all.push_back(i);
    return all;
}

}  // namespace

bool Solid::visible(Vec3<double> x) const
{
    const double reach = 1.5 * grid.h;
    for (int k = -3; k <= 3; ++k) {
        const Vec3<double> step{std::abs(k) == 1 ? reach * k : 0,
                                std::abs(k) == 2 ? reach * k / 2 : 0,
                                std::abs(k) == 3 ? reach * k / 3 : 0};
        if (sampled(grid, seen, x + step) >= 0.1f) return true;
    }
    return false;
}

Solid find_solid(const SplatCloud& cloud, const Indices& kept, const SolidOptions& options)
{
    if (kept.empty()) throw InputError("expected splats of an object, found none");
    const Box3<double> box = box_of(cloud, kept);
    if (!(longest_edge(box) > 0) || !std::isfinite(longest_edge(box)))
        throw InputError("expected splats of an object, found all at one point");
    const double h = covering_spacing(cloud, kept, box, clamp(options.max_cells, 8, 320));
    Solid solid;
    solid.grid = grid_over(box, h);
    const Grid unit{{}, 1, solid.grid.size};  // lengths in spacings: no overflow
    std::vector<float> tau = extinction(cloud, kept, solid.grid);
    Light light = lit_from_all_sides(unit, tau, options.directions / 3);
    const Indices outer = skin(cloud, kept, solid.grid, light);
    tau = extinction(cloud, outer, solid.grid);
    light = lit_from_all_sides(unit, tau, options.directions);
    solid.indicator = solve_poisson(unit, divergence(unit, dipoles(unit, tau, light)));
    solid.seen = std::move(light.seen);
    solid.lit.assign(cloud.count(), 0);
    for (std::uint32_t i : kept)
        solid.lit[i] = sampled(solid.grid, solid.seen, cast<double>(cloud.centre[i]));
    solid.level = level_at(cloud, outer, solid);
    measure(solid, tau);
    return solid;
}

}  // namespace knead
