// Bins of cells by which bodies are found that are near each other.  (25c)
#pragma once
#include <cstdint>

#include "cuda/mpm/lattice.h"

namespace knead {

constexpr int most_bodies = 64;  // bits of a mask
// Edge of a bin [cells]. Fields of clay that is less than 3 cells apart share nodes. Clay in bins
// that are not within two of each other is 4 cells apart at least.
constexpr int bin_edge = 2, bins_near = 2;

HD Int3 bins_of(Int3 cells)
{
    return {(cells.x + bin_edge - 1) / bin_edge, (cells.y + bin_edge - 1) / bin_edge,
            (cells.z + bin_edge - 1) / bin_edge};
}
HD int bin_index(Int3 bin, Int3 bins) { return (bin.z * bins.y + bin.y) * bins.x + bin.x; }

// Masks of bodies in the bins around a bin. mask(bin): of a bin within the lattice.
struct BodiesAround {
    std::uint64_t touching, near;
};
template <class Mask>
HD BodiesAround bodies_around(Int3 bin, Int3 bins, Mask&& mask)
{
    BodiesAround all{0, 0};
    for (int z = -bins_near; z <= bins_near; ++z)
        for (int y = -bins_near; y <= bins_near; ++y)
            for (int x = -bins_near; x <= bins_near; ++x) {
                const Int3 n = bin + Int3{x, y, z};
                if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= bins.x || n.y >= bins.y ||
                    n.z >= bins.z)
                    continue;
                const std::uint64_t there = mask(n);
                all.near |= there;
                if (x >= -1 && x <= 1 && y >= -1 && y <= 1 && z >= -1 && z <= 1)
                    all.touching |= there;
            }
    return all;
}

}  // namespace knead
