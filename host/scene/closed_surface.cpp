#include "host/scene/closed_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace knead {
namespace {

// One vertex for each place that triangles have.
void weld(const std::vector<Vec3<double>>& vertices, const std::vector<Int3>& triangles,
          ClosedSurface& to)
{
    const auto key = [&](int v) {
        const Vec3<double>& x = vertices[std::size_t(v)];
        return std::array{x.x, x.y, x.z};
    };
    std::vector<int> order, number(vertices.size());
    for (const Int3 t : triangles)
        for (const int v : {t.x, t.y, t.z})
            if (!std::exchange(number[std::size_t(v)], 1)) order.push_back(v);
    std::ranges::sort(order, [&](int a, int b) {
        const auto ka = key(a), kb = key(b);
        return ka != kb ? ka < kb : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || key(order[i]) != key(order[i - 1]))
            to.vertices.push_back(vertices[std::size_t(order[i])]);
        number[std::size_t(order[i])] = int(to.vertices.size()) - 1;
    }
    for (const Int3 t : triangles) {
        const auto of = [&](int v) { return number[std::size_t(v)]; };
        const Int3 welded{of(t.x), of(t.y), of(t.z)};
        if (welded.x != welded.y && welded.y != welded.z && welded.z != welded.x)
            to.triangles.push_back(welded);
    }
}

// A side of a triangle, by its lower and its higher vertex.
struct TriangleSide {
    int low, high, triangle;
    bool rises;  // from low to high
};
std::vector<TriangleSide> sides_of(const std::vector<Int3>& triangles)
{
    std::vector<TriangleSide> all;
    all.reserve(3 * triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Int3 t = triangles[i];
        for (const auto& [a, b] : {std::pair{t.x, t.y}, {t.y, t.z}, {t.z, t.x}})
            all.push_back({std::min(a, b), std::max(a, b), int(i), a < b});
    }
    std::ranges::sort(all, {}, [](const TriangleSide& s) {
        return std::array{s.low, s.high, s.triangle};
    });
    return all;
}
// Calls visit(first, last) for the sides of each edge.
template <class Visit>
void each_edge(const std::vector<TriangleSide>& sides, Visit&& visit)
{
    for (std::size_t i = 0, k = 0; i < sides.size(); i = k) {
        while (k < sides.size() && sides[k].low == sides[i].low && sides[k].high == sides[i].high)
            ++k;
        visit(i, k);
    }
}

void orient(ClosedSurface& surface)
{
    struct Neighbour {
        int triangle;
        bool alike;
    };
    const std::vector<TriangleSide> sides = sides_of(surface.triangles);
    std::vector<std::array<Neighbour, 3>> near(surface.triangles.size(),
                                               {Neighbour{-1, true}, {-1, true}, {-1, true}});
    const auto add = [&](int to, Neighbour other) {
        for (Neighbour& n : near[std::size_t(to)])
            if (n.triangle < 0) return (void)(n = other);
    };
    each_edge(sides, [&](std::size_t first, std::size_t last) {
        if (last - first != 2) return;
        const TriangleSide &a = sides[first], &b = sides[first + 1];
        add(a.triangle, {b.triangle, a.rises != b.rises});
        add(b.triangle, {a.triangle, a.rises != b.rises});
    });
    enum : char { unknown, kept, turned };
    std::vector<char> state(surface.triangles.size(), unknown);
    std::vector<int> piece;
    for (std::size_t i = 0; i < state.size(); ++i) {
        if (state[i] != unknown) continue;
        piece.assign(1, int(i)), state[i] = kept;
        std::size_t turns = 0;
        ++surface.pieces;
        for (std::size_t k = 0; k < piece.size(); ++k) {
            const auto t = std::size_t(piece[k]);
            turns += state[t] == turned;
            for (const Neighbour n : near[t]) {
                if (n.triangle < 0 || state[std::size_t(n.triangle)] != unknown) continue;
                const bool turn = (state[t] == turned) == n.alike;
                state[std::size_t(n.triangle)] = turn ? turned : kept;
                piece.push_back(n.triangle);
            }
        }
        const char least = 2 * turns > piece.size() ? kept : turned;
        for (const int t : piece)
            if (state[std::size_t(t)] == least)
                std::swap(surface.triangles[std::size_t(t)].y, surface.triangles[std::size_t(t)].z);
    }
}

double area_of(Vec3<double> a, Vec3<double> b, Vec3<double> c)
{
    return length(cross(b - a, c - a)) / 2;
}

// Closes a border, of which each vertex leads to the next.
void close_hole(ClosedSurface& to, const std::vector<int>& border)
{
    if (border.size() < 3) return;
    const auto at = [&](std::size_t i) {
        return to.vertices[std::size_t(border[i % border.size()])];
    };
    Vec3<double> middle{};
    for (std::size_t i = 0; i < border.size(); ++i)
        middle = middle + (1.0 / double(border.size())) * at(i);
    if (border.size() == 3) {
        to.triangles.push_back({border[0], border[1], border[2]});
    } else {
        const int centre = int(to.vertices.size());
        for (std::size_t i = 0; i < border.size(); ++i) {
            to.triangles.push_back({centre, border[i], border[(i + 1) % border.size()]});
        }
        to.vertices.push_back(middle);
    }
    ++to.holes;
}

// As many edges lead to a vertex as away from it, since triangles have closed borders: a way along
// them ends where it began. It is cut into loops that pass a vertex once.
void close_holes(ClosedSurface& surface)
{
    struct Lead {
        int from, to;
    };
    std::vector<Lead> leads;
    const std::vector<TriangleSide> sides = sides_of(surface.triangles);
    each_edge(sides, [&](std::size_t first, std::size_t last) {
        int rises = 0;
        for (std::size_t k = first; k < last; ++k) rises += sides[k].rises ? 1 : -1;
        const auto [low, high] = std::pair{sides[first].low, sides[first].high};
        for (int k = 0; k < std::abs(rises); ++k)
            leads.push_back(rises > 0 ? Lead{high, low} : Lead{low, high});
    });
    if (leads.empty()) return;
    std::ranges::sort(leads, {}, [](const Lead& l) { return std::pair{l.from, l.to}; });
    const auto first_of = [&](int vertex) {
        return std::size_t(std::ranges::lower_bound(leads, vertex, {}, &Lead::from) -
                           leads.begin());
    };
    std::vector<char> used(leads.size());
    std::vector<std::size_t> next(leads.size());  // by the first lead of a vertex: those used
    std::vector<int> place(surface.vertices.size(), -1);  // in the path
    std::vector<int> path, loop;
    for (std::size_t i = 0; i < leads.size(); ++i) {
        if (used[i]) continue;
        path.assign(1, leads[i].from), place[std::size_t(leads[i].from)] = 0;
        while (!path.empty()) {
            const std::size_t group = first_of(path.back());
            const bool there = group < leads.size() && leads[group].from == path.back();
            while (there && group + next[group] < leads.size() && used[group + next[group]] &&
                   leads[group + next[group]].from == path.back())
                ++next[group];
            const std::size_t lead = there ? group + next[group] : leads.size();
            if (lead >= leads.size() || leads[lead].from != path.back()) {
                place[std::size_t(path.back())] = -1, path.pop_back();  // all loops are closed
                continue;
            }
            used[lead] = 1;
            const int to = leads[lead].to;
            if (place[std::size_t(to)] < 0) {
                place[std::size_t(to)] = int(path.size()), path.push_back(to);
                continue;
            }
            const auto from = path.begin() + place[std::size_t(to)];
            loop.assign(from, path.end());
            for (auto v = from + 1; v != path.end(); ++v) place[std::size_t(*v)] = -1;
            path.erase(from + 1, path.end());
            close_hole(surface, loop);
        }
    }
}

}  // namespace

ClosedSurface closed_surface(const std::vector<Vec3<double>>& vertices,
                             const std::vector<Int3>& triangles)
{
    ClosedSurface surface;
    weld(vertices, triangles, surface);
    orient(surface);
    for (const Int3 t : surface.triangles)
        surface.area +=
            area_of(surface.vertices[std::size_t(t.x)], surface.vertices[std::size_t(t.y)],
                    surface.vertices[std::size_t(t.z)]);
    surface.stated = surface.triangles.size();
    close_holes(surface);
    return surface;
}

}  // namespace knead
