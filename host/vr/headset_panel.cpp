#include "host/vr/headset_panel.h"

#include <cmath>
#include <utility>

#include "host/surface/device_mesh.h"

namespace knead {
namespace {

constexpr float palm_from_thumb = 0.012f, palm_to_fingers = 0.022f;  // from the palm's centre [m]

int pixels(float length) { return int(std::lround(length / HeadsetPanel::pixel)); }

}  // namespace

Box3<double> clay_box(const LiveState& state)
{
    Box3<double> clay = empty_box<double>();
    if (state.on_device && !state.on_device->empty()) {
        const Box3<float> box = state.on_device->box();
        clay = {cast<double>(box.low), cast<double>(box.high)};
    }
    for (const Mesh& mesh : state.meshes ? *state.meshes : std::vector<Mesh>())
        for (const Vec3<float>& v : mesh.vertices) grow(clay, cast<double>(v));
    return clay;
}

PanelDrawingOptions HeadsetPanel::layout(float distance)
{
    PanelDrawingOptions by;
    by.touch = true;
    by.width = pixels(size.width), by.height = pixels(size.height);
    by.palm_width = pixels(palm_size.width), by.palm_height = pixels(palm_size.height);
    by.capital = panel_letter_height(distance, size) / pixel;
    return by;
}

TouchPanel HeadsetPanel::main_at(const Joint<float>& pose, const PanelDrawingOptions& layout)
{
    TouchPanel panel;
    panel.id = main_panel, panel.pose = pose;
    panel.width = size.width, panel.height = size.height;
    panel.picture_width = float(layout.width), panel.picture_height = float(layout.height);
    return panel;
}

void HeadsetPanel::place(const Workplace& workplace, const Box3<double>& clay,
                         const HandsOptions& hands)
{
    place_ = main_panel_pose(workplace, control.ui.panel_side, clay, hands, size);
    refresh.again();
}

std::vector<ControlEvent> HeadsetPanel::frame(const TimeGraph& times, const PanelSurroundings& of,
                                              double time, double period)
{
    if (!drawing) return {};
    const PanelDrawingOptions by = layout(place_.distance);
    panels = {main_at(place_.pose, by)};
    for (const Side side : {left, right}) {
        const bool shows = palm[side].frame(time, of.hands[side], of.head, of.contact[side],
                                            of.busy[side] || side != control.ui.support);
        auto pose = shows ? palm_pose(of.hands[side]) : std::nullopt;
        if (!pose) continue;
        // Beside the ball of the thumb, which is before the palm.
        const float from_thumb = side == left ? palm_from_thumb : -palm_from_thumb;
        pose->p = pose->p + rotate(pose->q, Vec3<float>{from_thumb, palm_to_fingers, 0});
        TouchPanel strip;
        strip.id = palm_panel, strip.pose = *pose;
        strip.width = palm_size.width, strip.height = palm_size.height;
        strip.y = float(by.height);
        strip.picture_width = float(by.palm_width), strip.picture_height = float(by.palm_height);
        strip.touched_by[side] = false;
        panels.push_back(strip);
    }
    FingerTip tips[side_count];
    for (const Side side : {left, right}) {
        const Hand& hand = of.hands[side];
        tips[side] = {hand.joints[index_tip].p, hand.tracked && hand.valid[index_tip]};
    }
    const PanelPointer before = std::exchange(finger, fingers.frame(time, panels, tips));
    const bool busy = finger.inside || before.inside || finger.cancelled;
    if (!refresh.due(control.model(), busy, *drawing, period)) return {};
    PanelInput input;
    input.seconds = refresh.take_passed();
    // Where a press was cancelled no control is released.
    input.pointer = finger.inside, input.x = finger.x, input.y = finger.y;
    input.down[0] = finger.down;
    changed = true;
    return drawing->frame(control.model(), times, input, drawing->picture_width(),
                          drawing->picture_height());
}

}  // namespace knead
