#include "host/scene/strand.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "host/base/json_reader.h"
#include "host/scene/letters.h"

namespace knead {
namespace {

constexpr double most_in_layer = 1e6;
constexpr double farthest_behind =
    std::numbers::pi / 3;  // angle between the section's normal and the motion
constexpr double faces_within = std::numbers::sqrt2 / 2;  // cosine between axis and motion

// Of size 1: of the polygon that a section is, about the centre of its box.
std::vector<Point2> polygon_of(const Strand& s)
{
    if (s.section == SectionKind::square) return {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    if (s.section == SectionKind::outline) return s.outline;
    std::vector<Point2> star;
    for (int k = 0; k < 10; ++k) {
        const double angle = std::numbers::pi * (0.5 + k / 5.0), r = k % 2 ? 0.5 : 1;
        star.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    return star;
}

// A section as distances [m], about the nozzle's axis.
class Section {
  public:
    explicit Section(const Strand& s) : radius(s.diameter / 2)
    {
        if (s.section == SectionKind::circle) return;
        const std::vector<Point2> polygon = polygon_of(s);
        outline.emplace(std::vector<std::vector<Point2>>{polygon});
        const double longest = std::max(outline->width(), outline->height());
        scale = longest > 0 ? s.diameter / longest : 0;
    }
    double area() const
    {
        return outline ? scale * scale * outline->area() : std::numbers::pi * radius * radius;
    }
    double depth(Point2 at) const
    {
        if (!outline) return radius - std::hypot(at.x, at.y);
        return scale > 0 ? scale * outline->depth(1 / scale * at) : -1;
    }
    double reach() const
    {
        return outline ? scale * std::hypot(outline->width(), outline->height()) / 2 : radius;
    }

  private:
    double radius, scale = 0;
    std::optional<Letters> outline;
};

// Of a layer: a particle in each square of edge h that is inside, and in those squares of its rim
// that have the largest parts inside, as many as their area asks for.
std::vector<Point2> places_in(const Section& section, double h)
{
    struct Square {
        Point2 middle;  // of its part inside
        int inside;
    };
    constexpr int samples = 12;  // along an edge
    const int reach = int(std::ceil(section.reach() / h)) + 1;
    std::vector<Square> squares;
    for (int j = -reach; j < reach; ++j)
        for (int i = -reach; i < reach; ++i) {
            Square square{{0, 0}, 0};
            const Point2 centre{h * (i + 0.5), h * (j + 0.5)};
            const double depth = section.depth(centre);
            if (depth < -h) continue;
            if (depth > h) {
                squares.push_back({centre, samples * samples});
                continue;
            }
            for (int k = 0; k < samples * samples; ++k) {
                const Point2 at{h * (i + (k % samples + 0.5) / samples),
                                h * (j + (k / samples + 0.5) / samples)};
                if (section.depth(at) >= 0) square.middle = square.middle + at, ++square.inside;
            }
            if (square.inside == 0) continue;
            square.middle = 1.0 / square.inside * square.middle;
            squares.push_back(square);
        }
    std::ranges::stable_sort(squares,
                             [](const Square& a, const Square& b) { return a.inside > b.inside; });
    const auto count = std::size_t(std::max(1L, std::lround(section.area() / (h * h))));
    std::vector<Point2> places;
    for (std::size_t i = 0; i < std::min(count, squares.size()); ++i)
        places.push_back(squares[i].middle);
    return places;
}

Vec3<double> unit_or(Vec3<double> v, Vec3<double> otherwise)
{
    const double size = length(v);
    return size > 0 ? 1 / size * v : otherwise;
}

Vec3<double> across(Vec3<double> n)
{
    const Vec3<double> size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    const Vec3<double> e = size.x <= size.y && size.x <= size.z ? Vec3<double>{1, 0, 0}
                           : size.y <= size.z                   ? Vec3<double>{0, 1, 0}
                                                                : Vec3<double>{0, 0, 1};
    const Vec3<double> v = e - dot(e, n) * n;
    return 1 / length(v) * v;
}

// The nozzle on its way.
class Nozzle {
  public:
    explicit Nozzle(const Strand& of) : strand(of) {}

    // Moves to the point i of the path, in steps of at most `step`. visit(from, to, normal, u,
    // part) is called for each; `part`: of its length, along the normal [m].
    template <class Visit>
    void move_to(std::size_t i, double step, const Visit& visit)
    {
        const StrandPoint &a = strand.path[i - 1], &b = strand.path[i];
        const Vec3<double> way = b.at - a.at;
        const double whole = length(way);
        if (!(whole > 0)) return;
        const Vec3<double> motion = 1 / whole * way;
        const auto target = [&](double share) {
            const Vec3<double> axis =
                (1 - share) * unit_or(a.axis, motion) + share * unit_or(b.axis, motion);
            const double size = length(axis), along = dot(axis, motion);
            if (!(std::abs(along) >= faces_within * size) || !(size > 0)) return motion;
            return (along < 0 ? -1 : 1) / size * axis;
        };
        if (!moving) normal = target(0), side = across(normal), moving = true;
        const long steps = std::lround(std::ceil(whole / step));
        for (long k = 0; k < steps; ++k) {
            const double from = double(k) / double(steps), to = double(k + 1) / double(steps);
            turn(target(to), whole / double(steps) / strand.diameter);
            turn(motion, angle_to(motion) - farthest_behind);
            const double part = std::max(0.0, dot(normal, motion)) * whole / double(steps);
            visit(a.at + from * way, a.at + to * way, normal, side, part);
        }
    }

  private:
    double angle_to(Vec3<double> way) const
    {
        return std::acos(std::clamp(dot(normal, way), -1.0, 1.0));
    }
    // By at most `most` radians.
    void turn(Vec3<double> to, double most)
    {
        const double angle = angle_to(to);
        if (angle < 1e-9 || !(most > 0)) return;
        Vec3<double> sideways = to - dot(normal, to) * normal;
        sideways = length(sideways) > 1e-9 ? 1 / length(sideways) * sideways : side;
        const double by = std::min(angle, most), c = std::cos(by), s = std::sin(by);
        const double of_side = dot(side, sideways), of_normal = dot(side, normal);
        const Vec3<double> rest = side - of_side * sideways - of_normal * normal;
        const Vec3<double> turned = c * normal + s * sideways, beside = c * sideways - s * normal;
        side = rest + of_side * beside + of_normal * turned;
        normal = turned;
        side = side - dot(side, normal) * normal;
        side = 1 / length(side) * side, normal = 1 / length(normal) * normal;
    }

    const Strand& strand;
    Vec3<double> normal{}, side{};
    bool moving = false;
};

bool same(double a, double b)
{
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool same(Vec3<double> a, Vec3<double> b)
{
    return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

}  // namespace

bool equal(const Strand& a, const Strand& b)
{
    return a.section == b.section && same(a.diameter, b.diameter) && a.open == b.open &&
           std::ranges::equal(
               a.outline, b.outline,
               [](Point2 p, Point2 q) { return same(p.x, q.x) && same(p.y, q.y); }) &&
           std::ranges::equal(a.path, b.path, [](const StrandPoint& p, const StrandPoint& q) {
               return same(p.at, q.at) && same(p.axis, q.axis);
           });
}

std::optional<StrandFault> fault_of(const Strand& s)
{
    if (s.path.empty() || s.path.size() > most_strand_points)
        return StrandFault{"path", fmt::format("1 to {} points", most_strand_points),
                           std::to_string(s.path.size())};
    for (const StrandPoint& p : s.path)
        for (const double x : {p.at.x, p.at.y, p.at.z})
            if (!(std::abs(x) <= most_strand_extent))
                return StrandFault{"path",
                                   fmt::format("numbers from -{0} to {0}", most_strand_extent),
                                   short_number(x)};
    double length_of_path = 0;
    for (std::size_t i = 1; i < s.path.size(); ++i)
        length_of_path += length(s.path[i].at - s.path[i - 1].at);
    if (!(length_of_path <= most_strand_diameters * s.diameter))
        return StrandFault{"path", fmt::format("at most {} diameters long", most_strand_diameters),
                           short_number(length_of_path / s.diameter)};
    const bool given = s.section == SectionKind::outline;
    if (given && (s.outline.size() < 3 || s.outline.size() > most_outline_points))
        return StrandFault{"outline", fmt::format("3 to {} points", most_outline_points),
                           std::to_string(s.outline.size())};
    if (!given && !s.outline.empty())
        return StrandFault{"outline", "none but of section outline",
                           std::to_string(s.outline.size()) + " points"};
    if (given && !(Section(s).area() > 0))
        return StrandFault{"outline", "a polygon with an area", "none"};
    return {};
}

std::vector<Vec3<double>> laid(const Strand& strand, double h, std::size_t first)
{
    if (strand.path.size() < 2) return {};
    const Section section(strand);
    if (section.area() > most_in_layer * h * h)
        throw std::invalid_argument(
            fmt::format("expected a section of at most {:.0e} particles, found {:.2g}",
                        most_in_layer, section.area() / (h * h)));
    const std::vector<Point2> places = places_in(section, h);
    const double thickness = double(places.size()) * h * h * h / section.area();
    std::vector<Vec3<double>> all;
    Nozzle nozzle(strand);
    double layer = 0.5, length = 0;  // of the next layer, in layers; of all of them so far
    for (std::size_t i = 1; i < strand.path.size(); ++i)
        nozzle.move_to(i, thickness / 8,
                       [&](Vec3<double> from, Vec3<double> to, Vec3<double> normal,
                           Vec3<double> side, double part) {
                           const double before = length;
                           length += part / thickness;
                           if (length < layer) return;
                           const double share = (layer - before) / (length - before);
                           layer += 1;
                           if (i < first) return;
                           const Vec3<double> at = from + share * (to - from);
                           const Vec3<double> other = cross(normal, side);
                           for (const Point2 p : places)
                               all.push_back(at + p.x * side + p.y * other);
                       });
    return all;
}

double laid_volume(const Strand& strand)
{
    double sum = 0;
    Nozzle nozzle(strand);
    for (std::size_t i = 1; i < strand.path.size(); ++i)
        nozzle.move_to(i, strand.diameter / 8,
                       [&](Vec3<double>, Vec3<double>, Vec3<double>, Vec3<double>, double part) {
                           sum += part;
                       });
    return sum * Section(strand).area();
}

double reach_of(const Strand& strand) { return Section(strand).reach(); }

double distance_from(const Strand& strand, Vec3<double> x)
{
    double nearest = length(x - strand.path.at(0).at);
    for (std::size_t i = 1; i < strand.path.size(); ++i) {
        const Vec3<double> a = strand.path[i - 1].at, way = strand.path[i].at - a;
        const double square = dot(way, way);
        if (!(square > 0)) continue;
        const double share = std::clamp(dot(x - a, way) / square, 0.0, 1.0);
        nearest = std::min(nearest, length(x - (a + share * way)));
    }
    return nearest;
}

}  // namespace knead
