#include "host/scene/solid_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "cuda/math/rotation.h"
#include "host/base/parallel.h"
#include "host/scene/closed_surface.h"

namespace knead {
namespace {

constexpr int node_triangles = 6;                  // of a leaf
constexpr std::size_t few_triangles = 10000;       // whose sides are looked at one by one
constexpr double dipole_beyond = 2.3;              // radii of a node
constexpr int lattice_part = 16, least_cells = 2;  // cells of a lattice along an edge of a part
constexpr double most_nodes = 1 << 27;

Box3<float> float_box(const Box3<double>& box)
{
    constexpr float most = std::numeric_limits<float>::max();
    const auto down = [](double x) { return std::nextafter(float(x), -most); };
    const auto up = [](double x) { return std::nextafter(float(x), most); };
    return {{down(box.low.x), down(box.low.y), down(box.low.z)},
            {up(box.high.x), up(box.high.y), up(box.high.z)}};
}

double squared_distance_to(const Box3<float>& box, Vec3<double> x)
{
    const auto off = [](double low, double at, double high) {
        return std::max(0.0, std::max(low - at, at - high));
    };
    const Vec3<double> d{off(box.low.x, x.x, box.high.x), off(box.low.y, x.y, box.high.y),
                         off(box.low.z, x.z, box.high.z)};
    return dot(d, d);
}

// The nearest point of a triangle a, a + ab, a + ac is in one of seven regions [Ericson 2004].
double squared_distance_to(Vec3<double> a, Vec3<double> ab, Vec3<double> ac, Vec3<double> at)
{
    const Vec3<double> p = at - a;
    const auto from = [&](double v, double w) {
        const Vec3<double> d = p - v * ab - w * ac;
        return dot(d, d);
    };
    const double d1 = dot(ab, p), d2 = dot(ac, p);
    if (d1 <= 0 && d2 <= 0) return from(0, 0);
    const Vec3<double> q = p - ab;
    const double d3 = dot(ab, q), d4 = dot(ac, q);
    if (d3 >= 0 && d4 <= d3) return from(1, 0);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return from(d1 / (d1 - d3), 0);
    const Vec3<double> r = p - ac;
    const double d5 = dot(ab, r), d6 = dot(ac, r);
    if (d6 >= 0 && d5 <= d6) return from(0, 1);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return from(0, d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        const double w = (d4 - d3) / (d4 - d3 + d5 - d6);
        return from(1 - w, w);
    }
    const double sum = va + vb + vc;
    return from(vb / sum, vc / sum);
}

// Solid angle of a triangle [Van Oosterom, Strackee 1983].
double solid_angle(Vec3<double> a, Vec3<double> b, Vec3<double> c)
{
    const double la = length(a), lb = length(b), lc = length(c);
    const double whole = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return 2 * std::atan2(dot(a, cross(b, c)), whole);
}

double shell_depth(double depth, double wall)
{
    return wall > 0 ? std::min(depth, wall - depth) : depth;
}

}  // namespace

int SolidMesh::add_node(const std::vector<Triangle>& all, std::vector<int>& order, int begin,
                        int end)
{
    Box3<double> box = empty_box<double>(), middles = box;
    Vec3<double> dipole{}, middle{};
    double area = 0;
    for (int i = begin; i < end; ++i) {
        const Triangle& t = all[std::size_t(order[std::size_t(i)])];
        grow(box, t.a), grow(box, t.a + t.ab), grow(box, t.a + t.ac);
        const Vec3<double> third = t.a + (1.0 / 3) * (t.ab + t.ac), n = 0.5 * cross(t.ab, t.ac);
        grow(middles, third);
        const double own = length(n);
        dipole = dipole + n, middle = middle + own * third, area += own;
    }
    middle = area > 0 ? (1 / area) * middle : 0.5 * (box.low + box.high);
    const Vec3<double> to_corner = greater(box.high - middle, middle - box.low);
    const int node = int(nodes_.size());
    nodes_.push_back({float_box(box), begin, end - begin, cast<float>(middle), cast<float>(dipole),
                      float(dipole_beyond * length(to_corner))});
    if (end - begin <= node_triangles) return node;
    const Vec3<double> size = middles.high - middles.low;
    const Vec3<double> along = size.x >= size.y && size.x >= size.z ? Vec3<double>{1, 0, 0}
                               : size.y >= size.z                   ? Vec3<double>{0, 1, 0}
                                                                    : Vec3<double>{0, 0, 1};
    const auto key = [&](int i) {
        const Triangle& t = all[std::size_t(i)];
        return std::pair{dot(along, 3.0 * t.a + t.ab + t.ac), i};
    };
    const int half = (begin + end) / 2;
    std::nth_element(order.begin() + begin, order.begin() + half, order.begin() + end,
                     [&](int a, int b) { return key(a) < key(b); });
    add_node(all, order, begin, half);
    const int second = add_node(all, order, half, end);
    nodes_[std::size_t(node)].first = second, nodes_[std::size_t(node)].count = 0;
    return node;
}

// The first `count` of them, and their nodes.
void SolidMesh::add_triangles(const std::vector<Int3>& triangles, std::size_t count)
{
    std::vector<Triangle> all;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3<double> a = vertices_[std::size_t(triangles[i].x)];
        all.push_back({a, vertices_[std::size_t(triangles[i].y)] - a,
                       vertices_[std::size_t(triangles[i].z)] - a});
    }
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    nodes_.clear(), triangles_.clear();
    add_node(all, order, 0, int(count));
    for (const int i : order) triangles_.push_back(all[std::size_t(i)]);
}

MadeSolid SolidMesh::make(const std::vector<Vec3<double>>& vertices,
                          const std::vector<Int3>& triangles, Quat<double> own)
{
    if (triangles.size() > most_triangles)
        return {nullptr,
                fmt::format("{} triangles, more than {}", triangles.size(), most_triangles)};
    // Of the corners, upright.
    std::vector<Vec3<double>> placed(vertices.size());
    Box3<double> box = empty_box<double>();
    for (const Int3 t : triangles)
        for (const int v : {t.x, t.y, t.z}) {
            Vec3<double>& x = placed[std::size_t(v)];
            x = rotate(own, vertices[std::size_t(v)]), grow(box, x);
        }
    const Vec3<double> size = box.high - box.low, middle = 0.5 * box.low + 0.5 * box.high;
    const double extent = std::max({size.x, size.y, size.z}), scale = 1 / extent;
    if (triangles.empty() || !(extent > 0) || !std::isfinite(extent) || !std::isfinite(scale))
        return {nullptr, "none with an extent"};
    for (Vec3<double>& x : placed) x = scale * (x - middle);
    ClosedSurface surface = closed_surface(placed, triangles);
    if (!(surface.area > 0)) return {nullptr, "none with an area"};
    auto solid = std::make_shared<SolidMesh>();
    solid->extent_ = extent, solid->half_ = 0.5 * scale * size, solid->holes_ = surface.holes;
    solid->vertices_ = std::move(surface.vertices);
    const std::vector<Vec3<double>>& v = solid->vertices_;
    if (surface.holes > 0) {
        solid->add_triangles(surface.triangles, surface.stated);
        double open = 0, largest = 0;
        Vec3<double> edge{};
        for (std::size_t i = surface.stated; i < surface.triangles.size(); ++i) {
            const Int3 t = surface.triangles[i];
            const Vec3<double> a = v[std::size_t(t.x)], b = v[std::size_t(t.y)],
                               c = v[std::size_t(t.z)];
            const double area = length(cross(b - a, c - a)) / 2,
                         around = std::abs(solid->winding((1.0 / 3) * (a + b + c)));
            // Elsewhere the hole is in another piece, or outside.
            if (!(around > 0.2 && around < 0.8)) continue;
            open += area;
            if (area > largest) largest = area, edge = 0.5 * (b + c);
        }
        const Vec3<double> x = rotate(conjugate(own), extent * edge + middle);
        if (open > most_open * surface.area)
            return {nullptr, fmt::format("one with holes of {:.3g} % of its area; an edge of the "
                                         "largest is at ({:.6g}, {:.6g}, {:.6g})",
                                         100 * open / surface.area, x.x, x.y, x.z)};
    }
    solid->add_triangles(surface.triangles, surface.triangles.size());
    double six = 0;
    for (const Int3 t : surface.triangles)
        six += dot(v[std::size_t(t.x)], cross(v[std::size_t(t.y)], v[std::size_t(t.z)]));
    const Vec3<double> all = solid->size();
    solid->volume_ = std::abs(six / 6);
    if (surface.pieces > 1 && surface.triangles.size() < few_triangles)
        solid->volume_ = std::abs(solid->volume_of_pieces());
    else if (surface.pieces > 1 && solid->volume_ < 1e-3 * all.x * all.y * all.z)
        solid->volume_ = solid->sampled_volume(0, 96);  // some may be inside out
    if (!(solid->volume_ > 1e-9)) return {nullptr, "none that encloses a volume"};
    return {std::move(solid), ""};
}

double SolidMesh::distance(Vec3<double> at, double within, int& nearest) const
{
    const auto squared = [&](int i) {
        const Triangle& t = triangles_[std::size_t(i)];
        return squared_distance_to(t.a, t.ab, t.ac, at);
    };
    double best = within * within;
    if (nearest >= 0) best = std::min(best, squared(nearest));
    struct Waiting {
        int node;
        double squared;
    };
    Waiting stack[64];
    int height = 0;
    stack[height++] = {0, squared_distance_to(nodes_[0].box, at)};
    while (height > 0) {
        const Waiting top = stack[--height];
        if (top.squared >= best) continue;
        const Node& node = nodes_[std::size_t(top.node)];
        if (node.count > 0) {
            for (int i = node.first; i < node.first + node.count; ++i)
                if (const double one = squared(i); one < best) best = one, nearest = i;
            continue;
        }
        const int first = top.node + 1;
        Waiting one{first, squared_distance_to(nodes_[std::size_t(first)].box, at)},
            other{node.first, squared_distance_to(nodes_[std::size_t(node.first)].box, at)};
        if (one.squared < other.squared) std::swap(one, other);
        stack[height++] = one, stack[height++] = other;
    }
    return std::sqrt(best);
}

double SolidMesh::winding(Vec3<double> at) const
{
    double angle = 0;
    int stack[64], height = 0;
    stack[height++] = 0;
    while (height > 0) {
        const int number = stack[--height];
        const Node& node = nodes_[std::size_t(number)];
        const Vec3<double> d = cast<double>(node.middle) - at;
        const double squared = dot(d, d);
        if (squared > double(node.far) * double(node.far)) {
            angle += dot(d, cast<double>(node.dipole)) / (squared * std::sqrt(squared));
            continue;
        }
        if (node.count == 0) {
            stack[height++] = number + 1, stack[height++] = node.first;
            continue;
        }
        for (int i = node.first; i < node.first + node.count; ++i) {
            const Triangle& t = triangles_[std::size_t(i)];
            const Vec3<double> a = t.a - at;
            angle += solid_angle(a, a + t.ab, a + t.ac);
        }
    }
    return angle / (4 * std::numbers::pi);
}

// Of what pieces enclose that may overlap, or turn their inside out: of triangles with the inside
// on one side alone, by their middle.
double SolidMesh::volume_of_pieces() const
{
    constexpr std::size_t part = 1024;
    std::vector<double> sums((triangles_.size() + part - 1) / part);
    parallel_for(sums.size(), [&](std::size_t k) {
        for (std::size_t i = k * part; i < std::min(triangles_.size(), (k + 1) * part); ++i) {
            const Triangle& t = triangles_[i];
            const Vec3<double> n = cross(t.ab, t.ac);
            const double size = length(n);
            if (!(size > 0)) continue;
            const Vec3<double> beside = t.a + (1.0 / 3) * (t.ab + t.ac) + (1e-7 / size) * n;
            const long before = std::lround(winding(beside)), behind = before + 1;
            const double own = dot(t.a, n) / 6;
            if (before == 0 || behind == 0) sums[k] += behind != 0 ? own : -own;
        }
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

bool SolidMesh::inside(Vec3<double> at) const
{
    const auto off = [](double x, double half) { return std::abs(x) > half; };
    if (off(at.x, half_.x) || off(at.y, half_.y) || off(at.z, half_.z)) return false;
    return std::abs(winding(at)) > 0.5;
}

double SolidMesh::depth(Vec3<double> at) const
{
    const auto off = [](double x, double half) { return std::max(0.0, std::abs(x) - half); };
    const double beyond =
        length(Vec3<double>{off(at.x, half_.x), off(at.y, half_.y), off(at.z, half_.z)});
    if (!(beyond < exact_within)) return -beyond;
    int nearest = -1;
    const double away = distance(at, 4, nearest);
    return inside(at) ? away : -away;
}

double SolidMesh::depth(Vec3<double> at, double wall) const { return shell_depth(depth(at), wall); }

// From the depths at the middles of the n^3 cubes of a grid.
double SolidMesh::sampled_volume(double wall, int n) const
{
    const double step = 1.0 / n;
    const DepthLattice lattice(*this, wall, step, 2 * step);
    std::vector<double> layers(static_cast<std::size_t>(n));
    parallel_for(n, LoopOptions{.chunk = 1}, [&](int z) {
        for (int i = 0; i < n * n; ++i) {
            const Vec3<double> x{(i % n + 0.5) * step - 0.5, (i / n + 0.5) * step - 0.5,
                                 (z + 0.5) * step - 0.5};
            layers[std::size_t(z)] += std::clamp(0.5 + lattice.depth(x) / step, 0.0, 1.0);
        }
    });
    return step * step * step * std::accumulate(layers.begin(), layers.end(), 0.0);
}

double SolidMesh::volume(double wall) const
{
    if (!(wall > 0)) return volume_;
    const std::lock_guard lock(mutex_);
    for (const auto& [known, share] : hollow_)
        if (known == wall) return share;
    const int n = int(std::clamp(std::ceil(3 / wall), 64.0, 128.0));
    hollow_.emplace_back(wall, std::min(volume_, sampled_volume(wall, n)));
    return hollow_.back().second;
}

std::pair<double, double> SolidMesh::reach(Vec3<double> along) const
{
    double low = 0, high = 0;
    for (const Vec3<double>& x : vertices_) {
        const double at = dot(x, along);
        low = std::min(low, at), high = std::max(high, at);
    }
    return {low, high};
}

std::size_t SolidMesh::bytes() const
{
    const auto of = [](const auto& all) { return all.size() * sizeof all[0]; };
    return of(vertices_) + of(triangles_) + of(nodes_);
}

// What is known of a place, and with it of those around.
struct DepthLattice::Known {
    Vec3<double> at;
    double away;  // distance to the surface
    bool inside;
    int nearest;  // triangle; -1: unknown
};

DepthLattice::DepthLattice(const SolidMesh& solid, double wall, double spacing, double within)
{
    const Vec3<double> half = 0.5 * solid.size();
    const auto cells = [&](double reach) {
        const double blocks =
            std::ceil(2 * (reach + within + 2 * spacing) / spacing / lattice_part);
        return lattice_part * std::max(1.0, blocks);
    };
    while (cells(half.x) * cells(half.y) * cells(half.z) > most_nodes) spacing *= 1.1;
    spacing_ = spacing;
    size_ = {int(cells(half.x)) + 1, int(cells(half.y)) + 1, int(cells(half.z)) + 1};
    low_ = -0.5 * spacing *
           Vec3<double>{double(size_.x - 1), double(size_.y - 1), double(size_.z - 1)};
    depths_.resize(std::size_t(size_.x) * std::size_t(size_.y) * std::size_t(size_.z));
    const Int3 blocks{(size_.x - 1) / lattice_part, (size_.y - 1) / lattice_part,
                      (size_.z - 1) / lattice_part};
    parallel_for(blocks.x * blocks.y * blocks.z, LoopOptions{.chunk = 1}, [&](int i) {
        const Int3 first =
            lattice_part * Int3{i % blocks.x, i / blocks.x % blocks.y, i / blocks.x / blocks.y};
        const Vec3<double> x = place(first);
        fill(solid, wall, within, first, lattice_part, look(solid, x, {x, 0, false, -1}));
    });
}

// The distance differs by at most the way between two places, and the side only where the surface
// is as near.
DepthLattice::Known DepthLattice::look(const SolidMesh& solid, Vec3<double> at, const Known& from)
{
    const double way = from.nearest < 0 ? 4 : length(at - from.at);
    Known found{at, 0, from.inside, from.nearest};
    found.away = solid.distance(at, from.away + 1.0001 * way, found.nearest);
    if (way >= from.away) found.inside = solid.inside(at);
    return found;
}

// Cells from the node `first` on, `cells` along each edge. The last nodes along an axis belong to
// the last cells.
void DepthLattice::fill(const SolidMesh& solid, double wall, double within, Int3 first, int cells,
                        const Known& from)
{
    const auto end_of = [&](int low, int size) {
        return low + cells + 1 == size ? size : low + cells;
    };
    const Int3 end{end_of(first.x, size_.x), end_of(first.y, size_.y), end_of(first.z, size_.z)};
    const auto each = [&](auto&& visit) {
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) visit(Int3{x, y, z});
    };
    const auto depth_of = [&](const Known& k) {
        return shell_depth(k.inside ? k.away : -k.away, wall);
    };
    const Known middle =
        look(solid, place(first) + 0.5 * cells * spacing_ * Vec3<double>{1, 1, 1}, from);
    const double depth = depth_of(middle),
                 bound = std::abs(depth) - 0.8660254037844387 * cells * spacing_;
    if (bound > within)  // so are all its nodes: they get bounds
        return each([&](Int3 n) { depths_[at(n)] = float(std::copysign(bound, depth)); });
    if (cells == least_cells) {
        Known before = middle;
        return each([&](Int3 n) {
            const Vec3<double> x = place(n);
            const auto slack = [&](const Known& k) { return k.away - length(x - k.at); };
            before = look(solid, x, slack(before) > slack(middle) ? before : middle);
            depths_[at(n)] = float(depth_of(before));
        });
    }
    const int half = cells / 2;
    for (int k = 0; k < 8; ++k)
        fill(solid, wall, within, first + half * Int3{k & 1, k >> 1 & 1, k >> 2}, half, middle);
}

double DepthLattice::depth(Vec3<double> x) const
{
    const Vec3<double> p = (1 / spacing_) * (x - low_);
    const auto outside = [](double at, int size) { return !(at >= 0 && at < size - 1); };
    if (outside(p.x, size_.x) || outside(p.y, size_.y) || outside(p.z, size_.z)) {
        const Vec3<double> high{double(size_.x - 1), double(size_.y - 1), double(size_.z - 1)};
        const Vec3<double> off = greater(greater(-1.0 * p, p - high), Vec3<double>{0, 0, 0});
        return -spacing_ * (2 + length(off));
    }
    const Int3 n{int(p.x), int(p.y), int(p.z)};
    const Vec3<double> w = p - Vec3<double>{double(n.x), double(n.y), double(n.z)};
    const float* const d = depths_.data() + at(n);
    const std::size_t y = std::size_t(size_.x), z = y * std::size_t(size_.y);
    const auto row = [&](std::size_t from) {
        return (1 - w.x) * double(d[from]) + w.x * double(d[from + 1]);
    };
    return (1 - w.z) * ((1 - w.y) * row(0) + w.y * row(y)) +
           w.z * ((1 - w.y) * row(z) + w.y * row(z + y));
}

}  // namespace knead
