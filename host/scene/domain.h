// The domain of a scene, its walls, and the lattice that contains both.
#pragma once
#include <string>

#include "host/base/json_reader.h"
#include "host/scene/scene.h"

namespace knead {

// Read the domain, which sizes the lattice, and then the walls, both in the scene's frame. Both
// throw InputError.
void read_domain(ObjectReader& r, Scene& scene);
void read_walls(ObjectReader& r, Scene& scene);

// Walls in the scene's frame around a lattice whose first node is the origin of that frame; keys
// that are missing keep their value of `defaults`. Throws InputError.
WallOptions read_walls(ObjectReader& r, const WallOptions& defaults,
                       const Lattice<double>& lattice);
// What read_walls() reads again with the same values, to the bit.
Json json_of(const WallOptions& walls);

// The setting that gives the longest axis of a scene's domain `cells` cells and scales the other
// axes in proportion, rounded to whole blocks: "domain.cells=48". `root` is the scene's JSON
// document.
std::string cells_setting(const Json& root, int cells);

// Call once everything is read. Shifts the lattice along each axis so that a plane of nodes lies on
// the low wall, enlarges it by whole blocks where nodes are missing beyond a wall, and transforms
// all positions from the scene's frame to the simulation's frame, whose origin is the first node of
// the lattice. Changes nothing if the low walls already lie on nodes and no nodes are missing.
void move_in(Scene& scene);
// The inverse of move_in() for a scene that was read: all positions, those of loaded particles
// included, in the scene's frame, within rounding; the lattices of the stated domain.
void move_out(Scene& scene);

// The lattice of the surface by scene.surface_nodes, before move_in() enlarges both.
Lattice<float> stated_surface(const Scene& scene);

}  // namespace knead
