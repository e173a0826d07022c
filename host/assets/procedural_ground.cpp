#include "host/assets/procedural_ground.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "cuda/splats/gaussian.h"
#include "host/scene/strata.h"

namespace knead {
namespace {

constexpr double tile = 0.08, mortar_width = 0.006, ground_side = 1;  // [m]

double height_at(double x, double z)  // [m]
{
    return 0.006 * std::sin(7 * x + 1) * std::cos(5 * z) + 0.004 * std::sin(3 * x - 9 * z);
}

Vec3<double> normal_at(double x, double z)
{
    const double e = 1e-4;
    const Vec3<double> n{(height_at(x - e, z) - height_at(x + e, z)) / (2 * e), 1,
                         (height_at(x, z - e) - height_at(x, z + e)) / (2 * e)};
    return (1 / length(n)) * n;
}

// Linear RGB, 0 to 1.
Vec3<double> paint_at(unsigned seed, double x, double z, bool& mortar)
{
    const int i = int(std::floor(x / tile)), k = int(std::floor(z / tile));
    const double u = x - i * tile, v = z - k * tile;
    mortar = u < mortar_width / 2 || v < mortar_width / 2 || u > tile - mortar_width / 2 ||
             v > tile - mortar_width / 2;
    const Vec3<double> r = strata::hashed(seed, 2, {i, 0, k});
    if (mortar) return {0.62, 0.6, 0.56};
    const double a = std::atan2(k + 0.5, i + 0.5), far = std::hypot(i + 0.5, k + 0.5);
    const double arm = std::sin(3 * a + 0.9 * far);
    const Vec3<double> warm{0.78, 0.36, 0.2}, cool{0.13, 0.4, 0.5}, pale{0.9, 0.82, 0.66};
    const Vec3<double> base = arm > 0.35 ? warm : arm < -0.35 ? cool : pale;
    return (0.85 + 0.25 * r.x) * base;
}

}  // namespace

SplatCloud tiled_ground(int count, unsigned seed)
{
    if (count < 100) throw std::invalid_argument("tiled_ground: expected at least 100 splats");
    const int rows = int(std::ceil(std::sqrt(double(count))));
    const double gap = ground_side / rows;
    SplatCloud cloud;
    for (int k = 0; k < count; ++k) {
        const Vec3<double> u = strata::hashed(seed, 1, {k, 0, 0});
        const int column = k % rows, row = k / rows;
        const double x = (column + 0.35 + 0.3 * u.x) * gap - ground_side / 2;
        const double z = (row + 0.35 + 0.3 * u.y) * gap - ground_side / 2;
        const Vec3<double> n = normal_at(x, z), along = orthogonal(n);
        bool mortar = false;
        const Vec3<double> c = paint_at(seed, x, z, mortar);
        const double s = gap * (0.66 + 0.08 * u.z);
        cloud.centre.push_back(
            cast<float>(Vec3<double>{x, height_at(x, z) - (mortar ? 0.002 : 0), z}));
        cloud.rotation.push_back(cast<float>(quaternion(Mat3<double>{along, cross(n, along), n})));
        cloud.scale.push_back(cast<float>(Vec3<double>{s, s, s / 2}));
        cloud.opacity.push_back(0.98f);
        const auto coefficient = [](double v) {
            return (std::sqrt(min(v, 1.0)) - 0.5) / sh_constant;
        };
        cloud.sh.push_back(
            cast<float>(Vec3<double>{coefficient(c.x), coefficient(c.y), coefficient(c.z)}));
    }
    return cloud;
}

}  // namespace knead
