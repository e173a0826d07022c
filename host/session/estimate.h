// How long a frame will take on this machine, before it is run.
#pragma once
#include <string>

#include "host/scene/scene.h"
#include "host/session/device.h"

namespace knead {

// Wall time of a frame of the solver, without hands, surface and pictures [s].
struct FrameCost {
    bool still = false;       // all clay comes with the hands
    double seconds = 0;       // for the clay that there is from the start
    double per_thousand = 0;  // more, for each 1000 particles of clay that comes with them
};

// To a factor of two or so: a lump of clay of each kind of material in the scene is moved on the
// device for some hundredths of a second, and so are Gaussians on the face of one where so many
// follow the clay. What that took for one and a substep is taken for all that foresee() tells of
// the scene. `device` is one that was resolved(). Throws what make_solver() throws.
FrameCost frame_cost(const Scene& scene, Device device, std::size_t gaussians = 0);

// As a message says it before a scene is run.
std::string cost_text(const FrameCost& cost);
std::string cost_text(const Scene& built, Device device);

}  // namespace knead
