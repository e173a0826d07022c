#include "host/assets/interior.h"

#include <array>
#include <numbers>

#include "cuda/math/box.h"
#include "cuda/mpm/stencil.h"
#include "host/base/parallel.h"
#include "host/scene/strata.h"

namespace knead {
namespace {

constexpr double jitter = 0.1;      // in spacings
constexpr double uncertain = 0.25;  // uncertainty of the surface, in spacings of the grid

std::array<std::ptrdiff_t, 6> neighbours(const Grid& grid)
{
    const std::ptrdiff_t up = grid.size.x, out = up * grid.size.y;
    return {-1, 1, -up, up, -out, out};
}

// Distance of a node from the smallest distances along the three axes, in spacings.
float eikonal(std::array<float, 3> a)
{
    std::sort(a.begin(), a.end());
    float d = a[0] + 1;
    if (d <= a[1]) return d;
    const float s2 = a[0] + a[1];
    d = (s2 + std::sqrt(max(2 - (a[0] - a[1]) * (a[0] - a[1]), 0.0f))) / 2;
    if (d <= a[2]) return d;
    const float s3 = s2 + a[2], q = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    return (s3 + std::sqrt(max(s3 * s3 - 3 * (q - 1), 0.0f))) / 3;
}

// Distance of a node next to the surface, from where the indicator crosses the level along the
// axes; -1: no crossing.
float distance_beside(const Solid& solid, std::size_t i, const std::array<std::ptrdiff_t, 6>& next)
{
    const float here = solid.indicator[i] - solid.level;
    float sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        float nearest = 0;  // inverse distance, in spacings
        for (std::size_t side = 0; side < 2; ++side) {
            const float there =
                solid.indicator[std::size_t(std::ptrdiff_t(i) + next[2 * axis + side])] -
                solid.level;
            if (there <= 0) nearest = max(nearest, (here - there) / max(here, 1e-6f));
        }
        sum += nearest * nearest;
    }
    return sum > 0 ? 1 / std::sqrt(sum) : -1;
}

}  // namespace

std::vector<float> depths(const Solid& solid)
{
    const Grid& grid = solid.grid;
    const auto next = neighbours(grid);
    const Int3 n = grid.size;
    const float far = float(n.x + n.y + n.z);
    std::vector<float> d(grid.count());
    std::vector<char> known(grid.count(), 1);
    for (int z = 1; z < n.z - 1; ++z)
        for (int y = 1; y < n.y - 1; ++y)
            for (int x = 1; x < n.x - 1; ++x) {
                const std::size_t i = grid.at({x, y, z});
                if (solid.indicator[i] <= solid.level) continue;
                const float beside = distance_beside(solid, i, next);
                known[i] = beside >= 0;
                d[i] = beside >= 0 ? beside : far;
            }
    for (int order = 0; order < 16; ++order)
        for (int k = 1; k < n.z - 1; ++k)
            for (int j = 1; j < n.y - 1; ++j)
                for (int l = 1; l < n.x - 1; ++l) {
                    const Int3 at{order & 1 ? n.x - 1 - l : l, order & 2 ? n.y - 1 - j : j,
                                  order & 4 ? n.z - 1 - k : k};
                    const std::size_t i = grid.at(at);
                    if (known[i]) continue;
                    std::array<float, 3> a;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        a[axis] = min(d[std::size_t(std::ptrdiff_t(i) + next[2 * axis])],
                                      d[std::size_t(std::ptrdiff_t(i) + next[2 * axis + 1])]);
                    d[i] = min(d[i], eikonal(a));
                }
    for (float& v : d) v *= float(grid.h);
    return d;
}

namespace {

enum Kind : char { empty, fixed, free_node };

struct Colours {
    std::vector<Vec3<float>> value;
    std::vector<char> kind;
    Box3<float> range;  // of the fixed values
};

// Colours of the visible splats at the nodes around them, weighted by the light that they receive.
Colours surface_colours(const SplatCloud& cloud, const std::vector<std::uint32_t>& kept,
                        const Solid& solid)
{
    const Grid& grid = solid.grid;
    const std::size_t stride = std::size_t(harmonics(cloud.degree));
    Colours c{std::vector<Vec3<float>>(grid.count()), std::vector<char>(grid.count()), {}};
    std::vector<float> weight(grid.count());
    for (std::uint32_t i : kept) {
        const Stencil<double> s = stencil(cast<double>(cloud.centre[i]) - grid.origin, grid.h);
        const double share = double(solid.lit[i]) * cloud.opacity[i];
        for_each_node(s, grid.h, [&](Int3 step, double w, Vec3<double>) {
            if (!grid.within(s.base + step, 1)) return;
            const std::size_t n = grid.at(s.base + step);
            c.value[n] = c.value[n] + float(share * w) * cloud.sh[i * stride];
            weight[n] += float(share * w);
        });
    }
    double sum = 0, count = 0;
    for (float w : weight) sum += w, count += w > 0;
    const float enough = count > 0 ? float(0.05 * sum / count) : 0;
    bool first = true;
    for (std::size_t i = 0; i < weight.size(); ++i) {
        if (weight[i] > 0 && weight[i] >= enough) {
            const Vec3<float> v = c.value[i] = (1 / weight[i]) * c.value[i];
            c.kind[i] = fixed;
            if (first) c.range = {v, v};
            grow(c.range, v);
            first = false;
        } else {
            c.value[i] = {};
            if (solid.indicator[i] > solid.level && grid.within(grid.node(i), 1))
                c.kind[i] = free_node;
        }
    }
    return c;
}

struct Mean {
    Vec3<float> sum{};
    int count = 0;
    void add(Vec3<float> v) { sum = sum + v, ++count; }
    Vec3<float> value() const { return (1 / float(count)) * sum; }
};

// Initial values, layer by layer inwards: the mean of the neighbours that already have a value.
void spread_inwards(const Grid& grid, Colours& c, std::vector<std::size_t> nodes,
                    const std::vector<float>& depth)
{
    std::sort(nodes.begin(), nodes.end(), [&](std::size_t a, std::size_t b) {
        return depth[a] != depth[b] ? depth[a] < depth[b] : a < b;
    });
    const auto next = neighbours(grid);
    std::vector<char> has(c.kind.size());
    for (std::size_t i = 0; i < has.size(); ++i) has[i] = c.kind[i] == fixed;
    const Vec3<float> middle = centre(c.range);
    for (std::size_t i : nodes) {
        Mean mean;
        for (std::ptrdiff_t d : next) {
            const std::size_t j = std::size_t(std::ptrdiff_t(i) + d);
            if (has[j]) mean.add(c.value[j]);
        }
        c.value[i] = mean.count ? mean.value() : middle;
        has[i] = 1;
    }
}

void relax(const Grid& grid, Colours& c, const std::vector<std::size_t>& nodes, float over)
{
    const auto next = neighbours(grid);
    parallel_for(nodes.size(), [&](std::size_t k) {
        const std::size_t i = nodes[k];
        Mean mean;
        for (std::ptrdiff_t d : next) {
            const std::size_t j = std::size_t(std::ptrdiff_t(i) + d);
            if (c.kind[j] != empty) mean.add(c.value[j]);
        }
        if (mean.count) c.value[i] = c.value[i] + over * (mean.value() - c.value[i]);
    });
}

// Sets two layers of empty nodes to the mean of their neighbours, for interpolation at the surface.
void pad(const Grid& grid, Colours& c)
{
    const auto next = neighbours(grid);
    for (int layer = 0; layer < 2; ++layer) {
        const std::vector<char> kind = c.kind;
        for (std::size_t i = 0; i < kind.size(); ++i) {
            if (kind[i] != empty || !grid.within(grid.node(i), 1)) continue;
            Mean mean;
            for (std::ptrdiff_t d : next) {
                const std::size_t j = std::size_t(std::ptrdiff_t(i) + d);
                if (kind[j] != empty) mean.add(c.value[j]);
            }
            if (mean.count) c.value[i] = mean.value(), c.kind[i] = fixed;
        }
    }
}

}  // namespace

std::vector<Vec3<float>> inner_colours(const SplatCloud& cloud,
                                       const std::vector<std::uint32_t>& kept, const Solid& solid,
                                       const std::vector<float>& depth)
{
    const Grid& grid = solid.grid;
    Colours c = surface_colours(cloud, kept, solid);
    std::vector<std::size_t> free_nodes;
    std::array<std::vector<std::size_t>, 2> by_parity;
    float deepest = 0;
    for (std::size_t i = 0; i < c.kind.size(); ++i) {
        if (c.kind[i] != free_node) continue;
        const Int3 n = grid.node(i);
        free_nodes.push_back(i);
        by_parity[std::size_t(n.x + n.y + n.z) & 1].push_back(i);
        deepest = max(deepest, depth[i]);
    }
    spread_inwards(grid, c, free_nodes, depth);
    // Optimal over-relaxation factor for a box as wide as the solid [Young 1954].
    const double width = 2 * deepest / grid.h + 2;
    const float over = float(2 / (1 + std::sin(std::numbers::pi / width)));
    for (int sweep = 0; sweep < int(3 * width); ++sweep)
        for (const std::vector<std::size_t>& nodes : by_parity) relax(grid, c, nodes, over);
    for (std::size_t i : free_nodes)
        c.value[i] = greater(c.range.low, lesser(c.range.high, c.value[i]));
    pad(grid, c);
    return std::move(c.value);
}

namespace {

// Calls use(cell) for the cells of edge h that may contain an inner node, in order.
template <class Use>
void each_cell(const Grid& grid, double h, Use&& use)
{
    const auto cells = [&](int nodes) { return int(std::ceil((nodes - 1) * grid.h / h)); };
    const Int3 n{cells(grid.size.x), cells(grid.size.y), cells(grid.size.z)};
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) use(Int3{x, y, z});
}

Interior at_spacing(const Solid& solid, const std::vector<float>& depth,
                    const InteriorOptions& options, double spacing)
{
    Interior all{{}, {}, spacing};
    const auto deep = [&](Vec3<double> x, double edge) {
        return sampled(solid.grid, depth, x) >=
               options.min_depth_in_half_axes * interior_half_axis * edge +
                   uncertain * solid.grid.h;
    };
    const auto centre = [&](Int3 cell, double edge) {
        return solid.grid.origin + edge * Vec3<double>{cell.x + 0.5, cell.y + 0.5, cell.z + 0.5};
    };
    const auto add = [&](Int3 cell, double edge, std::size_t level) {
        const Vec3<double> u = strata::hashed(options.seed, level, cell),
                           x = centre(cell, edge) +
                               jitter * edge * (u - Vec3<double>{0.5, 0.5, 0.5});
        if (!deep(x, edge)) return false;
        all.centre.push_back(x);
        all.half_axis.push_back(float(interior_half_axis * edge));
        return true;
    };
    each_cell(solid.grid, 2 * spacing, [&](Int3 cell) {
        if (all.centre.size() > options.max_count) return;
        if (add(cell, 2 * spacing, 1)) return;
        for (int k = 0; k < 8; ++k) add(2 * cell + Int3{k & 1, k >> 1 & 1, k >> 2}, spacing, 2);
    });
    return all;
}

}  // namespace

Interior interior_splats(const Solid& solid, const std::vector<float>& depth,
                         const InteriorOptions& options)
{
    if (options.max_count == 0) return {{}, {}, options.spacing};
    // A splat covers at most eight cubic spacings, and the grid is sampled no finer than at an
    // eighth of its spacing.
    double spacing = max(max(options.spacing, solid.grid.h / 8),
                         std::cbrt(solid.volume / (8 * double(options.max_count))));
    for (;; spacing *= 1.1) {
        Interior all = at_spacing(solid, depth, options, spacing);
        if (all.centre.size() <= options.max_count) return all;
    }
}

}  // namespace knead
