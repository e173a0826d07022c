// After a cut: which clay hangs together, and which labels it still needs.
#pragma once
#include <vector>

#include "cuda/blade.h"

namespace knead {

// Pieces of clay, by cells of the lattice: two cells hang together if they touch and do not carry
// opposite labels. Fills piece[i] for every particle, the largest piece first; returns their number.
template <class R>
int pieces(const std::vector<Particle<R>>& q, const Lattice<R>& lattice, std::vector<int>& piece);

// Gives whole pieces the labels they need: none where no other piece is within reach, opposite ones
// where two are; a piece that a cut has not yet parted keeps its own.
template <class R>
void relabel(std::vector<Particle<R>>& q, const Lattice<R>& lattice);

// Before a new stroke: pieces that it touches and that carry one label only forget it.
template <class R>
void forget(std::vector<Particle<R>>& q, const Lattice<R>& lattice, const std::vector<char>& touched);

}  // namespace knead
