// Where a scene is simulated: its domain, its walls, and the lattice that holds both.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "host/base/json_reader.h"
#include "host/scene/scene.h"

namespace knead {

inline const std::vector<std::pair<std::string, ContactMode>> contact_modes = {
    {"sticky", ContactMode::sticky},
    {"slip", ContactMode::slip},
    {"separate", ContactMode::separate}};

// A lattice over the domain as it is asked for; then walls, in the scene's frame.
void read_domain(ObjectReader& r, Scene& scene);
void read_walls(ObjectReader& r, Scene& scene);

// The setting by which the longest axis of a scene's domain has `cells` cells and the others keep
// their share of it, to whole blocks: "domain.cells=48". `root` is the scene's document.
std::string cells_setting(const Json& root, int cells);

// When all is read: lays the lattices so that a plane of nodes stands on each low face, enlarges
// them, by whole blocks, where nodes are missing beyond a wall, and moves all that has a place from
// the scene's frame into that of the simulation, which has its origin at the lattice's first node.
// Where low faces stand on nodes and nothing is missing, nothing moves.
void move_in(Scene& scene);

}  // namespace knead
