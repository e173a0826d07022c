#include "host/session/headset_hands.h"

#include <algorithm>

#include "host/scene/seed.h"
#include "host/session/live_look.h"

namespace knead {

float HandFade::frame(double time, bool tracked, float size)
{
    const float step = float(std::max(0.0, time - last) / fading);
    last = time;
    const float wanted = tracked ? faint + (1 - faint) * size : 0;
    opacity =
        wanted > opacity ? std::min(wanted, opacity + step) : std::max(wanted, opacity - step);
    return opacity;
}

HandFrame hand_frame(const Sight& sight, const Workplace& workplace, double time)
{
    HandFrame frame;
    frame.time = time;
    for (int side = 0; side < side_count; ++side)
        frame.hand[side] = in_hands(workplace, sight.hands[std::size_t(side)].hand);
    return frame;
}

void HeadsetHands::set(const HandsRule& rule)
{
    hand_tools(rule);  // refuses a tool that is not known
    by = rule;
    HandsRule unplaced = rule;
    unplaced.zoom = 1, unplaced.at = {0, 0, 0};
    stream.emplace(unplaced);
}

void HeadsetHands::set_zoom(double zoom) { by.zoom = zoom; }

void HeadsetHands::push(const HandFrame& frame)
{
    newest = frame;
    stream->push(frame);
    stream->forget(frame.time - 1);
}

std::vector<HandLook> HeadsetHands::looks()
{
    std::vector<HandLook> all;
    if (stream->empty()) return all;
    std::vector<Joint<double>> joints(std::size_t(int(side_count) * joint_count));
    float size[side_count];
    stream->sample(newest.time, joints.data(), size);
    for (Joint<double>& joint : joints) joint.p = by.at + by.zoom * joint.p;
    float opacity[side_count];
    for (int side = 0; side < side_count; ++side)
        opacity[side] = fade[side].frame(newest.time, newest.hand[side].tracked, size[side]);
    const std::vector<Side> sides = tool_sides(by);
    for (std::size_t tool = 0; tool < sides.size(); ++tool) {
        const Side side = sides[tool];
        if (opacity[side] <= 0) continue;
        std::vector<char> alone(sides.size(), 0);
        alone[tool] = 1;
        for (HandLook& look : hand_looks(by, joints, alone, opacity[side]))
            all.push_back(std::move(look));
    }
    return all;
}

void HeadsetHands::feel(const LiveState& state, float strength[side_count])
{
    constexpr float contact = 0.5f, yielding = 0.15f;
    std::fill(strength, strength + int(side_count), 0.0f);
    if (state.version == felt) return;
    felt = state.version;
    const FrameStats& stats = state.frame.stats;
    const bool touches = stats.projected > 0;
    for (int side = 0; side < side_count; ++side) {
        const bool now = touches && std::any_of(state.tools.begin(), state.tools.end(),
                                                [&](const LiveTool& tool) {
                                                    return tool.side == side && tool.active;
                                                });
        if (now) strength[side] = touched[side] ? (stats.yielded > 0 ? yielding : 0) : contact;
        touched[side] = now;
    }
}

}  // namespace knead
