// Groups splats by cubic cells, one surface patch per cell: the number of patches is bounded by the
// number of cells that the surface crosses, independent of the number of splats.
#pragma once
#include <unordered_map>
#include <vector>

#include "cuda/math/sym_eigen.h"
#include "host/paging/cubes.h"

namespace knead {

struct Patch {
    std::uint32_t first = 0;  // index of its first splat
    double count = 0;
    Vec3<double> mean{};    // [m]
    Sym3<double> spread{};  // sum of the outer products about the mean [m^2]
};

inline Sym3<double> squared(Vec3<double> d, double times)
{
    return {times * d.x * d.x, times * d.y * d.y, times * d.z * d.z,
            times * d.x * d.y, times * d.x * d.z, times * d.y * d.z};
}

struct Patches {
    std::vector<Patch> all;         // in the order of their first splats
    std::vector<std::uint32_t> of;  // per splat: its patch
};

// `edge`: of a cell [m].
inline Patches patches(const std::vector<Vec3<double>>& centres, double edge)
{
    Patches made;
    const Cubes cells{edge};
    std::unordered_map<Cubes::Key, std::uint32_t> known;
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const auto fresh = std::uint32_t(made.all.size());
        const std::uint32_t k = known.try_emplace(cells.key_of(centres[i]), fresh).first->second;
        if (k == fresh) made.all.push_back({std::uint32_t(i), 0, centres[i], {}});
        made.of.push_back(k);
        Patch& p = made.all[k];
        const Vec3<double> d = centres[i] - p.mean;
        p.count += 1;
        p.mean = p.mean + (1 / p.count) * d;
        p.spread = p.spread + squared(d, 1 - 1 / p.count);
    }
    return made;
}

}  // namespace knead
