#include "host/solver/bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "host/solver/edits.h"

namespace knead {

Bodies bodies_of(const SimulationConfig& config)
{
    Bodies bodies;
    bodies.colour.assign(config.materials.size(), 0);
    if (!config.contact.separate) return bodies;
    const bool blades =
        config.cuts || std::any_of(config.tools.begin(), config.tools.end(),
                                   [](const Tool<double>& tool) { return tool.blade; });
    std::set<int> categories;
    for (const Material<double>& m : config.materials)
        if (there(m)) categories.insert(m.category);
    if (categories.size() > std::size_t(most_colours))
        throw std::invalid_argument(fmt::format(
            "contact.categories \"separate\" with {} categories: there are velocity fields for {}",
            categories.size(), most_colours));
    if (categories.size() < 2) return bodies;
    bodies.colours = int(categories.size()), bodies.labels = blades ? labels_of_clay : 1;
    double densest[1 + most_colours] = {};
    for (std::size_t i = 0; i < config.materials.size(); ++i) {
        const Material<double>& m = config.materials[i];
        if (!there(m)) continue;
        int& colour = bodies.colour[i];
        colour = 1 + int(std::distance(categories.begin(), categories.find(m.category)));
        densest[colour] = std::max(densest[colour], m.density);
    }
    for (int c = 1; c <= bodies.colours; ++c) bodies.per_density[c] = 1 / densest[c];
    return bodies;
}

}  // namespace knead
