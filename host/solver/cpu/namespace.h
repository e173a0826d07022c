// The namespace of a CPU level. The solver's files are compiled once per level of x86-64 that pays
// (CMakeLists.txt), and each level's names lie in a namespace of their own.
#pragma once

#ifndef KNEAD_CPU_LEVEL
#define KNEAD_CPU_LEVEL baseline
#endif
