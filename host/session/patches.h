// Splats by cells of one size, of which each is one patch of a surface: however many there are,
// there are no more patches than the surface has cells.
#pragma once
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "cuda/math/sym_eigen.h"

namespace knead {

struct Patch {
    std::uint32_t first = 0;  // of its splats
    double count = 0;
    Vec3<double> mean{};    // [m]
    Sym3<double> spread{};  // sum of the squares about the mean [m^2]
};

inline Sym3<double> squared(Vec3<double> d, double times)
{
    return {times * d.x * d.x, times * d.y * d.y, times * d.z * d.z,
            times * d.x * d.y, times * d.x * d.z, times * d.y * d.z};
}

class Patches {
  public:
    // Of cells of this edge [m]; in the order of the splats.
    Patches(const std::vector<Vec3<double>>& centres, double edge)
    {
        std::unordered_map<std::int64_t, std::uint32_t> known;
        for (std::size_t i = 0; i < centres.size(); ++i) {
            const auto fresh = std::uint32_t(all_.size());
            const std::uint32_t k = known.try_emplace(key(centres[i], edge), fresh).first->second;
            if (k == fresh) all_.push_back({std::uint32_t(i), 0, centres[i], {}});
            of_.push_back(k);
            Patch& p = all_[k];
            const Vec3<double> d = centres[i] - p.mean;
            p.count += 1;
            p.mean = p.mean + (1 / p.count) * d;
            p.spread = p.spread + squared(d, 1 - 1 / p.count);
        }
    }
    const std::vector<Patch>& all() const { return all_; }
    std::uint32_t of(std::size_t splat) const { return of_[splat]; }

  private:
    static std::int64_t key(Vec3<double> x, double edge)
    {
        const auto along = [edge](double at) {
            return std::int64_t(std::floor(clamp(at / edge, -1048576.0, 1048575.0))) + 1048576;
        };
        return along(x.z) << 42 | along(x.y) << 21 | along(x.x);
    }
    std::vector<Patch> all_;
    std::vector<std::uint32_t> of_;
};

}  // namespace knead
