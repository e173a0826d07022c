#include "host/assets/clean.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/base/parallel.h"

namespace knead {
namespace {

using Indices = std::vector<std::uint32_t>;
constexpr std::size_t sample_size = 1000;
constexpr std::size_t max_scanned = 256;  // splats scanned per row of cells: bounds the time

double quantile(std::vector<double>& values, double share)
{
    const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
}

double longest(Vec3<float> s) { return max(s.x, max(s.y, s.z)); }
std::array<double, 3> axes(Vec3<float> x) { return {x.x, x.y, x.z}; }

bool finite(const SplatCloud& cloud, std::uint32_t i)
{
    const Vec3<float> x = cloud.centre[i], s = cloud.scale[i];
    const Quat<float> q = cloud.rotation[i];
    for (float v : {x.x, x.y, x.z, s.x, s.y, s.z, q.w, q.x, q.y, q.z, cloud.opacity[i]})
        if (!std::isfinite(v)) return false;
    return true;
}

// Keeps the indices for which `good` returns true; returns the number of the others.
template <class Good>
std::size_t keep(Indices& kept, Good&& good)
{
    return std::erase_if(kept, [&](std::uint32_t i) { return !good(i); });
}

struct Extent {
    std::array<double, 3> low, high;
    double size = 0;    // the longest edge [m]
    double median = 0;  // median longest half axis [m]
};

Extent extent_of(const SplatCloud& cloud, const Indices& kept)
{
    Extent e{};
    std::vector<double> values(kept.size());
    const auto fill = [&](auto value) {
        std::transform(kept.begin(), kept.end(), values.begin(), value);
    };
    fill([&](std::uint32_t i) { return longest(cloud.scale[i]); });
    e.median = quantile(values, 0.5);
    for (std::size_t k = 0; k < 3; ++k) {
        fill([&](std::uint32_t i) { return axes(cloud.centre[i])[k]; });
        e.low[k] = quantile(values, 0.02) - 3 * e.median;
        e.high[k] = quantile(values, 0.98) + 3 * e.median;
        e.size = max(e.size, e.high[k] - e.low[k]);
    }
    return e;
}

double distance2(const SplatCloud& cloud, std::uint32_t i, std::uint32_t j)
{
    const Vec3<double> d = cast<double>(cloud.centre[i]) - cast<double>(cloud.centre[j]);
    return dot(d, d);
}

// Median distance to the n-th neighbour, over an evenly strided sample.
double median_distance(const SplatCloud& cloud, const Indices& kept, std::size_t n)
{
    const std::size_t count = std::min(sample_size, kept.size());
    std::vector<double> found(count);
    parallel_for(count, [&](std::size_t k) {
        const std::uint32_t i = kept[k * kept.size() / count];
        // Max-heap of the n + 1 smallest squared distances, including that of i itself.
        std::vector<double> least(n + 1, std::numeric_limits<double>::max());
        for (std::uint32_t j : kept) {
            const double d = distance2(cloud, i, j);
            if (!(d < least.front())) continue;
            std::pop_heap(least.begin(), least.end());
            least.back() = d;
            std::push_heap(least.begin(), least.end());
        }
        found[k] = std::sqrt(least.front());
    });
    return quantile(found, 0.5);
}

// Flags splats with fewer than n others within r. Centres are sorted by cells of edge r, and the
// rows of three cells around each are searched.
std::vector<char> isolated(const SplatCloud& cloud, const Indices& kept, std::size_t n, double r,
                           const Extent& e)
{
    struct Keyed {
        std::uint64_t key;
        std::uint32_t index;
    };
    constexpr std::uint64_t cells = 1 << 20;  // maximum per axis: far splats are dropped before
    const double edge = max(r, 4 * e.size / double(cells));
    const auto key = [&](std::uint64_t x, std::uint64_t y, std::uint64_t z) {
        return (z * cells + y) * cells + x;
    };
    const auto cell = [&](std::uint32_t i) {
        std::array<std::uint64_t, 3> c{};
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = 1 + std::uint64_t((axes(cloud.centre[i])[k] - e.low[k] + e.size) / edge);
        return c;
    };
    std::vector<Keyed> sorted;
    sorted.reserve(kept.size());
    for (std::uint32_t i : kept) {
        const auto c = cell(i);
        sorted.push_back({key(c[0], c[1], c[2]), i});
    }
    std::sort(sorted.begin(), sorted.end(), [](const Keyed& a, const Keyed& b) {
        return a.key != b.key ? a.key < b.key : a.index < b.index;
    });
    std::vector<char> lonely(cloud.count());
    parallel_for(kept.size(), LoopOptions{.chunk = 1024}, [&](std::size_t k) {
        const std::uint32_t i = kept[k];
        const auto c = cell(i);
        std::size_t near = 0;
        for (std::size_t row = 0; row < 9 && near <= n; ++row) {
            const std::uint64_t middle = key(c[0], c[1] + row % 3 - 1, c[2] + row / 3 - 1);
            auto at = std::lower_bound(sorted.begin(), sorted.end(), middle - 1,
                                       [](const Keyed& a, std::uint64_t b) { return a.key < b; });
            for (std::size_t s = 0; s < max_scanned && at != sorted.end() && at->key <= middle + 1;
                 ++s, ++at)
                near += distance2(cloud, i, at->index) <= r * r;
        }
        lonely[i] = near <= n;  // `near` includes the splat itself
    });
    return lonely;
}

}  // namespace

CleanCloud clean(const SplatCloud& cloud, const CleanOptions& options)
{
    CleanCloud out;
    Indices& kept = out.kept;
    kept.resize(cloud.count());
    for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = std::uint32_t(i);
    CleanReport& r = out.report;
    r.not_finite = keep(kept, [&](std::uint32_t i) { return finite(cloud, i); });
    r.faint = keep(kept, [&](std::uint32_t i) { return cloud.opacity[i] >= options.min_opacity; });
    if (kept.empty()) return out;
    const Extent e = extent_of(cloud, kept);
    r.far = keep(kept, [&](std::uint32_t i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = axes(cloud.centre[i])[k];
            if (x < e.low[k] - e.size || x > e.high[k] + e.size) return false;
        }
        return true;
    });
    r.huge = keep(kept, [&](std::uint32_t i) {
        const double s = longest(cloud.scale[i]);
        return s <= max(options.max_size * e.median, e.size / 20);
    });
    if (kept.empty()) return out;
    const std::size_t n = std::size_t(options.neighbours);
    if (kept.size() <= n) return out;
    const double distance = options.isolation * median_distance(cloud, kept, n);
    if (!(distance > 0)) return out;  // most centres coincide: no scale to compare with
    const std::vector<char> lonely = isolated(cloud, kept, n, distance, e);
    r.isolated = keep(kept, [&](std::uint32_t i) { return !lonely[i]; });
    return out;
}

}  // namespace knead
