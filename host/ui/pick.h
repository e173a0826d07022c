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
// left out. The surface does not say to which of several objects of a category clay belongs: with
// `places` it is the one whose clay was nearest to the hit, else the one whose place in the
// document is. Waits for a surface on a device. `direction`: of any length but 0.
std::optional<Picked> pick(const LiveState& state, Vec3<double> origin, Vec3<double> direction,
                           const ObjectPlaces* places = nullptr);

// Where the ray hits the nearest of these surfaces.
struct SurfaceHit {
    Vec3<double> point{}, normal{};  // [m]; unit, outward
    double distance = 0;             // [m]
};
std::optional<SurfaceHit> pick_surface(const std::vector<Mesh>& meshes, Vec3<double> origin,
                                       Vec3<double> direction);

}  // namespace knead
