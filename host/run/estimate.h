// Estimate of the wall time of a frame on this machine, before a run.
#pragma once
#include <string>

#include "host/scene/scene.h"
#include "host/session/backend.h"

namespace knead {

// Wall time of a frame of the solver, without hands, surface and pictures [s].
struct FrameCost {
    static constexpr double within = 3;  // largest ratio of timings that still counts as known

    bool still = false;       // no clay at the start: all is local clay
    double seconds = 0;       // for the clay at the start
    double per_thousand = 0;  // added per 1000 particles of local clay
    bool known = true;        // false: timings varied too much
};

// Accurate to a factor of about two. Times a small and a large lump of clay of each kind of
// material in the scene on the device, some hundredths of a second each; if `gaussians` is not 0,
// also Gaussians on the face of one lump. The two lumps give the fixed cost of a substep and the
// cost per particle; foresee() gives the number of substeps. Precondition: `device` was resolved().
// Throws as make_solver().
FrameCost frame_cost(const Scene& scene, Device device, std::size_t gaussians = 0);

// The message before a run.
std::string cost_text(const FrameCost& cost);
std::string cost_text(const Scene& built, Device device);

}  // namespace knead
