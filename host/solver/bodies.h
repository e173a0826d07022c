// Bodies: clay of unlike categories that has velocity fields of its own.  (25a)
#pragma once
#include <vector>

#include "cuda/mpm/body_contact.h"
#include "host/solver/setup.h"

namespace knead {

// The colour of each object's clay: categories with clay of their own, numbered from 1 in ascending
// order. 0: all clay shares one field, because contact welds or there is one category.
struct Bodies {
    std::vector<int> colour;  // by object
    int colours = 0;          // 0, or 2 to most_colours
    // 1 / density of a colour [m^3/kg]. If densities differ within a category, that of the densest
    // object: contact of the lighter objects then begins late.
    double per_density[most_fields] = {};

    int fields() const { return 1 + colours; }
};

// Throws std::invalid_argument for more categories than colours, and for blades or clay with labels
// of a cut: those use the same fields.
Bodies bodies_of(const SimulationConfig& config);

template <class R>
BodyFields<R> body_fields(const Bodies& bodies, const SimulationConfig& config)
{
    BodyFields<R> fields{bodies.colours, R(config.contact.friction), {}};
    const double dx = config.lattice.dx;
    for (int c = 0; c < most_fields; ++c)
        fields.per_full[c] = R(bodies.per_density[c] / (dx * dx * dx));
    return fields;
}

}  // namespace knead
