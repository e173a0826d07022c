// The splats attached to a solver's Gaussians. While clay is shaped, some are split and some are
// added.
#pragma once
#include <algorithm>
#include <array>

#include "cuda/splats/deform.h"
#include "host/splats/cloud.h"

namespace knead {

// One splat per Gaussian of a solver, in the same order, as at rest.
struct CarriedSplats {
    SplatCloud cloud;
    // Longest half axis at rest [m]; of a split splat: the longest half axis of its parent.
    std::vector<float> extent;

    std::size_t count() const { return cloud.count(); }
};

inline CarriedSplats carried(SplatCloud cloud)
{
    CarriedSplats all{std::move(cloud), {}};
    all.extent.reserve(all.count());
    for (const Vec3<float>& s : all.cloud.scale) all.extent.push_back(max(s.x, max(s.y, s.z)));
    return all;
}

// Appends a splat; `sh` has harmonics(degree) coefficients.
inline void append(CarriedSplats& to, Vec3<float> centre, const Ellipsoid<float>& shape,
                   float opacity, const Vec3<float>* sh, float extent)
{
    SplatCloud& c = to.cloud;
    // `sh` may point into the cloud itself.
    const std::size_t n = std::size_t(harmonics(c.degree));
    std::array<Vec3<float>, std::size_t(harmonics(max_sh_degree))> colour;
    std::copy_n(sh, n, colour.begin());
    c.centre.push_back(centre), c.rotation.push_back(shape.q), c.scale.push_back(shape.scale);
    c.opacity.push_back(opacity);
    c.sh.insert(c.sh.end(), colour.begin(), colour.begin() + std::ptrdiff_t(n));
    to.extent.push_back(extent);
}

// Appends splats of a cloud, as at rest.
void append(CarriedSplats& to, const SplatCloud& from, const std::vector<std::uint32_t>& indices);

}  // namespace knead
