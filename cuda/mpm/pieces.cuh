// Connected pieces of clay on the device: how many each object has. host/solver/piece_count.h says
// what a piece is.
#pragma once
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// A hash table of clay of one group and label in a cell, with open addressing.
struct PieceTable {
    unsigned long long* keys;  // `places` each; 0: free
    unsigned long long* sums;  // particles << 32 | filled share of the cell [2^-16]
    int *parents, *sizes;      // of the union-find; particles of a root's piece
    int places;                // a power of two
    int* counts;               // by group
    int* full;                 // not 0: the table was too small, the counts are invalid
};
constexpr int most_groups = 4096;
int piece_places(int particles);  // of a table

struct PieceLimits {
    float per_cell;       // 1 / dx^3 [1/m^3]
    unsigned filled;      // [2^-16]: cells above it are part of a piece
    int fewest, objects;  // particles of a piece; objects of `group`
};

// Counts the pieces. group: by object; negative: not counted. Precondition: keys, sums, counts and
// `full` are zero.
void count_pieces(const ConstParticleView& particles, const Materials& materials,
                  const Lattice<float>& lattice, const int* group, const PieceLimits& limits,
                  const PieceTable& table, cudaStream_t stream);

}  // namespace knead::gpu
