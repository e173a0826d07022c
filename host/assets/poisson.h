// Poisson's equation on a box, by multigrid.
#pragma once
#include "host/assets/grid.h"

namespace knead {

// Edges of the box are multiples of 16 spacings, so that multigrid can halve them `poisson_levels`
// times.
constexpr int poisson_levels = 4, poisson_edge = 1 << poisson_levels;

// Solves (Laplacian of u) = f on the inner nodes, with the 7-point stencil and u = 0 on the
// boundary. Throws std::invalid_argument unless edges are multiples of poisson_edge. Ten V-cycles
// with two red-black Gauss-Seidel sweeps before and after reduce the error below 1e-5. [Trottenberg
// 2001, ch. 2]. Bitwise equal for any number of threads.
std::vector<float> solve_poisson(const Grid& grid, const std::vector<float>& f);

}  // namespace knead
