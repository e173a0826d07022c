// Selects the CPU solver at run time: the files of this room are compiled for several levels of
// x86-64, each in a namespace of its own; the highest level that the processor supports is used.
#include "host/solver/cpu/levels.h"

#include "host/solver/cpu/namespace.h"

namespace knead {

inline namespace KNEAD_CPU_LEVEL {
std::unique_ptr<EditableSimulator> plain_cpu_solver(const Setup& setup);
}
#ifdef KNEAD_CPU_LEVELS
namespace x86_64_v3 {
std::unique_ptr<EditableSimulator> plain_cpu_solver(const Setup& setup);
}
namespace x86_64_v4 {
std::unique_ptr<EditableSimulator> plain_cpu_solver(const Setup& setup);
}
#endif

std::vector<MakeSolver> cpu_levels()
{
    std::vector<MakeSolver> known{plain_cpu_solver};
#ifdef KNEAD_CPU_LEVELS
    if (__builtin_cpu_supports("x86-64-v3")) known.push_back(x86_64_v3::plain_cpu_solver);
    if (__builtin_cpu_supports("x86-64-v4")) known.push_back(x86_64_v4::plain_cpu_solver);
#endif
    return known;
}

std::unique_ptr<EditableSimulator> cpu_solver(const Setup& setup)
{
    return cpu_levels().back()(setup);
}

}  // namespace knead
