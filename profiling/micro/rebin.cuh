// Particles kept in bins, a bin a block of the lattice, with room to spare: from step to step only
// those are moved that have left their block.
#pragma once
#include "profiling/micro/clay.cuh"

namespace knead::micro {

constexpr int bin_room = 1024;  // slots; a full block at eight particles a cell has 512

struct BinView {
    gpu::ParticleView particles;  // bins * bin_room slots
    const int* bin_of;            // by block of the lattice; -1: none
    int* counts;                  // of particles, by bin
    gpu::ParticleView leaving;    // those that have left their bins
    int* left;                    // how many these are
    int* crowded;                 // a bin was too small, or a particle went where none is
    Lattice<float> lattice;
    int bins;
};

// Takes those that left out of their bins and closes the gaps; puts them where they belong.
void rebin(const BinView& bins, cudaStream_t stream);

}  // namespace knead::micro
