// Bodies: clay of unlike categories that has velocity fields of its own.  (25a)
#pragma once
#include <vector>

#include "cuda/mpm/body_contact.h"
#include "host/solver/setup.h"

namespace knead {

// Categories that may have clay of their own in a scene whose bodies are separate.
constexpr int most_bodies = most_colours;

// The colour of each object's clay: categories with clay of their own, numbered from 1 in ascending
// order. 0: all clay shares one field, because contact welds or there is one category.
struct Bodies {
    std::vector<int> colour;  // by object
    int colours = 0;          // 0, or 2 to most_colours
    // 1 / density of a colour [m^3/kg]. If densities differ within a category, that of the densest
    // object: contact of the lighter objects then begins late.
    double per_density[1 + most_colours] = {};
    int labels = 1;  // fields of a colour: labels_of_clay if there are blades or cut clay

    int fields() const { return 1 + colours * labels; }
    // The velocity field of clay of an object with this label; of two colours at least.
    int field_of(int object, std::uint32_t label) const
    {
        return 1 + (colour[std::size_t(object)] - 1) * labels + (labels > 1 ? int(label) : 0);
    }
};

// Throws std::invalid_argument for more categories than colours.
Bodies bodies_of(const SimulationConfig& config);

template <class R>
BodyFields<R> body_fields(const Bodies& bodies, const SimulationConfig& config)
{
    BodyFields<R> fields{bodies.colours, R(config.contact.friction), {}, bodies.labels};
    const double dx = config.lattice.dx;
    for (int c = 0; c <= most_colours; ++c)
        fields.per_full[c] = R(bodies.per_density[c] / (dx * dx * dx));
    return fields;
}

}  // namespace knead
