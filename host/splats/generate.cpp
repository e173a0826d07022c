#include "host/splats/generate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "cuda/math/box.h"
#include "host/base/parallel.h"

namespace knead {
namespace {

using std::numbers::pi;
using V = Vec3<double>;

// Random numbers of one splat, independent of those of others.  [Steele 2014]
class Random {
  public:
    Random(std::uint64_t seed, std::uint64_t stream) : state(mixed(seed) ^ mixed(~stream)) {}
    double in(double low, double high) { return low + (high - low) * unit(); }
    double normal()  // [Box 1958]
    {
        const double r = std::sqrt(-2 * std::log(1 - unit()));
        return r * std::cos(2 * pi * unit());
    }
    V normals()
    {
        const double x = normal(), y = normal(), z = normal();
        return {x, y, z};
    }
    V within(V low, V high)
    {
        const double x = in(low.x, high.x), y = in(low.y, high.y), z = in(low.z, high.z);
        return {x, y, z};
    }
    Quat<double> turn()
    {
        const double w = normal(), x = normal(), y = normal(), z = normal();
        return knead::unit(Quat<double>{w, x, y, z});
    }
    double unit() { return double(next() >> 11) * 0x1p-53; }

  private:
    static std::uint64_t mixed(std::uint64_t x)
    {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
        return x ^ (x >> 31);
    }
    std::uint64_t next() { return mixed(state += 0x9e3779b97f4a7c15ull); }
    std::uint64_t state;
};

const Box3<double> room{{-3, -2.6, -4}, {3, 1.4, 4}};  // [m]; y is down

// One splat before it is added to the cloud.
struct Made {
    V x, scale;
    Quat<double> q;
    double opacity;
    bool object;
};

Made of_object(Random& r)
{
    const double azimuth = r.in(0, 2 * pi), height = r.in(-1, 1), polar = std::acos(height);
    const double radius = 0.2 * (1 + 0.03 * std::sin(5 * azimuth) * std::sin(4 * polar) +
                                 0.02 * std::sin(9 * azimuth + 1) * std::sin(7 * polar)) +
                          0.001 * r.normal();
    const double across = std::sin(polar);
    Made s;
    s.x = radius * V{across * std::cos(azimuth), height, across * std::sin(azimuth)};
    s.scale = r.within({0.002, 0.002, 0.002}, {0.006, 0.006, 0.006});
    s.q = r.turn(), s.opacity = r.in(0.7, 0.995), s.object = true;
    return s;
}

// Random point on the box's surface, and the axis normal to it there.
V on_box(Random& r, const Box3<double>& b, int& axis)
{
    const V d = edges(b);
    const double x = d.y * d.z, y = x + d.x * d.z, all = y + d.x * d.y, u = r.in(0, all);
    V p = r.within(b.low, b.high);
    const bool far = r.unit() < 0.5;
    axis = u < x ? 0 : u < y ? 1 : 2;
    if (axis == 0) p.x = far ? b.high.x : b.low.x;
    if (axis == 1) p.y = far ? b.high.y : b.low.y;
    if (axis == 2) p.z = far ? b.high.z : b.low.z;
    const double off = 0.02 * r.normal();
    return p + V{axis == 0 ? off : 0, axis == 1 ? off : 0, axis == 2 ? off : 0};
}

// Rotation that maps z to that axis, after a random rotation about z.
Quat<double> facing(Random& r, int axis)
{
    const double h = std::sqrt(0.5);
    const std::array<Quat<double>, 3> to{{{h, 0, h, 0}, {h, -h, 0, 0}, {1, 0, 0, 0}}};
    return to[std::size_t(axis)] * turn_about(V{0, 0, 1}, r.in(0, 2 * pi));
}

std::vector<Box3<double>> boxes(std::uint64_t seed)
{
    Random r(seed, ~0ull);
    std::vector<Box3<double>> all;
    while (all.size() < 24) {
        const V side = r.within({0.3, 0.3, 0.3}, {1.2, 1.2, 1.2});
        V c = r.within(room.low, room.high);
        if (std::hypot(c.x, c.z) < 2) continue;
        c.y = room.high.y - side.y / 2;
        all.push_back({c - 0.5 * side, c + 0.5 * side});
    }
    return all;
}

// `share` selects the position: below 0.7 on a wall, below 0.9 on a box, otherwise floating.
Made of_room(Random& r, double share, double median, const std::vector<Box3<double>>& boxes)
{
    Made s;
    int axis = -1;
    if (share < 0.7)
        s.x = on_box(r, room, axis);
    else if (share < 0.9)
        s.x = on_box(r, boxes[std::size_t(r.in(0, 24)) % 24], axis);
    else
        do s.x = r.within(room.low, room.high);
        while (length(s.x) < 1.5);
    const double base = std::log(median) + 0.7 * r.normal();
    const V spread = r.normals();
    const auto scale = [&](double t, double times) {
        return std::clamp(times * std::exp(base + 0.5 * t), 0.0005, 0.3);
    };
    s.scale = {scale(spread.x, 1), scale(spread.y, 1), scale(spread.z, axis < 0 ? 1 : 0.3)};
    s.q = axis < 0 ? r.turn() : facing(r, axis);
    s.opacity = std::clamp(std::pow(r.unit(), 2.0 / 3), 0.01, 0.99);  // Beta(1.5, 1)
    s.object = false;
    return s;
}

// Spherical harmonics: a colour that varies as waves through space, and noise in the higher bands.
void add_colour(const Made& s, Random& r, Vec3<float>* sh)
{
    const double times = s.object ? 6 : 1;
    const std::array<V, 3> wave{{{7, 3, 5}, {4, 8, 3}, {3, 5, 9}}};  // [1/m]
    const auto base = [&](int k, double phase) {
        const double c = 0.5 + 0.3 * std::sin(times * dot(wave[std::size_t(k)], s.x) + phase);
        return (std::clamp(c + 0.08 * r.normal(), 0.05, 0.95) - 0.5) / sh_constant;
    };
    const double red = base(0, 0.3), green = base(1, 1.7), blue = base(2, 4.1);
    sh[0] = cast<float>(V{red, green, blue});
    for (int k = 1; k < harmonics(max_sh_degree); ++k)
        sh[k] = cast<float>((k < 4 ? 0.05 : k < 9 ? 0.03 : 0.02) * r.normals());
}

// Rotation to the axes right, down, forward, without roll.
Mat3<double> looking(V forward, V up)
{
    const V f = (1 / length(forward)) * forward, across = cross(f, up);
    const V right =
        length(across) > 1e-6 * length(up) ? (1 / length(across)) * across : orthogonal(f);
    return {right, cross(f, right), f};
}

}  // namespace

const std::vector<SplatLoad>& splat_loads()
{
    static const std::vector<SplatLoad> loads{
        {"100k", 60000, 40000, 0.01},
        {"382k", 60000, 322000, 0.01},
        {"480k", 60000, 420000, 0.01},
        {"660k", 60000, 600000, 0.01},
        {"5m-coarse", 60000, 4940000, 0.01},
        // Same covered area as the room of 660k.
        {"5m-fine", 60000, 4940000, 0.01 * std::sqrt(600.0 / 4940)}};
    return loads;
}

SplatCloud generated(const SplatLoad& load)
{
    const long n = long(load.object) + long(load.background);
    const auto count = std::size_t(n), each = std::size_t(harmonics(max_sh_degree));
    SplatCloud c;
    c.degree = max_sh_degree;
    c.centre.resize(count), c.rotation.resize(count), c.scale.resize(count);
    c.opacity.resize(count), c.sh.resize(count * each);
    const std::vector<Box3<double>> furniture = boxes(load.seed);
    parallel_for(n, [&](long k) {
        const auto i = std::size_t(k);
        Random r(load.seed, i);
        const double share = double(k - load.object) / double(std::max(load.background, 1));
        // The splats of the room are shuffled, so that neighbours in memory are not neighbours in
        // space.
        const double shuffled = std::fmod(share * load.background * 0.6180339887498949, 1.0);
        const Made s =
            k < load.object ? of_object(r) : of_room(r, shuffled, load.median, furniture);
        c.centre[i] = cast<float>(s.x), c.scale[i] = cast<float>(s.scale);
        c.rotation[i] = cast<float>(s.q), c.opacity[i] = float(s.opacity);
        add_colour(s, r, &c.sh[i * each]);
    });
    return c;
}

Eye<float> eye_looking(Vec3<double> from, Vec3<double> to, double width_tangent, int width,
                       int height, Vec3<double> up)
{
    const double h = width_tangent * height / width;
    return {cast<float>(from),
            cast<float>(quaternion(looking(to - from, up))),
            float(-width_tangent),
            float(width_tangent),
            float(-h),
            float(h),
            width,
            height};
}

std::vector<Eye<float>> load_eyes(const std::string& view, int width, int height)
{
    const double distance = view == "far"      ? 0.6
                            : view == "near45" ? 0.45
                            : view == "near"   ? 0.25
                                               : 0;
    if (distance == 0) throw std::invalid_argument("views are far, near45 and near, not " + view);
    const double yaw = 12 * pi / 180, pitch = 8 * pi / 180;
    const V forward{std::sin(yaw) * std::cos(pitch), std::sin(pitch),
                    std::cos(yaw) * std::cos(pitch)};
    const V head = -distance * forward, right = looking(forward, {0, -1, 0}).a;
    std::vector<Eye<float>> eyes;
    for (const double side : {-0.032, 0.032}) {
        const V at = head + side * right;
        eyes.push_back(eye_looking(at, at + forward, std::tan(48 * pi / 180), width, height));
    }
    return eyes;
}

}  // namespace knead
