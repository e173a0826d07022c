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
    if (categories.size() > std::size_t(most_bodies))
        throw std::invalid_argument(
            fmt::format("contact.categories \"separate\" with {} categories: there may be {}",
                        categories.size(), most_bodies));
    if (categories.size() < 2) return bodies;
    bodies.labels = blades ? labels_of_clay : 1;
    bodies.body.assign(config.materials.size(), -1), bodies.densest.resize(categories.size());
    for (std::size_t i = 0; i < config.materials.size(); ++i) {
        const Material<double>& m = config.materials[i];
        if (!there(m)) continue;
        const auto body = std::distance(categories.begin(), categories.find(m.category));
        bodies.body[i] = int(body);
        double& densest = bodies.densest[std::size_t(body)];
        densest = std::max(densest, m.density);
    }
    bodies.colours = std::min(int(categories.size()), most_colours);
    std::vector<int> colours(categories.size());
    for (std::size_t b = 0; b < colours.size(); ++b) colours[b] = 1 + int(b) % most_colours;
    bodies.set(colours);
    return bodies;
}

void Bodies::set(const std::vector<int>& of_body)
{
    for (std::size_t i = 0; i < colour.size(); ++i)
        colour[i] = body[i] < 0 ? 0 : of_body[std::size_t(body[i])];
    double most[1 + most_colours] = {};
    for (std::size_t b = 0; b < of_body.size(); ++b)
        most[of_body[b]] = std::max(most[of_body[b]], densest[b]);
    for (int c = 1; c <= colours; ++c) per_density[c] = most[c] > 0 ? 1 / most[c] : 0;
}

bool Bodies::colour_by(const BodyGraph& graph)
{
    const Colouring to = coloured(graph, int(densest.size()), colours);
    const std::vector<int> before = colour;
    set(to.colour), welded = to.welded;
    return colour != before;
}

}  // namespace knead
