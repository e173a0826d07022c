#include "host/solver/pieces.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <set>
#include <unordered_map>

namespace knead {

// Graph whose components are the pieces; a vertex is a cell with a label.
struct PieceGraph {
    std::unordered_map<std::int64_t, int> vertex;
    std::vector<std::int64_t> keys;
    std::vector<int> parent;

    int root(int v)
    {
        while (parent[std::size_t(v)] != v)
            v = parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
        return v;
    }
    void join(int a, int b)
    {
        a = root(a), b = root(b);
        if (a != b) parent[std::size_t(std::max(a, b))] = std::min(a, b);
    }
    int add(std::int64_t key)
    {
        const auto [at, fresh] = vertex.try_emplace(key, int(keys.size()));
        if (fresh) parent.push_back(int(keys.size())), keys.push_back(key);
        return at->second;
    }
};

namespace {

std::int64_t key(Int3 c, Int3 size, std::uint32_t label)
{
    return ((std::int64_t(c.z) * size.y + c.y) * size.x + c.x) * 4 + label;
}

// Fourth label: clay near a blade, whose piece is not known.
constexpr std::uint32_t unknown = 3;

bool alike(std::uint32_t a, std::uint32_t b)
{
    return a != unknown && b != unknown && (a == uncut || b == uncut || a == b);
}

// Calls visit(vertex) for every vertex within `reach` cells of vertex v, except v.
template <class Visit>
void around(const PieceGraph& g, int v, Int3 size, int reach, Visit&& visit)
{
    const std::int64_t k = g.keys[std::size_t(v)], c = k / 4;
    const Int3 at = {int(c % size.x), int(c / size.x % size.y), int(c / size.x / size.y)};
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
                for (std::uint32_t label = 0; label < 4; ++label) {
                    const Int3 n = at + Int3{x, y, z};
                    if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= size.x || n.y >= size.y) continue;
                    const auto found = g.vertex.find(key(n, size, label));
                    if (found != g.vertex.end() && found->second != v) visit(found->second);
                }
}

std::uint32_t label(const PieceGraph& g, int v)
{
    return std::uint32_t(g.keys[std::size_t(v)] % 4);
}

// `of_particle` receives the vertex of every particle.
template <class R>
PieceGraph connected(const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
                     std::vector<int>& of_particle)
{
    PieceGraph g;
    for (const Particle<R>& p : q)
        of_particle.push_back(g.add(key(lattice.cell_of(p.x), lattice.size, p.sides)));
    for (int v = 0; v < int(g.keys.size()); ++v)
        around(g, v, lattice.size, 1, [&](int n) {
            if (alike(label(g, v), label(g, n))) g.join(v, n);
        });
    return g;
}

// Numbers the pieces by descending particle count and fills the piece of every vertex; returns
// their number.
int number(PieceGraph& g, const std::vector<int>& of_particle, std::vector<int>& piece_of_vertex)
{
    std::vector<int> weight(g.keys.size(), 0), roots;
    for (const int v : of_particle) ++weight[std::size_t(g.root(v))];
    for (int v = 0; v < int(g.keys.size()); ++v)
        if (g.root(v) == v) roots.push_back(v);
    std::stable_sort(roots.begin(), roots.end(),
                     [&](int a, int b) { return weight[std::size_t(a)] > weight[std::size_t(b)]; });
    std::vector<int> rank(g.keys.size(), 0);
    for (std::size_t i = 0; i < roots.size(); ++i) rank[std::size_t(roots[i])] = int(i);
    piece_of_vertex.resize(g.keys.size());
    for (int v = 0; v < int(g.keys.size()); ++v)
        piece_of_vertex[std::size_t(v)] = rank[std::size_t(g.root(v))];
    return int(roots.size());
}

// For each piece, the pieces within a blade's reach.
std::vector<std::vector<int>> neighbours(const PieceGraph& g,
                                         const std::vector<int>& piece_of_vertex, int count,
                                         Int3 size)
{
    std::vector<std::set<int>> near(std::size_t(count), std::set<int>{});
    for (int v = 0; v < int(g.keys.size()); ++v)
        around(g, v, size, blade_reach, [&](int n) {
            const int a = piece_of_vertex[std::size_t(v)], b = piece_of_vertex[std::size_t(n)];
            if (a != b) near[std::size_t(a)].insert(b);
        });
    std::vector<std::vector<int>> all;
    all.reserve(near.size());
    for (const std::set<int>& of_one : near) all.emplace_back(of_one.begin(), of_one.end());
    return all;
}

// Pieces with faces of opposite labels close to each other: cut only partially.
std::vector<char> hinged(const PieceGraph& g, const std::vector<int>& piece_of_vertex, int count,
                         Int3 size)
{
    std::vector<char> found(std::size_t(count), 0);
    for (int v = 0; v < int(g.keys.size()); ++v)
        around(g, v, size, 2, [&](int n) {
            const auto a = piece_of_vertex[std::size_t(v)], b = piece_of_vertex[std::size_t(n)];
            if (a == b && label(g, v) + label(g, n) == above + below &&
                !alike(label(g, v), label(g, n)))
                found[std::size_t(a)] = 1;
        });
    return found;
}

// Two-colouring: breadth-first from the largest piece, each piece with neighbours gets the label
// opposite to its predecessor's. Correct wherever two labels suffice.
std::vector<std::uint32_t> coloured(const std::vector<std::vector<int>>& near)
{
    std::vector<std::uint32_t> given(near.size(), uncut);
    for (std::size_t first = 0; first < near.size(); ++first) {
        if (near[first].empty() || given[first] != uncut) continue;
        given[first] = above;
        std::vector<int> found = {int(first)};
        for (std::size_t k = 0; k < found.size(); ++k)
            for (int n : near[std::size_t(found[k])])
                if (given[std::size_t(n)] == uncut) {
                    given[std::size_t(n)] = opposite(given[std::size_t(found[k])]);
                    found.push_back(n);
                }
    }
    return given;
}

// Swaps all labels if most labels near the blade contradict those that `height` will assign. The
// pieces are unaffected.
template <class R>
void align(std::vector<Particle<R>>& q, const std::vector<R>& height)
{
    long agree = 0;
    for (std::size_t i = 0; i < q.size(); ++i)
        if (q[i].sides != uncut && height[i] != 0)
            agree += (height[i] < 0 ? below : above) == q[i].sides ? 1 : -1;
    if (agree >= 0) return;
    for (Particle<R>& p : q)
        if (p.sides != uncut) p.sides = opposite(p.sides);
}

// Particles sorted by cell, for nearest-neighbour search.
template <class R>
class Neighbourhood {
  public:
    Neighbourhood(const std::vector<Particle<R>>& particles, const Lattice<R>& of)
        : q(particles), lattice(of)
    {
        for (std::size_t i = 0; i < q.size(); ++i)
            by_cell.emplace_back(key(lattice.cell_of(q[i].x), lattice.size, 0), int(i));
        std::sort(by_cell.begin(), by_cell.end());
    }
    // The nearest particle in the 27 cells around x, preferred ones first; -1 if there is none.
    template <class Preferred>
    int nearest(Vec3<R> x, Preferred&& preferred) const
    {
        int best = -1;
        auto least = std::pair(true, R(0));
        for (int n = 0; n < 27; ++n) {
            const Int3 cell = lattice.cell_of(x) + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
            const auto k = key(cell, lattice.size, 0);
            for (auto at = std::lower_bound(by_cell.begin(), by_cell.end(), std::pair(k, 0));
                 at != by_cell.end() && at->first == k; ++at) {
                const Vec3<R> d = q[std::size_t(at->second)].x - x;
                const auto found = std::pair(!preferred(at->second), dot(d, d));
                if (best < 0 || found < least) best = at->second, least = found;
            }
        }
        return best;
    }

  private:
    const std::vector<Particle<R>>& q;
    const Lattice<R>& lattice;
    std::vector<std::pair<std::int64_t, int>> by_cell;
};

// preferred(g, i): whether particle i is preferred as the source of the label of Gaussian g.
template <class R, class Preferred>
void label_by_nearest(std::vector<Gaussian<R>>& splats, std::size_t from,
                      const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
                      Preferred&& preferred)
{
    if (from == splats.size()) return;
    const Neighbourhood<R> around(q, lattice);
    for (std::size_t k = from; k < splats.size(); ++k) {
        Gaussian<R>& g = splats[k];
        const int i = around.nearest(g.x, [&](int n) { return preferred(g, std::size_t(n)); });
        if (i >= 0) g.sides = q[std::size_t(i)].label();
    }
}

}  // namespace

template <class R>
int pieces(const std::vector<Particle<R>>& q, const Lattice<R>& lattice, std::vector<int>& piece)
{
    std::vector<int> vertex, of_vertex;
    PieceGraph g = connected(q, lattice, vertex);
    const int count = number(g, vertex, of_vertex);
    piece.resize(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) piece[i] = of_vertex[std::size_t(vertex[i])];
    return count;
}

template <class R>
void relabel(std::vector<Particle<R>>& q, const Lattice<R>& lattice)
{
    std::vector<int> vertex, piece;
    PieceGraph g = connected(q, lattice, vertex);
    const int count = number(g, vertex, piece);
    const std::vector<char> keeps = hinged(g, piece, count, lattice.size);
    const auto given = coloured(neighbours(g, piece, count, lattice.size));
    for (std::size_t i = 0; i < q.size(); ++i) {
        const auto at = std::size_t(piece[std::size_t(vertex[i])]);
        if (!keeps[at]) q[i].sides = given[at];
    }
}

template <class R>
void forget(std::vector<Particle<R>>& q, const Lattice<R>& lattice, const std::vector<R>& height)
{
    // Labels that the blade has already assigned do not separate pieces.
    std::vector<Particle<R>> before = q;
    for (std::size_t i = 0; i < q.size(); ++i)
        if (height[i] != 0) before[i].sides = unknown;
    std::vector<int> vertex, piece;
    PieceGraph g = connected(before, lattice, vertex);
    const int count = number(g, vertex, piece);
    const std::vector<char> keeps = hinged(g, piece, count, lattice.size);
    std::vector<char> met(std::size_t(count), 0), skin(g.keys.size(), 0), fresh(g.keys.size(), 0);
    for (int v = 0; v < int(g.keys.size()); ++v)
        around(g, v, lattice.size, blade_reach, [&](int n) {
            const auto a = std::size_t(piece[std::size_t(v)]),
                       b = std::size_t(piece[std::size_t(n)]);
            if (label(g, v) == unknown) {
                met[b] = 1;
                if (label(g, n) != unknown && !keeps[b]) fresh[std::size_t(v)] = 1;
            } else if (a != b && label(g, n) != unknown) {
                skin[std::size_t(v)] = 1;
            }
        });
    for (std::size_t i = 0; i < q.size(); ++i) {
        const auto v = std::size_t(vertex[i]), at = std::size_t(piece[v]);
        if (fresh[v] || (label(g, vertex[i]) != unknown && met[at] && !keeps[at] && !skin[v]))
            q[i].sides = uncut;
    }
    align(q, height);
}

template <class R>
void follow_labels(std::vector<Gaussian<R>>& splats, const std::vector<Particle<R>>& q,
                   const std::vector<std::uint32_t>& before, const Lattice<R>& lattice)
{
    label_by_nearest(splats, 0, q, lattice,
                     [&](const Gaussian<R>& g, std::size_t i) { return before[i] == g.label(); });
}

template <class R>
void take_labels(std::vector<Gaussian<R>>& splats, std::size_t from,
                 const std::vector<Particle<R>>& q, const Lattice<R>& lattice)
{
    label_by_nearest(splats, from, q, lattice,
                     [&](const Gaussian<R>& g, std::size_t i) { return q[i].object == g.object; });
}

template void follow_labels(std::vector<Gaussian<float>>&, const std::vector<Particle<float>>&,
                            const std::vector<std::uint32_t>&, const Lattice<float>&);
template void follow_labels(std::vector<Gaussian<double>>&, const std::vector<Particle<double>>&,
                            const std::vector<std::uint32_t>&, const Lattice<double>&);
template void take_labels(std::vector<Gaussian<float>>&, std::size_t,
                          const std::vector<Particle<float>>&, const Lattice<float>&);
template void take_labels(std::vector<Gaussian<double>>&, std::size_t,
                          const std::vector<Particle<double>>&, const Lattice<double>&);
template int pieces(const std::vector<Particle<float>>&, const Lattice<float>&, std::vector<int>&);
template int pieces(const std::vector<Particle<double>>&, const Lattice<double>&,
                    std::vector<int>&);
template void relabel(std::vector<Particle<float>>&, const Lattice<float>&);
template void relabel(std::vector<Particle<double>>&, const Lattice<double>&);
template void forget(std::vector<Particle<float>>&, const Lattice<float>&,
                     const std::vector<float>&);
template void forget(std::vector<Particle<double>>&, const Lattice<double>&,
                     const std::vector<double>&);

}  // namespace knead
