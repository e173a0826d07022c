// How many connected pieces the clay of each object has: fast enough to look after each frame.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

// A piece of fewer particles is dust: it is not counted.
constexpr std::size_t fewest_particles_in_part = 64;
// A cell is part of a piece from this share of its volume on [1].
constexpr double filled_share = 0.25;

// Cells of an object's clay of one label with more than `filled_share` of their volume filled are
// connected if they touch, also at an edge or a corner, and do not carry opposite labels: a piece
// is a cell away from others, or cut off. `group`: by object, a number from 0 to groups - 1, or
// negative: not counted. Returns the number of pieces by group.
template <class R>
std::vector<int> piece_counts(const std::vector<Particle<R>>& q, const Lattice<R>& lattice,
                              const std::vector<Material<R>>& materials, std::span<const int> group,
                              int groups);

}  // namespace knead
