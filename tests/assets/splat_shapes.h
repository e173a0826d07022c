// Splat clouds of objects whose interior is known: a distance-like function below 0 inside, its
// surface covered by splats, and what spoils a cloud.
#pragma once
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "host/files/splat_file.h"

namespace knead {

struct SplatShape {
    std::string name;
    std::function<double(Vec3<double>)> phi;  // below 0 inside, slope about 1 near the surface
    double half = 0.6;                        // of a box around it [m]

    bool inside(Vec3<double> x) const { return phi(x) < 0; }
    Vec3<double> slope(Vec3<double> x) const
    {
        const double e = 1e-5;
        return (0.5 / e) *
               Vec3<double>{phi(x + Vec3<double>{e, 0, 0}) - phi(x - Vec3<double>{e, 0, 0}),
                            phi(x + Vec3<double>{0, e, 0}) - phi(x - Vec3<double>{0, e, 0}),
                            phi(x + Vec3<double>{0, 0, e}) - phi(x - Vec3<double>{0, 0, e})};
    }
    // By a lattice of n^3 cubes, each counted by its share inside.
    double volume(int n = 160) const
    {
        const double h = 2 * half / n;
        double sum = 0;
        for (int k = 0; k < n * n * n; ++k)
            sum += clamp(0.5 - phi({h * (k % n + 0.5) - half, h * (k / n % n + 0.5) - half,
                                    h * (k / (n * n) + 0.5) - half}) /
                                   h,
                         0.0, 1.0);
        return sum * h * h * h;
    }
};

inline double norm2(double a, double b) { return std::sqrt(a * a + b * b); }

inline SplatShape ball_shape()
{
    return {"ball", [](Vec3<double> x) { return length(x) - 0.5; }};
}
inline SplatShape box_shape()
{
    return {"box", [](Vec3<double> x) {
                return max(std::abs(x.x) - 0.5, max(std::abs(x.y) - 0.35, std::abs(x.z) - 0.2));
            }};
}
inline SplatShape torus_shape()
{
    return {"torus", [](Vec3<double> x) { return norm2(norm2(x.x, x.y) - 0.36, x.z) - 0.14; }};
}
inline SplatShape bumpy_shape()
{
    return {"bumpy ball", [](Vec3<double> x) {
                const double r = max(length(x), 1e-9);
                const double bump =
                    std::sin(8 * x.x / r) * std::sin(8 * x.y / r) * std::sin(8 * x.z / r);
                return 0.8 * (r - 0.45 - 0.08 * bump);
            }};
}
// With splats on both faces of its wall, the inner one being out of sight.
inline SplatShape shell_shape()
{
    return {"shell", [](Vec3<double> x) { return max(length(x) - 0.5, 0.3 - length(x)); }};
}
inline SplatShape bowl_shape()
{
    return {
        "bowl", [](Vec3<double> x) {
            return max(max(length(x) - 0.5, 0.4 - length(x - Vec3<double>{0, 0, 0.04})), x.z - 0.1);
        }};
}
// Twice as deep as wide.
inline SplatShape cup_shape()
{
    return {"cup", [](Vec3<double> x) {
                const double r = norm2(x.x, x.y);
                const double wall = max(r - 0.32, std::abs(x.z) - 0.5);
                return max(wall, min(0.22 - r, x.z + 0.4));
            }};
}

struct Spoil {
    double noise = 0;     // of a position, standard deviation [m]
    bool faint = false;   // opacities from 0.1 to 1
    double floaters = 0;  // share
    double huge = 0;      // share, 100 times as large
    double flat = 0;      // share, with one half axis 0, and a fourth of it with two
    bool twice = false;   // every splat two times
    double interior = 0;  // share, anywhere inside
    std::function<bool(Vec3<double>)> missing;  // no splats there
};

inline Quat<double> turned(std::mt19937_64& random)
{
    std::normal_distribution<double> normal;
    return unit(Quat<double>{normal(random), normal(random), normal(random), normal(random)});
}

// About `count` splats, evenly over the surface, of half axes near the distance between them.
inline SplatCloud cloud_of(const SplatShape& shape, int count, const Spoil& spoil = {},
                           std::uint64_t seed = 1)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<double> normal;
    const auto anywhere = [&](double half) {
        return Vec3<double>{half * (2 * uniform(random) - 1), half * (2 * uniform(random) - 1),
                            half * (2 * uniform(random) - 1)};
    };
    SplatCloud cloud;
    double size = 0.8 / std::sqrt(double(count));
    const auto add = [&](Vec3<double> x, double s) {
        const bool flat = uniform(random) < spoil.flat, line = flat && uniform(random) < 0.25;
        cloud.centre.push_back(cast<float>(x));
        cloud.rotation.push_back(cast<float>(turned(random)));
        cloud.scale.push_back(
            cast<float>(Vec3<double>{s * (1 + uniform(random)), line ? 0 : 1.5 * s, flat ? 0 : s}));
        cloud.opacity.push_back(spoil.faint ? float(0.1 + 0.9 * uniform(random)) : 0.98f);
        cloud.sh.push_back(cast<float>((0.4 / shape.half) * x));
    };
    const double band = 0.02;
    while (cloud.count() < std::size_t(count)) {
        Vec3<double> x = anywhere(shape.half);
        if (uniform(random) < spoil.interior) {
            while (shape.phi(x) > -0.02) x = anywhere(shape.half);
            add(x, size);
            continue;
        }
        if (std::abs(shape.phi(x)) > band) continue;
        for (int k = 0; k < 4; ++k) {
            const Vec3<double> g = shape.slope(x);
            x = x - (shape.phi(x) / max(dot(g, g), 1e-6)) * g;
        }
        if (std::abs(shape.phi(x)) > 1e-3 || (spoil.missing && spoil.missing(x))) continue;
        x = x + spoil.noise * Vec3<double>{normal(random), normal(random), normal(random)};
        add(x, size);
        if (spoil.twice) add(x, size);
    }
    for (int k = 0; k < int(spoil.floaters * count); ++k) add(anywhere(1.5), size);
    for (int k = 0; k < int(spoil.huge * count); ++k) add(anywhere(1), 100 * size);
    return cloud;
}

}  // namespace knead
