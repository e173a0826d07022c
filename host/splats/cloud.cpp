#include "host/splats/cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "host/base/parallel.h"

namespace knead {
namespace {

// Spreads the lowest 21 bits of x, with two zeros between bits.
std::uint64_t spread(std::uint64_t x)
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
}

// Cell index, for cells of 2 mm in a cube of 4 km; values outside are clamped, non-finite ones map
// to 0.
std::uint64_t cell(float x)
{
    const float metres = std::isfinite(x) ? clamp(x, -2000.0f, 2000.0f) : 0;
    return std::uint64_t((metres + 2048) * 512);
}

}  // namespace

void resize(SplatCloud& c, std::size_t count)
{
    c.centre.resize(count), c.rotation.resize(count), c.scale.resize(count);
    c.opacity.resize(count), c.sh.resize(count * std::size_t(harmonics(c.degree)));
}

void reserve(SplatCloud& c, std::size_t count)
{
    c.centre.reserve(count), c.rotation.reserve(count), c.scale.reserve(count);
    c.opacity.reserve(count), c.sh.reserve(count * std::size_t(harmonics(c.degree)));
}

void set_splat(SplatCloud& to, std::size_t at, const SplatCloud& from, std::size_t i)
{
    const auto count = std::size_t(harmonics(from.degree));
    to.centre[at] = from.centre[i], to.rotation[at] = from.rotation[i];
    to.scale[at] = from.scale[i], to.opacity[at] = from.opacity[i];
    for (std::size_t k = 0; k < count; ++k) to.sh[at * count + k] = from.sh[i * count + k];
}

SplatCloud picked(const SplatCloud& cloud, const std::vector<std::uint32_t>& indices)
{
    SplatCloud out;
    out.degree = cloud.degree, out.antialiased = cloud.antialiased;
    resize(out, indices.size());
    const int count = int(indices.size());
    parallel_for(count,
                 [&](int k) { set_splat(out, std::size_t(k), cloud, indices[std::size_t(k)]); });
    return out;
}

void sort_by_place(SplatCloud& cloud, std::size_t kept)
{
    const std::size_t n = cloud.count();
    std::vector<std::uint64_t> keys(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3<float> x = cloud.centre[i];
        keys[i] = spread(cell(x.x)) | spread(cell(x.y)) << 1 | spread(cell(x.z)) << 2;
    }
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), std::uint32_t(0));
    std::stable_sort(order.begin() + long(std::min(kept, n)), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    cloud = picked(cloud, order);
}

}  // namespace knead
