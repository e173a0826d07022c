// A uniform grid of points for neighbour searches.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cuda/math/box.h"

namespace knead {

class Cells {
  public:
    // Precondition: finite points, which must outlive the grid. `wanted_edge` is the cell edge [m];
    // it is enlarged if there would be many more cells than points.
    Cells(const std::vector<Vec3<double>>& of, double wanted_edge) : points(of), edge(wanted_edge)
    {
        if (points.empty()) return;
        Box3<double> box{points[0], points[0]};
        for (const Vec3<double>& x : points) grow(box, x);
        low = box.low;
        const Vec3<double> d = edges(box);
        const double most = 64 * double(points.size()) + 4096;
        while ((d.x / edge + 1) * (d.y / edge + 1) * (d.z / edge + 1) > most) edge *= 1.5;
        size = {int(d.x / edge) + 1, int(d.y / edge) + 1, int(d.z / edge) + 1};
        before.assign(std::size_t(size.x) * size.y * size.z + 1, 0);
        std::vector<std::uint32_t> cell(points.size());
        for (std::size_t i = 0; i < points.size(); ++i)
            ++before[(cell[i] = std::uint32_t(index(cell_of(points[i])))) + 1];
        for (std::size_t c = 1; c < before.size(); ++c) before[c] += before[c - 1];
        std::vector<std::uint32_t> next(before.begin(), before.end() - 1);
        order.resize(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) order[next[cell[i]]++] = std::uint32_t(i);
    }

    const Vec3<double>& point(std::uint32_t i) const { return points[i]; }

    // Calls visit(index) for every point closer than `reach` [m] to x along each axis, and for some
    // others nearby; always in the same order.
    template <class Visit>
    void each_near(Vec3<double> x, Vec3<double> reach, Visit&& visit) const
    {
        if (points.empty()) return;
        const Int3 from = cell_of(x - reach), to = cell_of(x + reach);
        for (int k = from.z; k <= to.z; ++k)
            for (int j = from.y; j <= to.y; ++j) {
                const std::uint32_t last = before[index({to.x, j, k}) + 1];
                for (std::uint32_t at = before[index({from.x, j, k})]; at < last; ++at)
                    visit(order[at]);
            }
    }

  private:
    Int3 cell_of(Vec3<double> x) const  // clamped to the grid
    {
        const auto along = [this](double at, int count) {
            return int(clamp(std::floor(at / edge), 0.0, double(count - 1)));
        };
        const Vec3<double> r = x - low;
        return {along(r.x, size.x), along(r.y, size.y), along(r.z, size.z)};
    }
    std::size_t index(Int3 c) const
    {
        return std::size_t(c.x) +
               std::size_t(size.x) * (std::size_t(c.y) + std::size_t(size.y) * c.z);
    }

    const std::vector<Vec3<double>>& points;
    double edge;
    Vec3<double> low{};
    Int3 size{};
    std::vector<std::uint32_t> before, order;
};

}  // namespace knead
