#include "pieces.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <unordered_map>

namespace knead {
namespace {

// A cell and a label: the vertices of the graph whose components are the pieces.
struct Graph {
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

template <class R>
Int3 cell(const Particle<R>& q, const Lattice<R>& lattice)
{
    const R s = 1 / lattice.dx;
    return {int(s * q.x.x), int(s * q.x.y), int(s * q.x.z)};
}

std::int64_t key(Int3 c, Int3 size, std::uint32_t label)
{
    return ((std::int64_t(c.z) * size.y + c.y) * size.x + c.x) * 4 + label;
}

bool alike(std::uint32_t a, std::uint32_t b) { return a == uncut || b == uncut || a == b; }

// Calls visit(vertex) for every vertex within `reach` cells of vertex v, v itself left out.
template <class Visit>
void around(const Graph& g, int v, Int3 size, int reach, Visit&& visit)
{
    const std::int64_t k = g.keys[std::size_t(v)], c = k / 4;
    const Int3 at = {int(c % size.x), int(c / size.x % size.y), int(c / size.x / size.y)};
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
                for (std::uint32_t label = 0; label < 3; ++label) {
                    const Int3 n = at + Int3{x, y, z};
                    if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= size.x || n.y >= size.y) continue;
                    const auto found = g.vertex.find(key(n, size, label));
                    if (found != g.vertex.end() && found->second != v) visit(found->second);
                }
}

template <class R>
Graph connected(const std::vector<Particle<R>>& q, const Lattice<R>& lattice)
{
    Graph g;
    for (const Particle<R>& p : q) g.add(key(cell(p, lattice), lattice.size, p.sides));
    for (int v = 0; v < int(g.keys.size()); ++v)
        around(g, v, lattice.size, 1, [&](int n) {
            if (alike(std::uint32_t(g.keys[std::size_t(v)] % 4),
                      std::uint32_t(g.keys[std::size_t(n)] % 4)))
                g.join(v, n);
        });
    return g;
}

// Piece of every vertex, the most particles first.
template <class R>
int number(Graph& g, const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
           std::vector<int>& piece_of_vertex)
{
    std::vector<int> weight(g.keys.size(), 0), roots;
    for (const Particle<R>& p : q)
        ++weight[std::size_t(g.root(g.vertex.at(key(cell(p, lattice), lattice.size, p.sides))))];
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

}  // namespace

template <class R>
int pieces(const std::vector<Particle<R>>& q, const Lattice<R>& lattice, std::vector<int>& piece)
{
    Graph g = connected(q, lattice);
    std::vector<int> of_vertex;
    const int count = number(g, q, lattice, of_vertex);
    piece.resize(q.size());
    for (std::size_t i = 0; i < q.size(); ++i)
        piece[i] =
            of_vertex[std::size_t(g.vertex.at(key(cell(q[i], lattice), lattice.size, q[i].sides)))];
    return count;
}

template <class R>
void relabel(std::vector<Particle<R>>& q, const Lattice<R>& lattice)
{
    Graph g = connected(q, lattice);
    std::vector<int> piece;
    const auto count = std::size_t(number(g, q, lattice, piece));
    std::vector<unsigned> labels(count, 0);
    for (std::size_t v = 0; v < g.keys.size(); ++v)
        labels[std::size_t(piece[v])] |= 1u << (g.keys[v] % 4);
    std::vector<std::vector<int>> near(count);
    for (int v = 0; v < int(g.keys.size()); ++v)
        around(g, v, lattice.size, blade_reach, [&](int n) {
            const int a = piece[std::size_t(v)], b = piece[std::size_t(n)];
            if (a != b) near[std::size_t(a)].push_back(b);
        });
    const unsigned both = 1u << above | 1u << below;
    std::vector<std::uint32_t> given(count, uncut);
    std::vector<char> keeps(count, 0);
    for (std::size_t p = 0; p < count; ++p) {
        keeps[p] = (labels[p] & both) == both;  // still one piece round the end of a cut
        if (keeps[p] || near[p].empty()) continue;
        unsigned taken = 0;
        for (int n : near[p])
            if (std::size_t(n) < p && !keeps[std::size_t(n)]) taken |= 1u << given[std::size_t(n)];
        given[p] = taken & 1u << above ? below : above;
    }
    for (Particle<R>& p : q) {
        const auto at = std::size_t(
            piece[std::size_t(g.vertex.at(key(cell(p, lattice), lattice.size, p.sides)))]);
        if (!keeps[at]) p.sides = given[at];
    }
}

template <class R>
void forget(std::vector<Particle<R>>& q, const Lattice<R>& lattice,
            const std::vector<char>& touched)
{
    std::vector<int> piece;
    const auto count = std::size_t(pieces(q, lattice, piece));
    std::vector<unsigned> labels(count, 0);
    std::vector<char> met(count, 0);
    for (std::size_t i = 0; i < q.size(); ++i) {
        labels[std::size_t(piece[i])] |= 1u << q[i].sides;
        met[std::size_t(piece[i])] |= touched[i];
    }
    for (std::size_t i = 0; i < q.size(); ++i) {
        const auto p = std::size_t(piece[i]);
        if (met[p] && (labels[p] == 1u << above || labels[p] == 1u << below)) q[i].sides = uncut;
    }
}

template int pieces(const std::vector<Particle<float>>&, const Lattice<float>&, std::vector<int>&);
template int pieces(const std::vector<Particle<double>>&, const Lattice<double>&,
                    std::vector<int>&);
template void relabel(std::vector<Particle<float>>&, const Lattice<float>&);
template void relabel(std::vector<Particle<double>>&, const Lattice<double>&);
template void forget(std::vector<Particle<float>>&, const Lattice<float>&,
                     const std::vector<char>&);
template void forget(std::vector<Particle<double>>&, const Lattice<double>&,
                     const std::vector<char>&);

}  // namespace knead
