#include "host/ui/hover.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace knead {
namespace {

constexpr double too_far = std::numeric_limits<double>::infinity();

// The clay of `one` nearest to the probe, if its box is within `reach`.
Hovered touched(const ObjectPlace& one, const HoverProbe& probe, double reach)
{
    Hovered found{one.object, {}, too_far, true};
    const Vec3<double> wide{reach + one.apart, reach + one.apart, reach + one.apart};
    if (!contains(Box3<double>{one.box.low - wide, one.box.high + wide}, probe.at)) return found;
    for (const Vec3<float>& p : one.some) {
        const Vec3<double> d = cast<double>(p) - probe.at;
        const double square = dot(d, d);
        if (square < found.distance) found.distance = square, found.point = cast<double>(p);
    }
    // Clay is around the samples.
    found.distance = std::max(0.0, std::sqrt(found.distance) - 0.5 * one.apart);
    return found;
}

// Whether the ray enters the box.
bool meets(const Box3<double>& box, const HoverProbe& probe, double wide)
{
    double from = 0, to = probe.range;
    const double low[3] = {box.low.x, box.low.y, box.low.z},
                 high[3] = {box.high.x, box.high.y, box.high.z},
                 at[3] = {probe.at.x, probe.at.y, probe.at.z},
                 way[3] = {probe.ray.x, probe.ray.y, probe.ray.z};
    for (int k = 0; k < 3; ++k) {
        const double a = low[k] - wide - at[k], b = high[k] + wide - at[k];
        if (std::abs(way[k]) < 1e-12) {
            if (a > 0 || b < 0) return false;
            continue;
        }
        from = std::max(from, std::min(a / way[k], b / way[k]));
        to = std::min(to, std::max(a / way[k], b / way[k]));
    }
    return from <= to;
}

// The first clay of `one` along the ray. `beside`: that it may pass [rad].
Hovered pointed(const ObjectPlace& one, const HoverProbe& probe, double beside)
{
    Hovered found{one.object, {}, too_far, false};
    if (!meets(one.box, probe, one.apart + beside * probe.range)) return found;
    for (const Vec3<float>& p : one.some) {
        const Vec3<double> d = cast<double>(p) - probe.at;
        const double along = dot(d, probe.ray);
        if (!(along > 0) || along > probe.range || along >= found.distance) continue;
        const double wide = one.apart + beside * along;
        if (dot(d, d) - along * along <= wide * wide)
            found.distance = along, found.point = probe.at + along * probe.ray;
    }
    return found;
}

}  // namespace

const std::optional<Hovered>& Hover::frame(const ObjectPlaces& places, const Document& document,
                                           const HoverProbe& probe)
{
    const auto nearest = [&](bool touch) {
        Hovered best;
        best.distance = too_far;
        Hovered kept = best;
        for (const ObjectPlace& one : places.all) {
            const SceneObject* const object = document.find(one.object);
            if (!object || object->hidden) continue;
            const bool was = now_ && now_->touched == touch && now_->object == one.object;
            const double reach = was ? keeps * probe.reach : probe.reach;
            const Hovered found =
                touch ? touched(one, probe, reach) : pointed(one, probe, was ? beside : 0);
            if (touch && found.distance > reach) continue;
            if (was) kept = found;
            if (found.distance < best.distance) best = found;
        }
        const double margin = (touch ? nearer : before) * probe.reach;
        return kept.distance < too_far && kept.distance <= best.distance + margin ? kept : best;
    };
    Hovered found = nearest(true);
    if (found.distance == too_far && probe.rays) found = nearest(false);
    if (found.distance < too_far)
        now_ = found;
    else
        now_.reset();
    return now_;
}

}  // namespace knead
