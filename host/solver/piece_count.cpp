#include "host/solver/piece_count.h"

#include <algorithm>

#include "cuda/contact/cut.h"

namespace knead {

// Clay of one group and label in a cell. Vertices of a cell form a list.
struct PieceVertex {
    int cell, next;
    int group;
    std::uint32_t label;
    int particles = 0;
    float fill = 0;  // share of the cell's volume [1]
    int parent = 0;
};

class PieceCells {
  public:
    explicit PieceCells(std::size_t count) : first(count, -1) {}
    std::vector<PieceVertex> all;

    void add(int cell, int group, std::uint32_t label, float share)
    {
        int at = first[std::size_t(cell)];
        while (at >= 0 && (of(at).group != group || of(at).label != label)) at = of(at).next;
        if (at < 0) {
            at = int(all.size());
            all.push_back({cell, first[std::size_t(cell)], group, label, 0, 0, at});
            first[std::size_t(cell)] = at;
        }
        ++of(at).particles, of(at).fill += share;
    }
    template <class Visit>
    void in_cell(int cell, Visit&& visit)
    {
        for (int at = first[std::size_t(cell)]; at >= 0; at = of(at).next) visit(at);
    }
    int root(int v)
    {
        while (of(v).parent != v) v = of(v).parent = of(of(v).parent).parent;
        return v;
    }
    void join(int a, int b)
    {
        a = root(a), b = root(b);
        if (a != b) of(std::max(a, b)).parent = std::min(a, b);
    }

  private:
    PieceVertex& of(int v) { return all[std::size_t(v)]; }
    std::vector<int> first;  // by cell; -1: none
};

template <class R>
std::vector<int> piece_counts(const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
                              const std::vector<Material<R>>& materials, std::span<const int> group,
                              int groups)
{
    const Int3 size = lattice.size;
    std::vector<float> share;
    for (const Material<R>& m : materials)
        share.push_back(float(m.volume / (lattice.dx * lattice.dx * lattice.dx)));
    PieceCells cells(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    const auto at = [&](Int3 c) { return (c.z * size.y + c.y) * size.x + c.x; };
    for (const Particle<R>& p : q) {
        const auto object = std::size_t(p.object);
        if (object >= group.size() || group[object] < 0) continue;
        cells.add(at(lattice.cell_of(p.x)), group[object], p.label(), share[object]);
    }
    const auto filled = [&](const PieceVertex& v) { return v.fill > float(filled_share); };
    for (int v = 0; v < int(cells.all.size()); ++v) {
        const PieceVertex from = cells.all[std::size_t(v)];
        if (!filled(from)) continue;
        const Int3 c = {from.cell % size.x, from.cell / size.x % size.y,
                        from.cell / size.x / size.y};
        for (int k = 0; k < 14; ++k) {  // the cell itself and half of its neighbours
            const Int3 n = c + Int3{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
            if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= size.x || n.y >= size.y) continue;
            cells.in_cell(at(n), [&](int other) {
                const PieceVertex& to = cells.all[std::size_t(other)];
                if (other == v || to.group != from.group || !filled(to)) return;
                if (from.label == uncut || to.label == uncut || from.label == to.label)
                    cells.join(v, other);
            });
        }
    }
    std::vector<std::size_t> weight(cells.all.size(), 0);
    for (int v = 0; v < int(cells.all.size()); ++v)
        if (filled(cells.all[std::size_t(v)]))
            weight[std::size_t(cells.root(v))] += std::size_t(cells.all[std::size_t(v)].particles);
    std::vector<int> counts(std::size_t(groups), 0);
    for (std::size_t v = 0; v < weight.size(); ++v)
        counts[std::size_t(cells.all[v].group)] += weight[v] >= fewest_particles_in_part;
    return counts;
}

template std::vector<int> piece_counts(const std::vector<Particle<float>>&, const Lattice<float>&,
                                       const std::vector<Material<float>>&, std::span<const int>,
                                       int);
template std::vector<int> piece_counts(const std::vector<Particle<double>>&, const Lattice<double>&,
                                       const std::vector<Material<double>>&, std::span<const int>,
                                       int);

}  // namespace knead
