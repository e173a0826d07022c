// A procedural splat scene for local clay: a floor of coloured tiles, laid unevenly.
#pragma once
#include "host/files/splat_file.h"

namespace knead {

// 1 x 1 m around the y axis, within 12 mm of y = 0: tiles of 80 mm coloured along a spiral, with
// mortar joints 2 mm deeper. Splats of degree 0, evenly over the surface, flat along it, nearly
// opaque. `count` is at least 100. Deterministic.
SplatCloud tiled_ground(int count = 20000, unsigned seed = 1);

}  // namespace knead
