#include "host/assets/procedural_object.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <stdexcept>

#include "host/scene/strata.h"

namespace knead {
namespace {

using std::numbers::pi;
using Colour = Vec3<double>;
constexpr double height = 0.2;  // scale of the model below, which has units of 1 [m]

// The profile, from the centre of the foot over belly and lip to the centre of the dish: radius and
// height.
struct Knot {
    double r, y;
};
constexpr std::array<Knot, 16> outline{{{0, 0.012},
                                        {0.15, 0.012},
                                        {0.235, 0.004},
                                        {0.27, 0.03},
                                        {0.345, 0.12},
                                        {0.445, 0.27},
                                        {0.492, 0.43},
                                        {0.465, 0.59},
                                        {0.36, 0.735},
                                        {0.255, 0.825},
                                        {0.235, 0.89},
                                        {0.285, 0.965},
                                        {0.268, 0.99},
                                        {0.215, 0.955},
                                        {0.12, 0.905},
                                        {0, 0.89}}};

double cubic(double a, double b, double c, double d, double t)  // [Catmull 1974]
{
    return b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

Knot outline_at(double s)  // 0 at the foot to 1 in the dish
{
    constexpr int pieces = int(outline.size()) - 1;
    const double at = clamp(s, 0.0, 1.0) * pieces;
    const int k = std::min(int(at), pieces - 1);
    // Beyond its ends the profile is mirrored.
    const auto knot = [&](int i) {
        const int j = i < 0 ? -i : i > pieces ? 2 * pieces - i : i;
        const Knot o = outline[std::size_t(j)];
        return i == j ? o : Knot{-o.r, o.y};
    };
    const Knot a = knot(k - 1), b = knot(k), c = knot(k + 1), d = knot(k + 2);
    return {max(cubic(a.r, b.r, c.r, d.r, at - k), 0.0), cubic(a.y, b.y, c.y, d.y, at - k)};
}

double smooth_step(double low, double high, double x)
{
    const double t = clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// Twelve flutes winding around the belly: 1 on a ridge, -1 in a valley.
double flute(double angle, Knot o)
{
    const double wave = std::cos(12 * (angle + 0.9 * o.y));
    return 1 - 2 * std::sqrt(0.5 - 0.5 * wave + 0.02);
}

// Extent of the flutes: not to the foot, not over the shoulder.
double fluted(double s, Knot o)
{
    return s > 0.7 ? 0 : smooth_step(0.1, 0.3, o.y) * (1 - smooth_step(0.58, 0.8, o.y));
}

Vec3<double> surface_at(double angle, double s)
{
    const Knot o = outline_at(s);
    const double r = o.r * (1 + 0.045 * fluted(s, o) * flute(angle, o));
    return {r * std::cos(angle), o.y, r * std::sin(angle)};
}

// Smooth noise between -1 and 1.
double noise(unsigned seed, Vec3<double> x)
{
    const Int3 low{int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))};
    double sum = 0;
    for (int k = 0; k < 8; ++k) {
        const Int3 d{k & 1, k >> 1 & 1, k >> 2};
        const auto share = [](double at, int from, int side) {
            const double t = smooth_step(0, 1, at - from);
            return side ? t : 1 - t;
        };
        sum += share(x.x, low.x, d.x) * share(x.y, low.y, d.y) * share(x.z, low.z, d.z) *
               (2 * strata::hashed(seed, 0, low + d).x - 1);
    }
    return sum;
}

double layered_noise(unsigned seed, Vec3<double> x)
{
    return (noise(seed, x) + 0.5 * noise(seed + 1, 2.1 * x) + 0.25 * noise(seed + 2, 4.3 * x)) /
           1.75;
}

Colour mixed(Colour a, Colour b, double t) { return (1 - t) * a + t * b; }

// Lower edge of the glaze: a wavy line with runs.
double glaze_edge(unsigned seed, double angle)
{
    const Vec3<double> around{std::cos(angle), 0, std::sin(angle)};
    const double tongue = noise(seed + 11, 4.7 * around + Vec3<double>{9, 0, 0});
    return 0.335 + 0.03 * noise(seed + 10, 1.5 * around) - 0.2 * smooth_step(0.0, 0.65, tongue) -
           0.02 * noise(seed + 12, 8.0 * around);
}

struct Paint {
    Colour colour;
    double gloss;  // 0 to 1
};

Paint paint_at(unsigned seed, double angle, double s, Vec3<double> x)
{
    const Knot o = outline_at(s);
    const double grain = layered_noise(seed + 20, 14.0 * x),
                 cloud = layered_noise(seed + 30, 3.2 * x);
    const double rings = std::sin(150 * x.y + 4 * cloud);
    const Colour clay = mixed({0.56, 0.27, 0.16}, {0.80, 0.47, 0.30},
                              clamp(0.5 + 0.45 * grain + 0.1 * rings, 0.0, 1.0));
    const double above = x.y - glaze_edge(seed, angle);
    // Thick where it pooled above its edge, in the valleys and in the dish; thin on ridges and lip.
    const double pooled = smooth_step(0.11, 0.0, above), ridge = flute(angle, o) * fluted(s, o);
    const double thick = clamp(0.45 + 0.6 * pooled - 0.38 * ridge + 0.35 * cloud -
                                   0.5 * smooth_step(0.6, 0.85, x.y) + (s > 0.85 ? 0.55 : 0.0),
                               0.0, 1.0);
    const Colour thin{0.73, 0.83, 0.70}, middle{0.13, 0.58, 0.60}, deep{0.03, 0.20, 0.40};
    Colour glaze = thick < 0.5 ? mixed(thin, middle, smooth_step(0, 0.5, thick))
                               : mixed(middle, deep, smooth_step(0.5, 1, thick));
    // Amber where it is thinnest, with iron specks.
    const double lip = smooth_step(0.945, 0.985, x.y) + 0.75 * smooth_step(0.62, 0.95, ridge);
    glaze = mixed(glaze, {0.70, 0.42, 0.17}, 0.85 * clamp(lip + 0.25 * grain, 0.0, 1.0));
    glaze =
        mixed(glaze, {0.30, 0.20, 0.12}, 0.55 * smooth_step(0.6, 0.75, noise(seed + 40, 34.0 * x)));
    const double cover = smooth_step(-0.006, 0.006, above);
    // A dark line of bare, toasted clay along the edge.
    const Colour bare = mixed({0.36, 0.15, 0.08}, clay, smooth_step(0.0, 0.05, -above));
    return {mixed(bare, glaze, cover), cover};
}

struct Place {
    double angle, s;
    Vec3<double> x, normal, along;  // in model units; normal outwards, `along` the profile
};

Place place_at(double angle, double s)
{
    constexpr double e = 1e-4;
    const double from = clamp(s, e, 1 - e);
    const Vec3<double> u = surface_at(angle + e, from) - surface_at(angle - e, from),
                       v = surface_at(angle, from + e) - surface_at(angle, from - e),
                       n = cross(v, u);
    return {angle, s, surface_at(angle, s), (1 / length(n)) * n, (1 / length(v)) * v};
}

// Daylight from above, a lamp from the left; less of both in the dish, valleys and under the belly.
double shade(const Place& p)
{
    const Knot o = outline_at(p.s);
    const Vec3<double> lamp{-0.48, 0.64, 0.6};
    const double sky = 0.5 + 0.5 * p.normal.y;
    const double hollow = p.s > 0.8 ? 0.35 * smooth_step(0.97, 0.9, p.x.y) : 0.0;
    const double valley = 0.2 * max(0.0, -flute(p.angle, o) * fluted(p.s, o));
    const double near_floor = 0.3 * smooth_step(0.16, 0.0, p.x.y);
    return (0.62 + 0.24 * sky + 0.3 * max(0.0, dot(p.normal, lamp))) * (1 - hollow) * (1 - valley) *
           (1 - near_floor);
}

// Coefficients up to degree 2 of a glossy colour: a lobe of degree 4 around the mirrored lamp
// direction, projected by a quadrature that is exact for it.
void add_coefficients(const Place& p, const Paint& paint, std::vector<Vec3<float>>& sh)
{
    const Colour base = shade(p) * paint.colour;
    std::array<Vec3<double>, 9> c{};
    const std::array<Vec3<double>, 2> lamps{{{-0.48, 0.64, 0.6}, {0.7, 0.7, -0.14}}};
    each_lebedev<double>([&](Vec3<double> d, double weight) {
        double shine = 0;
        for (std::size_t k = 0; k < 2; ++k) {
            const Vec3<double> l = (1 / length(lamps[k])) * lamps[k];
            const Vec3<double> mirrored = 2 * dot(p.normal, l) * p.normal - l;
            const double lobe = 0.5 - 0.5 * dot(d, mirrored), facing = dot(p.normal, l);
            if (facing > 0) shine += (k ? 0.2 : 0.42) * lobe * lobe * lobe * lobe;
        }
        const Colour seen = base + (paint.gloss * (shine - 0.08)) * Colour{1, 1, 1};
        each_harmonic(2, d, [&](int k, double y) {
            c[std::size_t(k)] = c[std::size_t(k)] + weight * y * (seen - Colour{0.5, 0.5, 0.5});
        });
    });
    for (const Vec3<double>& v : c) sh.push_back(cast<float>(v));
}

// The profile cut into rings: cumulative area before each.
std::vector<double> area_before(int rings)
{
    std::vector<double> before{0};
    for (int k = 0; k < rings; ++k) {
        const Knot a = outline_at(double(k) / rings), b = outline_at((k + 1.0) / rings);
        before.push_back(before.back() + pi * (a.r + b.r) * std::hypot(b.r - a.r, b.y - a.y));
    }
    return before;
}

}  // namespace

SplatCloud glazed_pot(int count, unsigned seed)
{
    if (count < 100) throw std::invalid_argument("glazed_pot: expected at least 100 splats");
    constexpr int rings = 4000;
    const std::vector<double> before = area_before(rings);
    const double spacing = std::sqrt(before.back() / count);
    SplatCloud cloud;
    cloud.degree = 2;
    for (int k = 0; k < count; ++k) {
        const double area = before.back() * (k + 0.5) / count;
        const auto ring = std::upper_bound(before.begin(), before.end(), area) - 1;
        const double s =
            (double(ring - before.begin()) + (area - ring[0]) / (ring[1] - ring[0])) / rings;
        const Place p = place_at(2 * pi * std::fmod(k / std::numbers::phi, 1.0), s);
        const Vec3<double> u = strata::hashed(seed, 1, {k, 0, 0});
        const Mat3<double> axes{p.along, cross(p.normal, p.along), p.normal};
        const double size = spacing * (0.66 + 0.08 * u.x);
        cloud.centre.push_back(cast<float>(height * p.x));
        cloud.rotation.push_back(cast<float>(quaternion(axes)));
        cloud.scale.push_back(
            cast<float>(height * size * Vec3<double>{1, 0.92 + 0.08 * u.y, 1 / 1.9}));
        cloud.opacity.push_back(float(0.97 + 0.02 * u.z));
        add_coefficients(p, paint_at(seed, p.angle, p.s, p.x), cloud.sh);
    }
    return cloud;
}

double glazed_pot_volume()
{
    constexpr int around = 720, along = 2000;
    double sum = 0;  // integral of x . n / 3 dA
    for (int j = 0; j < along; ++j)
        for (int i = 0; i < around; ++i) {
            const auto corner = [&](int a, int b) {
                return surface_at(2 * pi * (i + a) / around, double(j + b) / along);
            };
            const Vec3<double> p = corner(0, 0), q = corner(1, 0), r = corner(1, 1),
                               t = corner(0, 1);
            sum += dot(p, cross(r, q)) / 6 + dot(p, cross(t, r)) / 6;
        }
    return sum * height * height * height;
}

}  // namespace knead
