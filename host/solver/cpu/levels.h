// The CPU solver, compiled for several x86-64 levels.
#pragma once
#include "host/solver/editable_simulator.h"

namespace knead {

using MakeSolver = std::unique_ptr<EditableSimulator> (*)(const Setup& setup);

// Solvers of all levels that this processor supports, lowest first.
std::vector<MakeSolver> cpu_levels();

}  // namespace knead
