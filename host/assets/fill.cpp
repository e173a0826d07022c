#include "host/assets/fill.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <unordered_map>

#include "host/assets/samples.h"
#include "host/base/errors.h"
#include "host/scene/packing.h"

namespace knead {
namespace {

using Indices = std::vector<std::uint32_t>;
constexpr double bytes_per_node = 104;      // of the solid, its depths and its colours
constexpr double bytes_per_particle = 128;  // position and stratum twice, while a vector grows
constexpr double bytes_per_stratum = 16;    // during packing
constexpr double bytes_per_splat = 400;     // twice, with harmonics of degree 3
constexpr double max_strata = 1e9;          // along an axis: indices are int

void check(const FillOptions& options)
{
    if (!(options.cell > 0) || !std::isfinite(options.cell) || !(options.per_cell >= 1) ||
        !(options.per_cell <= 1000) || !(options.interior_spacing >= 0) ||
        !(options.min_depth_in_half_axes >= 0) || options.solid.max_cells < 8 ||
        options.solid.max_cells > 320 || options.solid.directions < 6)
        throw std::invalid_argument("fill: an option is out of range");
}

void check_bytes(const FillOptions& options, double bytes, const char* of)
{
    if (bytes > double(options.max_bytes))
        throw MemoryError(fmt::format("{} need about {:.1f} MiB, and {:.1f} MiB are allowed", of,
                                      bytes / 0x1p20, double(options.max_bytes) / 0x1p20));
}

// The strata of the solid, from `low` up to but excluding `high`; keys of those that hold
// particles, sorted.
struct Strata {
    double h;  // edge [m]
    Int3 low{}, high{};
    std::vector<Vec3<double>> particles;
    std::vector<std::uint64_t> keys;

    Int3 of(Vec3<double> x) const
    {
        return {int(std::floor(x.x / h)), int(std::floor(x.y / h)), int(std::floor(x.z / h))};
    }
    // Linear index in the box with one more stratum on each side.
    std::uint64_t key(Int3 s) const
    {
        const auto edge = [](int from, int to) { return std::uint64_t(to - from) + 2; };
        const auto place = [](int from, int at) { return std::uint64_t(at - from + 1); };
        return (place(low.z, s.z) * edge(low.y, high.y) + place(low.y, s.y)) * edge(low.x, high.x) +
               place(low.x, s.x);
    }
    bool stores(Int3 s) const
    {
        return s.x >= low.x && s.y >= low.y && s.z >= low.z && s.x < high.x && s.y < high.y &&
               s.z < high.z;
    }
};

// Strata over the inner nodes of the grid.
Strata strata_over(const Grid& grid, double h)
{
    const Vec3<double> from = (1 / h) * grid.position({0, 0, 0}),
                       to = (1 / h) * grid.position(grid.size - Int3{1, 1, 1});
    for (double end : {from.x, from.y, from.z, to.x, to.y, to.z})
        if (!(std::abs(end) < max_strata))
            throw InputError(fmt::format(
                "expected an object near the origin, relative to the cell size, found it {:.3g} "
                "particles away",
                std::abs(end)));
    Strata s{h, {}, {}, {}, {}};
    s.low = s.of(h * from);
    s.high = s.of(h * to) + Int3{1, 1, 1};
    const auto edge = [](int low, int high) { return double(high) - double(low) + 2; };
    const double count =
        edge(s.low.x, s.high.x) * edge(s.low.y, s.high.y) * edge(s.low.z, s.high.z);
    if (count > 4e9)
        throw MemoryError(fmt::format(
            "expected a cell size suited to the object, found {:.3g} strata in its box", count));
    return s;
}

// Range of strata that may intersect the solid, end excluded.
std::pair<Int3, Int3> solid_box(const Solid& solid, const Strata& strata)
{
    const Grid& grid = solid.grid;
    Int3 low = grid.size, high{-1, -1, -1};
    for (std::size_t i = 0; i < grid.count(); ++i) {
        if (solid.indicator[i] <= solid.level) continue;
        const Int3 n = grid.node(i);
        low = {min(low.x, n.x), min(low.y, n.y), min(low.z, n.z)};
        high = {max(high.x, n.x), max(high.y, n.y), max(high.z, n.z)};
    }
    if (high.x < 0) return {strata.low, strata.low};
    const Int3 one{1, 1, 1};
    return {strata.of(grid.position(low - one)), strata.of(grid.position(high + one)) + one};
}

// Depth from the indicator, which changes by one mostly within three spacings of the grid. Near 0
// and 1 the indicator is no measure of depth: there half a stratum is returned, so that no stratum
// is missed.
double depth_in(const Solid& solid, Vec3<double> x, double stratum)
{
    const double excess = double(solid.inside(x)), limit = stratum / 2;
    if (std::abs(excess) > 1.0 / 3) return std::copysign(limit, excess);
    return clamp(3 * excess * solid.grid.h, -limit, limit);
}

void fill_solid(const Solid& solid, const FillOptions& options, Strata& strata)
{
    const auto [low, high] = solid_box(solid, strata);
    const Int3 size = high - low;
    check_bytes(options, bytes_per_stratum * double(size.x) * size.y * size.z,
                "The object's strata");
    strata.particles = packed({strata.h, options.per_cell, options.seed, 0, low, high},
                              [&](Vec3<double> x) { return depth_in(solid, x, strata.h); });
    for (Vec3<double> x : strata.particles) strata.keys.push_back(strata.key(strata.of(x)));
    std::sort(strata.keys.begin(), strata.keys.end());
}

bool near_particles(const Strata& strata, Int3 s)
{
    for (int row = 0; row < 9; ++row) {
        const std::uint64_t middle = strata.key(s + Int3{0, row % 3 - 1, row / 3 - 1});
        const auto at = std::lower_bound(strata.keys.begin(), strata.keys.end(), middle - 1);
        if (at != strata.keys.end() && *at <= middle + 1) return true;
    }
    return false;
}

// Visible splats without particles of the solid in the surrounding strata belong to a part too thin
// for the grid: each stratum that they touch gets a particle at their mean.
std::size_t fill_thin(const SplatCloud& cloud, const Indices& kept, const Solid& solid,
                      Strata& strata)
{
    struct Touch {
        std::uint64_t key;
        Vec3<double> x;
    };
    std::vector<Touch> touches;
    for (std::uint32_t i : kept) {
        if (!solid.visible(cast<double>(cloud.centre[i]))) continue;
        each_sample(cloud, i, strata.h, 8, [&](Vec3<double> x, double, double u2) {
            const Int3 s = strata.of(x);
            if (u2 > 1.5 || !strata.stores(s) || near_particles(strata, s)) return;
            touches.push_back({strata.key(s), x});
        });
    }
    std::stable_sort(touches.begin(), touches.end(),
                     [](const Touch& a, const Touch& b) { return a.key < b.key; });
    // A sheet between two strata touches both: the second stratum gets no particle close to the
    // particle of the first.
    std::unordered_map<std::uint64_t, Vec3<double>> added;
    for (std::size_t from = 0, to; from < touches.size(); from = to) {
        Vec3<double> sum{};
        for (to = from; to < touches.size() && touches[to].key == touches[from].key; ++to)
            sum = sum + touches[to].x;
        const Vec3<double> x = (1 / double(to - from)) * sum;
        bool near = false;
        for (int k = 0; k < 27 && !near; ++k) {
            const auto at =
                added.find(strata.key(strata.of(x) + Int3{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1}));
            near = at != added.end() && length(at->second - x) < 0.6 * strata.h;
        }
        if (near) continue;
        added.emplace(touches[from].key, x);
        strata.particles.push_back(x);
    }
    return added.size();
}

void add_interior(const Interior& interior, const Solid& solid,
                  const std::vector<Vec3<float>>& colours, SplatCloud& splats)
{
    constexpr float nearly_opaque = 0.98f;
    const std::size_t stride = std::size_t(harmonics(splats.degree));
    for (std::size_t k = 0; k < interior.centre.size(); ++k) {
        const float s = interior.half_axis[k];
        splats.centre.push_back(cast<float>(interior.centre[k]));
        splats.rotation.push_back({1, 0, 0, 0});
        splats.scale.push_back({s, s, s});
        splats.opacity.push_back(nearly_opaque);
        splats.sh.push_back(sampled(solid.grid, colours, interior.centre[k]));
        splats.sh.resize(splats.sh.size() + stride - 1);
    }
}

}  // namespace

FilledObject fill(const SplatCloud& cloud, const FillOptions& options)
{
    check(options);
    return fill(cloud, clean(cloud, options.clean), options);
}

FilledObject fill(const SplatCloud& cloud, const CleanCloud& clean_cloud,
                  const FillOptions& options)
{
    check(options);
    const double nodes = std::pow(4.0 / 3 * options.solid.max_cells + 2 * 6 + 17, 3);
    check_bytes(options, nodes * bytes_per_node + double(cloud.count()) * bytes_per_splat,
                "The object's solid and splats");
    FilledObject out;
    FillReport& report = out.report;
    const Indices& kept = clean_cloud.kept;
    const Solid solid = find_solid(cloud, kept, options.solid);
    report = {clean_cloud.report, solid.volume, solid.unlit, solid.found, solid.grid.h, 0, 0};

    const double h = options.cell / std::cbrt(options.per_cell);
    out.particle_volume = h * h * h;
    // A thin part has at most one stratum per sample point of a splat.
    check_bytes(
        options,
        bytes_per_particle * (1.1 * solid.volume / out.particle_volume + double(kept.size())),
        "The object's particles");
    Strata strata = strata_over(solid.grid, h);
    fill_solid(solid, options, strata);
    report.thin = fill_thin(cloud, kept, solid, strata);
    out.particles = std::move(strata.particles);

    out.splats = picked(cloud, kept);
    out.surface = kept.size();
    const std::vector<float> depth = depths(solid);
    const Interior interior =
        interior_splats(solid, depth,
                        {options.interior_spacing > 0 ? options.interior_spacing : h,
                         options.min_depth_in_half_axes, options.max_interior, options.seed});
    report.interior_spacing = interior.spacing;
    add_interior(interior, solid, inner_colours(cloud, kept, solid, depth), out.splats);
    return out;
}

}  // namespace knead
