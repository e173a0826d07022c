// Which bodies share a velocity field: there are few fields, and more bodies, but only those that
// are near each other need fields of their own.  (25c)
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "cuda/mpm/body_graph.h"
#include "cuda/mpm/particle.h"

namespace knead {

// Which bodies are near each other, by bins of 2 x 2 x 2 cells: their clay is in the same bin or
// in adjacent ones, or in bins two apart. Symmetric.
struct BodyGraph {
    std::array<std::uint64_t, most_bodies> touching{}, near{};  // bits of bodies, by body
    bool operator==(const BodyGraph&) const = default;
};
// body: by object, negative for none.
template <class R>
BodyGraph body_graph(const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
                     const std::vector<int>& body);

struct Colouring {
    std::vector<int> colour;  // by body, from 1
    int welded = 0;           // pairs that touch and share a colour
};
// Bodies that touch have different colours as far as `colours` suffice, and then those that are
// near. Depends on the graph alone.
Colouring coloured(const BodyGraph& graph, int bodies, int colours);

}  // namespace knead
