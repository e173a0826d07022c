// Selects the CPU solver at run time: solver.cpp is compiled for several levels of x86-64, each
// with its one public function renamed by the build (CMakeLists.txt); the highest level that the
// processor supports is used.
#include "host/solver/cpu/levels.h"

namespace knead {

std::unique_ptr<EditableSimulator> plain_cpu_solver(const Setup& setup);
#ifdef KNEAD_CPU_LEVELS
std::unique_ptr<EditableSimulator> plain_cpu_solver_v3(const Setup& setup);
std::unique_ptr<EditableSimulator> plain_cpu_solver_v4(const Setup& setup);
#endif

std::vector<MakeSolver> cpu_levels()
{
    std::vector<MakeSolver> known{plain_cpu_solver};
#ifdef KNEAD_CPU_LEVELS
    if (__builtin_cpu_supports("x86-64-v3")) known.push_back(plain_cpu_solver_v3);
    if (__builtin_cpu_supports("x86-64-v4")) known.push_back(plain_cpu_solver_v4);
#endif
    return known;
}

std::unique_ptr<EditableSimulator> cpu_solver(const Setup& setup)
{
    return cpu_levels().back()(setup);
}

}  // namespace knead
