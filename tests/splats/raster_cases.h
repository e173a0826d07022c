// What the tests of pictures of splats share: an eye, single splats, how far pictures are apart.
#pragma once
#include <algorithm>
#include <cmath>

#include "host/splats/generate.h"
#include "host/splats/raster.h"
#include "tests/solver/samples.h"

namespace knead {

// At the origin, right, down and forward as x, y and z; 90 degrees wide.
inline Eye<float> plain_eye(int width = 65, int height = 65)
{
    const float h = float(height) / float(width);
    return {{0, 0, 0}, {1, 0, 0, 0}, -1, 1, -h, h, width, height};
}

inline SplatFrame seen_from(std::vector<Eye<float>> eyes)
{
    SplatFrame frame;
    frame.eyes = std::move(eyes);
    return frame;
}

// Of one colour from everywhere.
inline void put(SplatCloud& c, Vec3<float> centre, Vec3<float> scale, float opacity,
                Vec3<float> colour, Quat<float> q = {1, 0, 0, 0})
{
    c.centre.push_back(centre), c.scale.push_back(scale), c.rotation.push_back(q);
    c.opacity.push_back(opacity);
    c.sh.push_back(float(1 / sh_constant) * (colour - Vec3<float>{0.5f, 0.5f, 0.5f}));
}

// The largest difference of a colour, alpha or, where both have one, depth.
inline double furthest(const Picture& a, const Picture& b)
{
    EXPECT_EQ(a.pixels(), b.pixels());
    double worst = 0;
    for (std::size_t i = 0; i < std::min(a.pixels(), b.pixels()); ++i) {
        const Vec3<float> d = a.colour[i] - b.colour[i];
        worst = std::max({worst, double(std::fabs(d.x)), double(std::fabs(d.y)),
                          double(std::fabs(d.z)), double(std::fabs(a.alpha[i] - b.alpha[i]))});
    }
    return worst;
}

inline bool finite(const Picture& p)
{
    for (std::size_t i = 0; i < p.pixels(); ++i)
        if (!std::isfinite(length(p.colour[i])) || !std::isfinite(p.alpha[i]) ||
            !std::isfinite(p.depth[i]))
            return false;
    return true;
}

}  // namespace knead
