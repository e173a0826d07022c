// The object under a ray: of the mouse, or of a finger.
#pragma once
#include <optional>

#include "host/live/live_session.h"

namespace knead {

struct Picked {
    ObjectId object;
    Vec3<double> point{};   // in the simulation's frame [m]
    Vec3<double> normal{};  // of the surface there, unit, outward; of splats: towards the ray
    double distance = 0;    // from the ray's origin [m]
};

// The nearest object along the ray, in the simulation's frame; nothing if it hits no clay. The
// surface and the splats are those of the state; objects that are not drawn, and hidden ones, are
// left out. Of several objects of the category that was hit, the one whose place in the document
// is nearest to the hit: which of them the clay belongs to, the surface does not say. Waits for a
// surface on a device. `direction`: of any length but 0.
std::optional<Picked> pick(const LiveState& state, Vec3<double> origin, Vec3<double> direction);

}  // namespace knead
