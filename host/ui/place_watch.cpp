#include "host/ui/place_watch.h"

#include <algorithm>
#include <cmath>

namespace knead {

void PlaceWatch::find(LiveSession& session, double now)
{
    places = session.object_places(), requested_at_ = now;
}

const Box3<double>* PlaceWatch::box(ObjectId object) const
{
    const auto at = boxes_.find(object);
    return at == boxes_.end() ? nullptr : &at->second;
}

void PlaceWatch::follow(const LiveState& state, LiveSession& session, bool shown, bool waits,
                        double now, double seen)
{
    const auto found = session.latest_object_places();
    if (found && found->history == state.history && found != places) places = found;
    const bool other = state.document != of_ || !places || places->history != state.history;
    if (shown && (other || places->frame != state.frame.number)) {
        constexpr double short_delay = 0.004;  // [s]
        const double took = waits || !places ? 0 : places->took;
        const bool delays = took > std::max(short_delay, state.frame.times.solver / 4);
        if (other || (!delays && now >= requested_at_ + std::max(0.25, 50 * took))) {
            requested_at_ = now, of_ = state.document;
            if (waits)
                places = session.object_places();
            else
                session.request_object_places();
        }
    }
    std::erase_if(boxes_, [&](const auto& one) { return !places || !places->find(one.first); });
    for (std::size_t i = 0; places && i < places->all.size(); ++i) {
        const ObjectPlace& one = places->all[i];
        const double wider = one.spacing;  // the surface is around the particles
        const Vec3<double> beside{wider, wider, wider};
        const Box3<double> to{one.box.low - beside, one.box.high + beside};
        Box3<double>& box = boxes_.try_emplace(one.object, to).first->second;
        const Vec3<double> a = to.low - box.low, b = to.high - box.high;
        if (std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z), std::abs(b.x), std::abs(b.y),
                      std::abs(b.z)}) > seen)
            box = to;
    }
}

}  // namespace knead
