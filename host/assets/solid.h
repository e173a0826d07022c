// The solid enclosed by a cloud of splats: which points of space are inside. docs/method/splats.md.
#pragma once
#include <cstdint>

#include "host/assets/grid.h"
#include "host/files/splat_file.h"

namespace knead {

struct SolidOptions {
    int max_cells = 96;   // grid cells along the object's longest edge, 8 to 320
    int directions = 96;  // directions of light
};

// The indicator is a smoothed generalised winding number: about 1 inside, 0 outside.
struct Solid {
    Grid grid;
    std::vector<float> indicator;
    float level = 0.5f;       // isovalue of the surface
    std::vector<float> seen;  // fraction of the sky that reaches each node
    std::vector<float> lit;   // per splat: fraction of the sky that reaches it, 0 if dropped
    double volume = 0;        // [m^3]
    // Volume that no light reaches, and the fraction of it that is inside the solid. The rest is
    // missed.
    double unlit = 0;  // [m^3]
    double found = 1;

    // Above 0 inside; changes by 1 across the surface.
    float inside(Vec3<double> x) const { return sampled(grid, indicator, x) - level; }
    bool visible(Vec3<double> x) const;  // if a tenth of the sky reaches x, or 1.5 spacings away
};

// Finds the solid of the splats `kept`. Closed cavities count as inside: no photograph shows them.
// Throws InputError if `kept` is empty or all its splats are at one point. Time: nodes times
// directions, plus the number of splats; memory: at most 64 bytes per node, of which there are at
// most about 1.4^3 max_cells^3, and 16 bytes per splat. Equal for any number of threads.
Solid find_solid(const SplatCloud& cloud, const std::vector<std::uint32_t>& kept,
                 const SolidOptions& options);

}  // namespace knead
