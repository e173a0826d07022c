// The solid that a cloud of splats encloses: which points of space are inside.
// docs/method/splats.md.
#pragma once
#include <cstdint>

#include "host/assets/grid.h"
#include "host/files/splat_file.h"

namespace knead {

struct SolidOptions {
    int max_cells = 96;   // of the grid along the object's longest edge, 8 to 320
    int directions = 96;  // that light comes from
};

// The indicator is a smoothed generalised winding number: about 1 inside, 0 outside.
struct Solid {
    Grid grid;
    std::vector<float> indicator;
    float level = 0.5f;       // the surface's
    std::vector<float> seen;  // share of the sky that reaches each node
    std::vector<float> lit;   // per splat: share of the sky that it sees, 0 for those left out
    double volume = 0;        // [m^3]
    // Of what no light reaches: the volume, and the share of it that is inside. The rest is missed.
    double unlit = 0;  // [m^3]
    double found = 1;

    // Above 0 inside; a change of 1 across the surface.
    float inside(Vec3<double> x) const { return sampled(grid, indicator, x) - level; }
    bool visible(Vec3<double> x) const;  // a tenth of the sky reaches it, or 1.5 spacings away
};

// Of the splats `kept` of the cloud. Closed cavities are inside: no photograph shows them. Throws
// InputError where nothing is kept or where all of it is one point. Time goes with the nodes times
// the directions and with the number of splats; memory is at most 64 bytes a node, of which there
// are about 1.4^3 max_cells^3 at most, and 16 bytes a splat. The same for any number of threads.
Solid find_solid(const SplatCloud& cloud, const std::vector<std::uint32_t>& kept,
                 const SolidOptions& options);

}  // namespace knead
