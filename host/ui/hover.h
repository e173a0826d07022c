// The object that a hand touches or points at, found from samples of the clay, without a surface:
// a pure model, with hysteresis.
#pragma once
#include <optional>

#include "host/session/object_places.h"

namespace knead {

// In the simulation's frame [m].
struct HoverProbe {
    Vec3<double> at{};           // between the fingertips
    double reach = 0;            // from there to the clay of an object that is touched
    Vec3<double> ray{0, 0, -1};  // from there, unit
    double range = 0;            // of the ray
    bool rays = true;            // false: touch only
};

struct Hovered {
    ObjectId object;
    Vec3<double> point{};  // of its clay, about [m]
    double distance = 0;   // from HoverProbe::at [m]
    bool touched = false;  // else by the ray
};

class Hover {
  public:
    // Of a touched object, in parts of the reach: how far it may be before it is left, and how much
    // nearer another must be.
    static constexpr double keeps = 1.5, nearer = 0.25;
    // Of one at which the ray points: how far beside its clay the ray may pass [rad], and how much
    // nearer another must be, in parts of the reach.
    static constexpr double beside = 0.02, before = 1;

    // Touched: the object with the nearest clay within reach; else the first along the ray. Hidden
    // objects are left out.
    const std::optional<Hovered>& frame(const ObjectPlaces& places, const Document& document,
                                        const HoverProbe& probe);
    void clear() { now_.reset(); }
    const std::optional<Hovered>& now() const { return now_; }

  private:
    std::optional<Hovered> now_;
};

}  // namespace knead
