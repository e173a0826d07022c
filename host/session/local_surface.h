// How deep a place lies under a surface that only splats tell of.
#pragma once
#include <optional>
#include <vector>

#include "host/splats/cells.h"

namespace knead {

class LocalSurface {
  public:
    // Centres of splats and their outward unit normals. `depth` [m] is how far below the surface a
    // place may lie, `width` [m] how far from a splat the surface goes on along it.
    LocalSurface(std::vector<Vec3<double>> centres, std::vector<Vec3<double>> normals, double depth,
                 double width)
        : x(std::move(centres)),
          n(std::move(normals)),
          far(depth + width),
          wide(width),
          cells(x, max(far / 3, width))
    {
    }
    LocalSurface(const LocalSurface&) = delete;

    // Height over the planes of the splats that are about as near as the nearest [m], below 0
    // inside; nothing where no splat is near enough.
    std::optional<double> height(Vec3<double> at) const
    {
        double nearest = far * far;
        const Vec3<double> all{far, far, far};
        cells.each_near(at, all, [&](std::uint32_t j) {
            const Vec3<double> d = at - x[j];
            nearest = min(nearest, dot(d, d));
        });
        if (nearest >= far * far) return {};
        const double reach = std::sqrt(nearest) + wide;
        double sum = 0, weight = 0;
        cells.each_near(at, {reach, reach, reach}, [&](std::uint32_t j) {
            const Vec3<double> d = at - x[j];
            const double w = 1 - dot(d, d) / (reach * reach);
            if (w > 0) sum += w * dot(d, n[j]), weight += w;
        });
        const double h = sum / weight;
        if (nearest - h * h > wide * wide) return {};  // beside the surface's end
        return h;
    }

  private:
    std::vector<Vec3<double>> x, n;
    double far, wide;
    Cells cells;
};

}  // namespace knead
