// Point samples of a splat, for depositing it on a lattice.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/files/splat_file.h"

namespace knead {

// Calls use(place, weight, u2) for sample points of splat i at resolution `h`: its centre, or
// several points along axes longer than a quarter of h, out to two half axes, at most `most` per
// axis. Weights sum to 1; u2 is the squared distance in half axes.
template <class Use>
void each_sample(const SplatCloud& cloud, std::uint32_t i, double h, int most, Use&& use)
{
    const Mat3<double> Q = rotation(cast<double>(cloud.rotation[i]));
    const Vec3<double> s = cast<double>(cloud.scale[i]), x = cast<double>(cloud.centre[i]);
    const auto points = [&](double half_axis) {
        return half_axis < h / 4
                   ? 1
                   : int(clamp(std::ceil(4 * half_axis / (0.75 * h)), 1.0, double(most)));
    };
    const auto offset = [](int k, int n) { return n == 1 ? 0 : 4 * (k + 0.5) / n - 2; };
    const Int3 n{points(s.x), points(s.y), points(s.z)};
    const auto walk = [&](auto&& visit) {
        for (int k = 0; k < n.x * n.y * n.z; ++k)
            visit(Vec3<double>{offset(k % n.x, n.x), offset(k / n.x % n.y, n.y),
                               offset(k / (n.x * n.y), n.z)});
    };
    double sum = 0;
    walk([&](Vec3<double> u) { sum += std::exp(-dot(u, u) / 2); });
    walk([&](Vec3<double> u) {
        use(x + Q * Vec3<double>{s.x * u.x, s.y * u.y, s.z * u.z}, std::exp(-dot(u, u) / 2) / sum,
            dot(u, u));
    });
}

}  // namespace knead
