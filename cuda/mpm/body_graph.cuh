// Which bodies are near each other, on the device.  (25c)
#pragma once
#include "cuda/mpm/body_graph.h"
#include "cuda/mpm/particles.cuh"

namespace knead::gpu {

// body: by object, negative for none. masks: a word per bin (bins_of()); graph: most_bodies words
// for bodies that touch, then as many for those that are near. Precondition: both are zero.
void body_graph(const ConstParticleView& particles, const Lattice<float>& lattice, const int* body,
                unsigned long long* masks, unsigned long long* graph, cudaStream_t stream);

}  // namespace knead::gpu
