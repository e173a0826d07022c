#include "host/vr/finger_pointer.h"

#include <algorithm>
#include <cmath>

#include "host/hands/filter.h"

namespace knead {
namespace {

bool is_over(const TouchPanel& panel, Vec3<float> at, float margin = 0)
{
    return std::abs(at.x) <= 0.5f * panel.width + margin &&
           std::abs(at.y) <= 0.5f * panel.height + margin;
}

float before(Vec3<float> at) { return at.z - FingerPointer::finger; }

// Position in the picture; of points beside the panel that of the nearest one on it.
void put(PanelPointer& pointer, const TouchPanel& panel, Vec3<float> at)
{
    constexpr float edge = 0.5f;  // from the right and lower edges, which are outside [pixels]
    const float u = at.x / panel.width + 0.5f, v = 0.5f - at.y / panel.height;
    pointer.x = panel.x + clamp(u * panel.picture_width, 0.f, panel.picture_width - edge);
    pointer.y = panel.y + clamp(v * panel.picture_height, 0.f, panel.picture_height - edge);
}

const TouchPanel* panel_of(const std::vector<TouchPanel>& panels, int id)
{
    for (const TouchPanel& panel : panels)
        if (panel.id == id) return &panel;
    return nullptr;
}

}  // namespace

FingerPointer::Track& FingerPointer::track_of(int panel, Side side)
{
    for (Track& track : tracks)
        if (track.panel == panel && track.side == side) return track;
    return tracks.emplace_back(Track{panel, side});
}

// A finger that cannot be followed from its previous place is new and not armed.
void FingerPointer::follow(Track& track, const TouchPanel& panel, const FingerTip& tip,
                           double duration)
{
    track.crossed = false;
    const Vec3<float> at = rotate(conjugate(unit(panel.pose.q)), tip.at - panel.pose.p);
    if (!tip.tracked || !panel.touched_by[track.side] || !std::isfinite(at.x + at.y + at.z) ||
        before(at) < -deep) {
        track = {track.panel, track.side};
        return;
    }
    const Vec3<float> from = track.at;
    const bool jumps = track.known && length(at - from) > HandFilter::leap_distance(duration);
    if (jumps) track = {track.panel, track.side};
    track.fresh = !track.known;
    if (before(at) > away) {
        track.armed = true;
    } else if (track.armed && before(at) <= 0) {
        const float way = before(from) - before(at);
        track.share = way > 0 ? clamp(before(from) / way, 0.f, 1.f) : 0;
        track.hit = from + track.share * (at - from);
        track.crossed = is_over(panel, track.hit) && is_over(panel, at, slack);
        track.armed = false;
    }
    track.at = at, track.known = true;
}

// The press of the previous frame in this one.
PanelPointer FingerPointer::go_on(const std::vector<TouchPanel>& panels)
{
    PanelPointer pointer;
    pointer.side = press->side;
    const TouchPanel* panel = panel_of(panels, press->panel);
    const Track* track = panel ? &track_of(press->panel, press->side) : nullptr;
    const bool lost = !track || !track->known || track->fresh;
    const bool leaves = !lost && before(track->at) > away;
    if (lost || (!leaves && !is_over(*panel, track->at, slack))) {
        pointer.cancelled = true;
        press.reset();
        return pointer;
    }
    pointer.inside = true, pointer.panel = press->panel, pointer.distance = before(track->at);
    pointer.x = press->x, pointer.y = press->y;
    if (leaves) {
        press.reset();
        return pointer;
    }
    const Vec3<float> way = track->at - press->begin;
    press->slid = press->slid || std::hypot(way.x, way.y) > slip;
    if (press->slid) put(pointer, *panel, track->at);
    press->x = pointer.x, press->y = pointer.y;
    pointer.down = true;
    return pointer;
}

// The finger that crosses a panel in this frame: the one that hovered, or else the first.
const FingerPointer::Track* FingerPointer::crossing() const
{
    const Track* first = nullptr;
    for (const Track& track : tracks) {
        if (!track.crossed) continue;
        const bool owns = hover_panel >= 0 && track.side == hover_side;
        const bool first_owns = first && hover_panel >= 0 && first->side == hover_side;
        if (!first || owns > first_owns || (owns == first_owns && track.share < first->share))
            first = &track;
    }
    return first;
}

// The finger that hovered in the previous frame, while it does; else the nearest.
const FingerPointer::Track* FingerPointer::hovering(const std::vector<TouchPanel>& panels) const
{
    const Track* nearest = nullptr;
    for (const Track& track : tracks) {
        const TouchPanel* panel = panel_of(panels, track.panel);
        if (!track.known || !panel || !is_over(*panel, track.at)) continue;
        const float distance = before(track.at);
        if (distance <= 0 || distance > near) continue;
        if (track.panel == hover_panel && track.side == hover_side) return &track;
        if (!nearest || distance < before(nearest->at)) nearest = &track;
    }
    return nearest;
}

PanelPointer FingerPointer::frame(double time, const std::vector<TouchPanel>& panels,
                                  const FingerTip (&tips)[side_count])
{
    const double duration = std::max(0.0, time - last);
    last = time;
    std::erase_if(tracks, [&](const Track& track) { return !panel_of(panels, track.panel); });
    for (const TouchPanel& panel : panels)
        for (const Side side : {left, right})
            follow(track_of(panel.id, side), panel, tips[side], duration);

    PanelPointer pointer;
    if (press) {
        pointer = go_on(panels);
    } else if (const Track* track = crossing()) {
        pointer.inside = pointer.down = true;
        pointer.panel = track->panel, pointer.side = track->side;
        pointer.distance = before(track->at);
        put(pointer, *panel_of(panels, track->panel), track->hit);
        press = Press{track->panel, track->side, track->hit, false, pointer.x, pointer.y};
    } else if (const Track* near_one = hovering(panels)) {
        pointer.inside = true;
        pointer.panel = near_one->panel, pointer.side = near_one->side;
        pointer.distance = before(near_one->at);
        put(pointer, *panel_of(panels, near_one->panel), near_one->at);
    }
    hover_panel = pointer.panel;
    hover_side = pointer.side;
    return pointer;
}

}  // namespace knead
