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
    // Of cells of this edge [m]. `groups`: where groups of splats begin that lie apart, each of
    // which has patches of its own; in their order, then that of the splats.
    Patches(const std::vector<Vec3<double>>& centres, double edge,
            const std::vector<std::size_t>& groups = {0})
        : of_(centres.size())
    {
        const int count = int(groups.size());
        std::vector<std::vector<Patch>> each(groups.size());
        const auto end = [&](std::size_t g) {
            return g + 1 < groups.size() ? groups[g + 1] : centres.size();
        };
#pragma omp parallel for schedule(dynamic)
        for (int k = 0; k < count; ++k) {
            const auto g = std::size_t(k);
            gather(centres, edge, groups[g], end(g), each[g]);
        }
        std::vector<std::uint32_t> before;
        for (const std::vector<Patch>& of_group : each) {
            before.push_back(std::uint32_t(all_.size()));
            all_.insert(all_.end(), of_group.begin(), of_group.end());
        }
#pragma omp parallel for schedule(dynamic)
        for (int k = 0; k < count; ++k)
            for (std::size_t i = groups[std::size_t(k)]; i < end(std::size_t(k)); ++i)
                of_[i] += before[std::size_t(k)];
    }
    const std::vector<Patch>& all() const { return all_; }
    std::uint32_t of(std::size_t splat) const { return of_[splat]; }

  private:
    void gather(const std::vector<Vec3<double>>& centres, double edge, std::size_t from,
                std::size_t to, std::vector<Patch>& patches)
    {
        std::unordered_map<std::int64_t, std::uint32_t> known;
        for (std::size_t i = from; i < to; ++i) {
            const auto fresh = std::uint32_t(patches.size());
            const std::uint32_t k = known.try_emplace(key(centres[i], edge), fresh).first->second;
            if (k == fresh) patches.push_back({std::uint32_t(i), 0, centres[i], {}});
            of_[i] = k;
            Patch& p = patches[k];
            const Vec3<double> d = centres[i] - p.mean;
            p.count += 1;
            p.mean = p.mean + (1 / p.count) * d;
            p.spread = p.spread + squared(d, 1 - 1 / p.count);
        }
    }
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
