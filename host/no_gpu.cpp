// What stands for the device where the build has none.
#ifndef KNEAD_HAS_CUDA
#include <stdexcept>

#include "solver.h"

namespace knead {

bool gpu_present() { return false; }

std::unique_ptr<Solver> gpu_solver(const Setup&, int)
{
    throw std::runtime_error("no CUDA device: this build has no CUDA side");
}

}  // namespace knead
#endif
