#include <cstdio>

#include "host/solver/editable_simulator.h"
#include "host/surface/mesh.h"

int main()
{
    std::printf("%s\n", knead::gpu_present() ? "a GPU" : "no GPU");
    return int(knead::surface({}, {}, {{{16, 16, 16}, 0.1f}}).size());
}
