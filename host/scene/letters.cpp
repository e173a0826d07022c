#include "host/scene/letters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "host/base/font_file.h"

namespace knead {
namespace {

constexpr double coincident = 1e-9;    // [capitals]
constexpr double smallest = 1.0 / 64;  // half of the edge of a square that is not divided
constexpr std::size_t few = 4;         // edges: not divided either
constexpr double exact_within = 1;     // around the outline: distances are exact there

struct Segment {
    Point2 a, b;
    std::vector<std::pair<double, Point2>> cuts;  // by their place along it, 0 to 1
};

std::vector<Segment> segments_of(const std::vector<std::vector<Point2>>& contours)
{
    std::vector<Segment> all;
    for (const std::vector<Point2>& c : contours)
        for (std::size_t i = 0; i < c.size(); ++i) {
            const Point2 a = c[i], b = c[(i + 1) % c.size()];
            if (a.x != b.x || a.y != b.y) all.push_back({a, b, {}});
        }
    return all;
}

// Cuts a segment at a point on it.
void cut(Segment& s, double t, Point2 at)
{
    if (t > coincident && t < 1 - coincident) s.cuts.emplace_back(t, at);
}

// Cuts two segments where they meet.
void cut(Segment& s, Segment& o)
{
    const Point2 r = s.b - s.a, q = o.b - o.a, w = o.a - s.a;
    const double den = cross(r, q);
    if (std::abs(den) > coincident * std::sqrt(dot(r, r) * dot(q, q))) {
        const double t = cross(w, q) / den, u = cross(w, r) / den;
        if (t < -coincident || t > 1 + coincident || u < -coincident || u > 1 + coincident) return;
        const Point2 at = t <= coincident       ? s.a
                          : t >= 1 - coincident ? s.b
                          : u <= coincident     ? o.a
                          : u >= 1 - coincident ? o.b
                                                : s.a + t * r;
        cut(s, t, at), cut(o, u, at);
    } else if (std::abs(cross(w, r)) <= coincident * std::sqrt(dot(r, r))) {  // on one line
        cut(s, dot(o.a - s.a, r) / dot(r, r), o.a), cut(s, dot(o.b - s.a, r) / dot(r, r), o.b);
        cut(o, dot(s.a - o.a, q) / dot(q, q), s.a), cut(o, dot(s.b - o.a, q) / dot(q, q), s.b);
    }
}

void cut_all(std::vector<Segment>& all)
{
    std::ranges::sort(all, {}, [](const Segment& s) { return std::min(s.a.x, s.b.x); });
    for (std::size_t i = 0; i < all.size(); ++i) {
        Segment& s = all[i];
        const double right = std::max(s.a.x, s.b.x);
        const auto [low, high] = std::minmax(s.a.y, s.b.y);
        for (std::size_t k = i + 1; k < all.size(); ++k) {
            Segment& o = all[k];
            if (std::min(o.a.x, o.b.x) > right) break;
            if (std::max(o.a.y, o.b.y) >= low && std::min(o.a.y, o.b.y) <= high) cut(s, o);
        }
    }
    for (Segment& s : all) std::ranges::sort(s.cuts, {}, [](const auto& one) { return one.first; });
}

// How often the outline goes around a point.
int winding(const std::vector<Segment>& all, Point2 at)
{
    int n = 0;
    for (const Segment& s : all) {
        if ((s.a.y <= at.y) == (s.b.y <= at.y)) continue;
        const bool left = cross(s.b - s.a, at - s.a) > 0, up = s.b.y > s.a.y;
        if (left == up) n += up ? 1 : -1;
    }
    return n;
}

// Parts of the segments that have what is filled on one side alone, on their left.
std::vector<std::pair<Point2, Point2>> boundary_of(std::vector<Segment> all)
{
    constexpr double beside = 1e-6;
    cut_all(all);
    std::vector<std::pair<Point2, Point2>> parts;
    const auto add = [&](Point2 a, Point2 b) {
        const Point2 d = b - a;
        const double size = std::sqrt(dot(d, d));
        if (size <= coincident) return;
        const Point2 off = beside / size * Point2{-d.y, d.x}, middle = 0.5 * (a + b);
        const bool left = winding(all, middle + off) != 0, right = winding(all, middle - off) != 0;
        if (left && !right) parts.emplace_back(a, b);
        if (right && !left) parts.emplace_back(b, a);
    };
    for (const Segment& s : all) {
        Point2 from = s.a;
        for (const auto& [t, at] : s.cuts) add(std::exchange(from, at), at);
        add(from, s.b);
    }
    // Where outlines lie on each other, a part is there twice.
    const auto key = [](const auto& p) {
        return std::array{p.first.x, p.first.y, p.second.x, p.second.y};
    };
    std::ranges::sort(parts, {}, key);
    const auto [last, end] = std::ranges::unique(parts, {}, key);
    parts.erase(last, end);
    return parts;
}

}  // namespace

Letters::Letters(const std::vector<std::vector<Point2>>& contours)
{
    const auto parts = boundary_of(segments_of(contours));
    if (parts.empty()) return;
    Point2 low = parts[0].first, high = low;
    for (const auto& [a, b] : parts)
        for (const Point2 p : {a, b}) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
    width_ = high.x - low.x, height_ = high.y - low.y;
    const Point2 middle = 0.5 * (low + high);
    std::map<std::pair<double, double>, Point2> normals;
    const auto outwards = [](Point2 a, Point2 b) {
        const Point2 d = b - a;
        return 1 / std::sqrt(dot(d, d)) * Point2{d.y, -d.x};
    };
    for (const auto& [a, b] : parts)
        for (const Point2 p : {a, b}) {
            Point2& n = normals.try_emplace({p.x, p.y}, Point2{0, 0}).first->second;
            n = n + outwards(a, b);
        }
    std::vector<int> near;
    for (const auto& [a, b] : parts) {
        const Point2 d = b - a;
        const double length = std::sqrt(dot(d, d));
        const Edge edge{
            a - middle, b - middle, 1 / length * d, normals.at({a.x, a.y}), normals.at({b.x, b.y}),
            length};
        area_ += cross(edge.a, edge.b) / 2;
        near.push_back(int(edges_.size()));
        edges_.push_back(edge);
    }
    half_ = std::max(width_, height_) / 2 + exact_within;
    squares_.emplace_back();
    divide(0, {0, 0}, half_, near);
}

Letters::Nearest Letters::nearest(const Edge& e, Point2 at)
{
    const Point2 p = at - e.a, q = at - e.b;
    const double t = dot(p, e.along), left = cross(e.along, p);
    if (t <= 0) return {dot(p, p), -dot(p, e.normal_a)};
    if (t >= e.length) return {dot(q, q), -dot(q, e.normal_b)};
    return {left * left, left};
}

// `near`: edges among which the nearest of each point in the square is.
void Letters::divide(int square, Point2 centre, double half, const std::vector<int>& near)
{
    std::vector<double> distances;
    Nearest best{1e300, 0};
    for (const int i : near) {
        const Nearest one = nearest(edges_[std::size_t(i)], centre);
        distances.push_back(std::sqrt(one.squared));
        if (one.squared < best.squared) best = one;
    }
    const double diagonal = 1.4142135623730951 * half, distance = std::sqrt(best.squared);
    if (distance - diagonal > exact_within) {
        squares_[std::size_t(square)].depth = std::copysign(distance, best.depth);
        return;
    }
    std::vector<int> nearer;
    for (std::size_t i = 0; i < near.size(); ++i)
        if (distances[i] <= distance + 2 * diagonal + coincident) nearer.push_back(near[i]);
    if (nearer.size() <= few || half <= smallest) {
        squares_[std::size_t(square)].begin = int(near_.size());
        near_.insert(near_.end(), nearer.begin(), nearer.end());
        squares_[std::size_t(square)].end = int(near_.size());
        return;
    }
    const int first = int(squares_.size());
    squares_[std::size_t(square)].first = first;
    squares_.resize(squares_.size() + 4);
    for (int k = 0; k < 4; ++k)
        divide(first + k, centre + half / 2 * Point2{k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0},
               half / 2, nearer);
}

double Letters::depth(Point2 at) const
{
    const Point2 beyond{std::abs(at.x) - width_ / 2, std::abs(at.y) - height_ / 2};
    if (std::max(beyond.x, beyond.y) >= exact_within)
        return -std::hypot(std::max(0.0, beyond.x), std::max(0.0, beyond.y));
    Point2 centre{0, 0};
    double half = half_;
    const Square* square = squares_.data();
    while (square->first >= 0) {
        half /= 2;
        const int right = at.x >= centre.x, up = at.y >= centre.y;
        centre = centre + half * Point2{right ? 1.0 : -1.0, up ? 1.0 : -1.0};
        square = &squares_[std::size_t(square->first + right + 2 * up)];
    }
    if (square->begin == square->end) {
        const Point2 d = at - centre;
        const double bound = std::abs(square->depth) - std::sqrt(dot(d, d));
        return std::copysign(std::max(0.0, bound), square->depth);
    }
    Nearest best{1e300, 0};
    for (int i = square->begin; i < square->end; ++i) {
        const Nearest one = nearest(edges_[std::size_t(near_[std::size_t(i)])], at);
        if (one.squared < best.squared) best = one;
    }
    return std::copysign(std::sqrt(best.squared), best.depth);
}

std::pair<double, double> Letters::reach(Point2 along) const
{
    double low = 0, high = 0;
    for (const Edge& e : edges_) {
        const double at = dot(e.a, along);
        low = std::min(low, at), high = std::max(high, at);
    }
    return {low, high};
}

MadeLetters letters_of(const std::string& text)
{
    constexpr std::size_t most = 64;
    static std::mutex mutex;
    static std::map<std::string, std::shared_ptr<const Letters>> kept;
    const std::lock_guard lock(mutex);
    if (const auto at = kept.find(text); at != kept.end()) return {at->second, ""};
    GlyphOutlines outlines = glyph_outlines(text, font_file());
    if (!outlines.fault.empty()) return {nullptr, std::move(outlines.fault)};
    auto made = std::make_shared<const Letters>(outlines.contours);
    if (!(made->area() > 0)) return {nullptr, "characters without an area"};
    if (kept.size() >= most) kept.clear();
    return {kept[text] = std::move(made), ""};
}

}  // namespace knead
