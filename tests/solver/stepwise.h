// Frames of a solver on the GPU without graphs, substep by substep.
#pragma once
#include <cstdlib>

namespace knead {

// Of solvers that are made as long as this lasts.
struct Stepwise {
    const char* before = std::getenv("KNEAD_GRAPH");
    Stepwise() { setenv("KNEAD_GRAPH", "0", 1); }
    ~Stepwise() { before ? setenv("KNEAD_GRAPH", before, 1) : unsetenv("KNEAD_GRAPH"); }
};

}  // namespace knead
