// The CPU's loops as compiled for several levels of the processor.
#pragma once
#include "host/solver/solver.h"

namespace knead {

using MakeSolver = std::unique_ptr<Solver> (*)(const Setup& setup);

// Of all levels that this processor knows, the lowest first.
std::vector<MakeSolver> cpu_levels();

}  // namespace knead
