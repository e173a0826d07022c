#include "host/splats/cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace knead {
namespace {

// The lowest 21 bits of x, two zeros between each.
std::uint64_t spread(std::uint64_t x)
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
}

// In cells of 2 mm in a cube of 4 km; what lies outside is at its side, what is not finite at 0.
std::uint64_t cell(float x)
{
    const float metres = std::isfinite(x) ? clamp(x, -2000.0f, 2000.0f) : 0;
    return std::uint64_t((metres + 2048) * 512);
}

template <class T>
void reorder(std::vector<T>& values, const std::vector<std::size_t>& order, std::size_t row)
{
    std::vector<T> sorted;
    sorted.reserve(values.size());
    for (const std::size_t i : order)
        for (std::size_t k = 0; k < row; ++k) sorted.push_back(values[i * row + k]);
    values = std::move(sorted);
}

}  // namespace

void sort_by_place(SplatCloud& cloud, std::size_t kept)
{
    const std::size_t n = cloud.count();
    std::vector<std::uint64_t> keys(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3<float> x = cloud.centre[i];
        keys[i] = spread(cell(x.x)) | spread(cell(x.y)) << 1 | spread(cell(x.z)) << 2;
    }
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin() + long(std::min(kept, n)), order.end(),
                     [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
    reorder(cloud.centre, order, 1), reorder(cloud.rotation, order, 1);
    reorder(cloud.scale, order, 1), reorder(cloud.opacity, order, 1);
    reorder(cloud.sh, order, std::size_t(harmonics(cloud.degree)));
}

}  // namespace knead
