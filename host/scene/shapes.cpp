#include "host/scene/shapes.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "cuda/math/rotation.h"
#include "host/base/json_reader.h"
#include "host/scene/letters.h"
#include "host/scene/solid_mesh.h"
#include "host/scene/strand.h"

namespace knead {
namespace {

constexpr double pi = std::numbers::pi, nowhere = -std::numeric_limits<double>::infinity();

// Distance in the shapes' own frames, with r: the distance from the y axis.

double depth_of_cone(Vec3<double> reach, double r, double y)
{
    const double side = (reach.y - y) * reach.x - 2 * reach.y * r;
    return min(reach.y + y, side / std::hypot(reach.x, 2 * reach.y));
}

double depth_of_rounded_box(Vec3<double> reach, double rounding, Vec3<double> d)
{
    const Vec3<double> q{std::abs(d.x) - reach.x + rounding, std::abs(d.y) - reach.y + rounding,
                         std::abs(d.z) - reach.z + rounding};
    const Vec3<double> out{max(q.x, 0.0), max(q.y, 0.0), max(q.z, 0.0)};
    return rounding - length(out) - min(max(q.x, max(q.y, q.z)), 0.0);
}

// The nearest point of the surface is x_i = r_i^2 d_i / (t + r_i^2) with the largest root t of
// sum (r_i d_i / (t + r_i^2))^2 = 1 [Eberly 2013]. The left side is convex and falls, so that
// Newton's method ascends to the root from a place where it is above 1.
double depth_of_ellipsoid(Vec3<double> reach, Vec3<double> d)
{
    const double least = min(reach.x, min(reach.y, reach.z)), off = 1e-9 * least;
    const Vec3<double> p{max(std::abs(d.x), off), max(std::abs(d.y), off), max(std::abs(d.z), off)},
        square{reach.x * reach.x, reach.y * reach.y, reach.z * reach.z};
    double t =
        max(reach.x * p.x - square.x, max(reach.y * p.y - square.y, reach.z * p.z - square.z));
    Vec3<double> v{};
    for (int k = 0; k < 60; ++k) {
        v = {p.x / (t + square.x), p.y / (t + square.y), p.z / (t + square.z)};
        const Vec3<double> w{reach.x * v.x, reach.y * v.y, reach.z * v.z};
        const double f = dot(w, w) - 1;
        const double slope = 2 * (w.x * w.x / (t + square.x) + w.y * w.y / (t + square.y) +
                                  w.z * w.z / (t + square.z));
        if (!(f > 1e-14)) break;
        t += f / slope;
    }
    return -t * length(v);
}

double depth_of_text(const Object& o, Vec3<double> d)
{
    if (!o.letters) return nowhere;
    const double capital = o.size.y;
    return min(o.size.z / 2 - std::abs(d.z),
               capital * o.letters->depth({d.x / capital, d.y / capital}));
}

// Of the tube around its path that its section turns in.
double depth_of_strand(const Object& o, Vec3<double> d)
{
    return o.strand ? reach_of(*o.strand) - distance_from(*o.strand, d) : nowhere;
}
Box3<double> box_of_strand(const Object& o)
{
    Box3<double> box{o.centre, o.centre};
    if (!o.strand) return box;
    box = empty_box<double>();
    for (const StrandPoint& p : o.strand->path) {
        const Vec3<double> at = o.centre + rotate(o.rotation, p.at);
        box = {lesser(box.low, at), greater(box.high, at)};
    }
    const double reach = reach_of(*o.strand);
    const Vec3<double> beside{reach, reach, reach};
    return {box.low - beside, box.high + beside};
}

double depth_of_mesh(const Object& o, Vec3<double> d)
{
    if (!o.solid) return nowhere;
    const double all = mesh_extent(o);
    return all * o.solid->depth((1 / all) * d, o.mesh.hollow / all);
}

// Lowest and highest place along an axis, from the object's centre. `x`, `y`, `z`: cosines between
// the axis and those of the object.
struct Reach {
    double low, high;
};
Reach reach_along(const Object& o, double x, double y, double z)
{
    if (o.shape == ShapeKind::cone) {
        const double apex = y * o.size.y / 2, disc = std::sqrt(max(0.0, 1 - y * y)) * o.size.x / 2;
        return {min(apex, -apex - disc), max(apex, -apex + disc)};
    }
    if (o.shape == ShapeKind::mesh) {
        if (!o.solid) return {0, 0};
        const auto [low, high] = o.solid->reach({x, y, z});
        return {mesh_extent(o) * low, mesh_extent(o) * high};
    }
    if (!o.letters) return {0, 0};
    const auto [low, high] = o.letters->reach({x, y});
    const double face = std::abs(z) * o.size.z / 2;
    return {o.size.y * low - face, o.size.y * high + face};
}
// Per axis, of those that are not the same on both sides of their centre: cone, text and mesh.
template <class Of>
Vec3<double> by_reach(const Object& o, const Of& of)
{
    const Mat3<double> R = rotation(o.rotation);
    return {of(reach_along(o, R.a.x, R.b.x, R.c.x)), of(reach_along(o, R.a.y, R.b.y, R.c.y)),
            of(reach_along(o, R.a.z, R.b.z, R.c.z))};
}

// Full extents in the object's frame.
Vec3<double> text_size(const Object& o)
{
    if (!o.letters) return {0, 0, 0};
    return {o.size.y * o.letters->width(), o.size.y * o.letters->height(), o.size.z};
}

Vec3<double> box_extents(const Mat3<double>& R, Vec3<double> s)
{
    const auto along = [&](double x, double y, double z) {
        return std::abs(x) * s.x + std::abs(y) * s.y + std::abs(z) * s.z;
    };
    return {along(R.a.x, R.b.x, R.c.x), along(R.a.y, R.b.y, R.c.y), along(R.a.z, R.b.z, R.c.z)};
}

// Of what has the axis y, by the cosine between that and each axis.
template <class Along>
Vec3<double> round_extents(const Mat3<double>& R, const Along& along)
{
    return {along(R.b.x), along(R.b.y), along(R.b.z)};
}

double sine(double cosine) { return std::sqrt(max(0.0, 1 - cosine * cosine)); }

}  // namespace

double depth(const Object& o, Vec3<double> x)
{
    const Vec3<double> d = rotate(conjugate(o.rotation), x - o.centre), half = 0.5 * o.size;
    switch (o.shape) {
        case ShapeKind::box:
            return min(half.x - std::abs(d.x), min(half.y - std::abs(d.y), half.z - std::abs(d.z)));
        case ShapeKind::cylinder:
            return min(half.y - std::abs(d.y), half.x - std::hypot(d.x, d.z));
        case ShapeKind::splats:
            return nowhere;
        case ShapeKind::ellipsoid:
            return depth_of_ellipsoid(half, d);
        case ShapeKind::rounded_box:
            return depth_of_rounded_box(half, o.rounding, d);
        case ShapeKind::cone:
            return depth_of_cone(half, std::sqrt(d.x * d.x + d.z * d.z), d.y);
        case ShapeKind::capsule:
            return half.x -
                   length(Vec3<double>{d.x, max(0.0, std::abs(d.y) - (half.y - half.x)), d.z});
        case ShapeKind::torus: {
            const double off = std::sqrt(d.x * d.x + d.z * d.z) - (half.x - half.y);
            return half.y - std::sqrt(off * off + d.y * d.y);
        }
        case ShapeKind::text:
            return depth_of_text(o, d);
        case ShapeKind::strand:
            return depth_of_strand(o, d);
        case ShapeKind::mesh:
            return depth_of_mesh(o, d);
        case ShapeKind::sphere:
            break;
    }
    return half.x - length(d);
}

bool inside(const Object& o, Vec3<double> x) { return depth(o, x) >= 0; }

Vec3<double> extents(const Object& o)
{
    const Mat3<double> R = rotation(o.rotation);
    const Vec3<double> s = o.size;
    switch (o.shape) {
        case ShapeKind::box:
            return box_extents(R, s);
        case ShapeKind::cylinder:
            // The axis, and a disc that is seen at the angle between its normal and each axis.
            return round_extents(
                R, [&](double axis) { return std::abs(axis) * s.y + sine(axis) * s.x; });
        case ShapeKind::ellipsoid: {
            const auto along = [&](double x, double y, double z) {
                return length(Vec3<double>{x * s.x, y * s.y, z * s.z});
            };
            return {along(R.a.x, R.b.x, R.c.x), along(R.a.y, R.b.y, R.c.y),
                    along(R.a.z, R.b.z, R.c.z)};
        }
        case ShapeKind::rounded_box: {
            const double ball = 2 * o.rounding;
            const Vec3<double> all{ball, ball, ball};
            return box_extents(R, s - all) + all;
        }
        case ShapeKind::cone:
        case ShapeKind::text:
        case ShapeKind::mesh:
            return by_reach(o, [](Reach reach) { return reach.high - reach.low; });
        case ShapeKind::capsule:
            return round_extents(R,
                                 [&](double axis) { return std::abs(axis) * (s.y - s.x) + s.x; });
        case ShapeKind::torus:
            return round_extents(R, [&](double axis) { return sine(axis) * (s.x - s.y) + s.y; });
        case ShapeKind::strand: {
            const Box3<double> box = box_of_strand(o);
            return box.high - box.low;
        }
        case ShapeKind::splats:
        case ShapeKind::sphere:
            break;
    }
    return s;
}

Vec3<double> middle_of(const Object& o)
{
    if (o.given) return o.given->middle;
    if (o.shape == ShapeKind::strand) {
        const Box3<double> box = box_of_strand(o);
        return 0.5 * (box.low + box.high);
    }
    if (o.shape != ShapeKind::cone && o.shape != ShapeKind::text && o.shape != ShapeKind::mesh)
        return o.centre;
    return o.centre + by_reach(o, [](Reach reach) { return (reach.low + reach.high) / 2; });
}

Box3<double> box_of(const Object& o)
{
    const Vec3<double> half = 0.5 * extents(o), middle = middle_of(o);
    return {middle - half, middle + half};
}

double shape_volume(const Object& o)
{
    const Vec3<double> s = o.size;
    const double box = s.x * s.y * s.z;
    switch (o.shape) {
        case ShapeKind::box:
            return box;
        case ShapeKind::cylinder:
            return box * pi / 4;
        case ShapeKind::splats:
            return o.given ? o.given->volume * double(o.given->particles.size()) : 0;
        case ShapeKind::rounded_box: {
            const double r = o.rounding, x = s.x - 2 * r, y = s.y - 2 * r, z = s.z - 2 * r;
            return x * y * z + 2 * r * (x * y + y * z + z * x) + pi * r * r * (x + y + z) +
                   4 * pi / 3 * r * r * r;
        }
        case ShapeKind::cone:
            return box * pi / 12;
        case ShapeKind::capsule:
            return pi / 4 * s.x * s.x * (s.y - s.x) + pi / 6 * s.x * s.x * s.x;
        case ShapeKind::torus:
            return pi * pi / 4 * (s.x - s.y) * s.y * s.y;
        case ShapeKind::text:
            return o.letters ? o.letters->area() * s.y * s.y * s.z : 0;
        case ShapeKind::strand:
            return o.strand ? laid_volume(*o.strand) : 0;
        case ShapeKind::mesh: {
            const double all = mesh_extent(o);
            return o.solid ? all * all * all * o.solid->volume(o.mesh.hollow / all) : 0;
        }
        case ShapeKind::ellipsoid:
        case ShapeKind::sphere:
            break;
    }
    return box * pi / 6;
}

void add_letters(Object& o)
{
    o.letters = o.shape == ShapeKind::text ? letters_of(o.text).letters : nullptr;
}

double mesh_extent(const Object& o)
{
    if (o.mesh.size > 0) return o.mesh.size;
    return o.solid ? o.mesh.scale * o.solid->file_extent() : 0;
}

std::optional<ShapeFault> shape_fault(const Object& o)
{
    const Vec3<double> s = o.size;
    const auto at_most = [](const char* what, double limit) {
        return fmt::format("{} {} m", what, short_number(limit));
    };
    switch (o.shape) {
        case ShapeKind::rounded_box: {
            const double most = min(s.x, min(s.y, s.z)) / 2;
            if (o.rounding >= 0 && o.rounding <= most) return {};
            return ShapeFault{"rounding",
                              at_most("at least 0 and at most half the least side,", most),
                              short_number(o.rounding)};
        }
        case ShapeKind::capsule:
            if (s.y >= s.x) return {};
            return ShapeFault{"height", at_most("at least the diameter,", s.x), short_number(s.y)};
        case ShapeKind::torus:
            if (s.y < s.x / 2) return {};
            return ShapeFault{"tube", at_most("less than half the diameter,", s.x / 2),
                              short_number(s.y)};
        case ShapeKind::text: {
            const std::string expected =
                fmt::format("a text of at most {} characters with an outline", most_letters);
            if (!o.letters) return ShapeFault{"text", expected, letters_of(o.text).why};
            const Vec3<double> whole = text_size(o);
            if (max(whole.x, whole.y) <= largest_extent) return {};
            return ShapeFault{"height",
                              fmt::format("a text of at most {} m", short_number(largest_extent)),
                              fmt::format("{:.4g} x {:.4g} m", whole.x, whole.y)};
        }
        case ShapeKind::strand: {
            if (!o.strand) return ShapeFault{"path", "points", "none"};
            const auto fault = fault_of(*o.strand);
            if (!fault) return {};
            return ShapeFault{fault->key, fault->expected, fault->found};
        }
        case ShapeKind::mesh: {
            if ((o.mesh.size > 0) == (o.mesh.scale > 0))
                return ShapeFault{"size", "either a size or a scale",
                                  o.mesh.size > 0 ? "both" : "neither"};
            const double all = mesh_extent(o);
            if (all <= largest_extent) return {};
            return ShapeFault{o.mesh.size > 0 ? "size" : "scale",
                              fmt::format("a mesh of at most {} m", short_number(largest_extent)),
                              fmt::format("{:.4g} m", all)};
        }
        default:
            return {};
    }
}

}  // namespace knead
