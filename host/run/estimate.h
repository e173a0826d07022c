// How long a frame will take on this machine, before it is run.
#pragma once
#include <string>

#include "host/scene/scene.h"
#include "host/session/backend.h"

namespace knead {

// Wall time of a frame of the solver, without hands, surface and pictures [s].
struct FrameCost {
    static constexpr double within = 3;  // times, or it is not known

    bool still = false;       // all clay comes with the hands
    double seconds = 0;       // for the clay that there is from the start
    double per_thousand = 0;  // more, for each 1000 particles of clay that comes with them
    bool known = true;
};

// To a factor of two or so: two lumps of clay of each kind of material in the scene, a small and a
// large one, are moved on the device for some hundredths of a second each, and so are Gaussians on
// the face of one where so many follow the clay. That says what a substep takes whatever there is,
// and what each particle takes more, of which foresee() tells how many there are. `device` is one
// that was resolved(). Throws what make_solver() throws.
FrameCost frame_cost(const Scene& scene, Device device, std::size_t gaussians = 0);

// As a message says it before a scene is run.
std::string cost_text(const FrameCost& cost);
std::string cost_text(const Scene& built, Device device);

}  // namespace knead
