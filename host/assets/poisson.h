// Poisson's equation on a box, by multigrid.
#pragma once
#include "host/assets/grid.h"

namespace knead {

// Edges of a box that multigrid halves `poisson_levels` times: multiples of 16 spacings.
constexpr int poisson_levels = 4, poisson_edge = 1 << poisson_levels;

// u with (Laplacian of u) = f on the inner nodes, by the stencil of seven nodes, and u = 0 on the
// boundary. Edges must be multiples of poisson_edge: else std::invalid_argument. Ten V-cycles of
// two red-black Gauss-Seidel sweeps each way leave less than 1e-5 of the error.
// [Trottenberg 2001, ch. 2]. The same bits for any number of threads.
std::vector<float> solve_poisson(const Grid& grid, const std::vector<float>& f);

}  // namespace knead
