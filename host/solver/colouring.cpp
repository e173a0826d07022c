#include "host/solver/colouring.h"

#include <bit>

namespace knead {
namespace {

// Calls visit(bit) for the bits of a mask.
template <class Visit>
void for_each_bit(std::uint64_t mask, Visit&& visit)
{
    for (; mask; mask &= mask - 1) visit(std::countr_zero(mask));
}

}  // namespace

template <class R>
BodyGraph body_graph(const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
                     const std::vector<int>& body)
{
    const Int3 bins = bins_of(lattice.size);
    std::vector<std::uint64_t> masks(std::size_t(bins.x) * std::size_t(bins.y) *
                                     std::size_t(bins.z));
    std::vector<int> occupied;
    for (const Particle<R>& p : q) {
        const int own = body[std::size_t(p.object)];
        if (own < 0) continue;
        const Int3 c = lattice.cell_of(p.x);
        const int at = bin_index({c.x / bin_edge, c.y / bin_edge, c.z / bin_edge}, bins);
        std::uint64_t& mask = masks[std::size_t(at)];
        if (mask == 0) occupied.push_back(at);
        mask |= std::uint64_t(1) << own;
    }
    BodyGraph graph;
    for (const int at : occupied) {
        const Int3 bin = {at % bins.x, at / bins.x % bins.y, at / bins.x / bins.y};
        const BodiesAround around = bodies_around(
            bin, bins, [&](Int3 n) { return masks[std::size_t(bin_index(n, bins))]; });
        for_each_bit(masks[std::size_t(at)], [&](int b) {
            const std::uint64_t others = ~(std::uint64_t(1) << b);
            graph.touching[std::size_t(b)] |= around.touching & others;
            graph.near[std::size_t(b)] |= around.near & others;
        });
    }
    return graph;
}

// The body whose neighbours have most colours already comes first, by those that touch, then by
// those that are near; of equal ones that with most neighbours, then the first. [Brelaz 1979]
Colouring coloured(const BodyGraph& graph, int bodies, int colours)
{
    Colouring result;
    std::vector<int>& colour = result.colour;
    colour.assign(std::size_t(bodies), 0);
    const auto colours_in = [&](std::uint64_t mask) {
        unsigned found = 0;
        for_each_bit(mask, [&](int b) { found |= 1u << colour[std::size_t(b)]; });
        return found & ~1u;  // 0: none yet
    };
    for (int step = 0; step < bodies; ++step) {
        int best = -1;
        std::array<int, 4> most{};
        for (int b = 0; b < bodies; ++b) {
            if (colour[std::size_t(b)]) continue;
            const std::uint64_t beside = graph.touching[std::size_t(b)],
                                around = graph.near[std::size_t(b)];
            const std::array<int, 4> own = {std::popcount(colours_in(beside)),
                                            std::popcount(colours_in(around)),
                                            std::popcount(beside), std::popcount(around)};
            if (best < 0 || own > most) best = b, most = own;
        }
        int chosen = 1;
        std::array<int, 2> least{};
        for (int c = 1; c <= colours; ++c) {
            std::array<int, 2> conflicts{};
            for_each_bit(graph.touching[std::size_t(best)],
                         [&](int b) { conflicts[0] += colour[std::size_t(b)] == c; });
            for_each_bit(graph.near[std::size_t(best)],
                         [&](int b) { conflicts[1] += colour[std::size_t(b)] == c; });
            if (c == 1 || conflicts < least) chosen = c, least = conflicts;
        }
        colour[std::size_t(best)] = chosen;
        result.welded += least[0];
    }
    return result;
}

template BodyGraph body_graph(const std::vector<Particle<float>>&, const Lattice<float>&,
                              const std::vector<int>&);
template BodyGraph body_graph(const std::vector<Particle<double>>&, const Lattice<double>&,
                              const std::vector<int>&);

}  // namespace knead
