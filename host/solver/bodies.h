// Bodies: clay of unlike categories that has velocity fields of its own.  (25a)
#pragma once
#include <vector>

#include "cuda/mpm/body_contact.h"
#include "host/solver/colouring.h"
#include "host/solver/setup.h"

namespace knead {

// The colour of each object's clay. A body is a category with clay of its own; bodies are numbered
// from 0 in ascending order. Up to most_colours bodies have a colour each, from 1; more share them
// by where they are, see colour_by().
struct Bodies {
    std::vector<int> colour;  // by object
    int colours = 0;          // 0: all clay shares one field, as contact welds or there is one body
    // 1 / density of a colour [m^3/kg]. If densities differ within a colour, that of the densest
    // object: contact of the lighter objects then begins late.
    double per_density[1 + most_colours] = {};
    int labels = 1;         // fields of a colour: labels_of_clay if there are blades or cut clay
    std::vector<int> body;  // by object; -1: no clay
    std::vector<double> densest;  // by body [kg/m^3]
    int welded = 0;               // pairs of bodies that are close and share a colour

    int fields() const { return 1 + colours * labels; }
    // The velocity field of clay of an object with this label; of two colours at least.
    int field_of(int object, std::uint32_t label) const
    {
        return 1 + (colour[std::size_t(object)] - 1) * labels + (labels > 1 ? int(label) : 0);
    }
    // More bodies than colours: colours depend on where the clay is, at the beginning of each
    // frame.
    bool shared() const { return int(densest.size()) > most_colours; }
    // Gives colours by the bodies' neighbourhood. Returns whether any has changed. Precondition:
    // shared().
    bool colour_by(const BodyGraph& graph);
    void set(const std::vector<int>& of_body);  // colours
};

// Throws std::invalid_argument for more than most_bodies categories.
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
