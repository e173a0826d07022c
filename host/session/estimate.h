// How long a frame will take on this machine, before it is run.
#pragma once
#include "host/scene/scene.h"
#include "host/session/device.h"

namespace knead {

// Wall time of a frame of the solver [s], to a factor of two or so: a lump of clay of each kind of
// material in the scene is moved on the device for some hundredths of a second, and so are
// Gaussians on the face of one where so many follow the clay. What that took for one and a substep
// is taken for all that foresee() tells of the scene. Without hands, surface and pictures. `device`
// is one that was resolved(). Throws what make_solver() throws.
double frame_seconds(const Scene& scene, Device device, std::size_t gaussians = 0);

}  // namespace knead
