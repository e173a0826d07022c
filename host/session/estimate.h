// How long a frame will take on this machine, before it is run.
#pragma once
#include "host/scene/scene.h"
#include "host/session/device.h"

namespace knead {

// Wall time of a frame of the solver [s], to a factor of two or so: a lump of clay of the scene's
// first material is moved on the device for some hundredths of a second, and what that took for a
// particle and a substep is taken for all that foresee() tells of the scene. Without hands,
// surface and pictures. `device` is one that was resolved(). Throws what make_solver() throws.
double frame_seconds(const Scene& scene, Device device);

}  // namespace knead
