// A procedural splat object, for demonstrations and tests: a fluted pot of bare clay under a glaze
// that ran.
#pragma once
#include "host/files/splat_file.h"

namespace knead {

// About 0.2 m high, standing on y = 0 around the y axis, solid except for a shallow dish on top.
// Splats of degree 2 (the gloss of the glaze), evenly over the surface, half axes 1.9 times as long
// along it as across, nearly opaque. `count` is at least 100. Deterministic.
SplatCloud glazed_pot(int count = 30000, unsigned seed = 1);

// Its volume [m^3], by quadrature over its surface.
double glazed_pot_volume();

}  // namespace knead
