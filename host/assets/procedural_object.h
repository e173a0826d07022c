// An object of our own in splats, for demonstrations and tests: a fluted pot of bare clay under a
// glaze that ran.
#pragma once
#include "host/files/splat_file.h"

namespace knead {

// About 0.2 m high, standing on y = 0 around the y axis, solid but for a shallow dish on top.
// Splats of harmonics of degree 2 (the glaze's gloss), evenly over the surface, half axes 1.9 times
// as long along it as across, nearly opaque. `count` is 100 at least. Deterministic.
SplatCloud glazed_pot(int count = 30000, unsigned seed = 1);

// Its volume [m^3], by quadrature over its surface.
double glazed_pot_volume();

}  // namespace knead
