#include "host/vr/headset_hands.h"

#include <algorithm>

#include "cuda/contact/contact.h"
#include "host/hands/motion.h"
#include "host/picture/live_look.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

bool has_blade(const LiveTool& tool) { return tool.held == "knife" || tool.held == "scissors"; }

}  // namespace

float HandFade::frame(double time, bool tracked, float size)
{
    const float step = float(std::max(0.0, time - last) / fading);
    last = time;
    const float wanted = tracked ? faint + (1 - faint) * size : 0;
    opacity =
        wanted > opacity ? std::min(wanted, opacity + step) : std::max(wanted, opacity - step);
    return opacity;
}

void TrackingWatch::frame(double time, long restarts)
{
    const double step = time - last;
    last = time;
    if (step > 0 && step < lasting) interval += (step - interval) / (interval > 0 ? averaged : 1);
    if (restarts > known) restart[0] = restart[1], restart[1] = time;
    known = restarts;
    slow = time - restart[0] < lasting;
}

double TrackingWatch::rate() const { return interval > 0 ? 1 / interval : 0; }

HandFrame hand_frame(const HeadsetViews& views, const Workplace& workplace, double time)
{
    HandFrame frame;
    frame.time = time;
    for (int side = 0; side < side_count; ++side)
        frame.hand[side] = in_hands(workplace, views.hands[std::size_t(side)].hand);
    return frame;
}

void HeadsetHands::set(const HandsOptions& options)
{
    hand_tools(options);  // throws for an unknown tool
    by = options;
    HandsOptions unplaced = options;
    unplaced.zoom = 1, unplaced.at = {0, 0, 0};
    stream.emplace(unplaced);
}

HeadsetHands HeadsetHands::open(const HandsOptions& options)
{
    HeadsetHands hands(options);
    HandFrame frame;
    for (const Side side : {left, right}) {
        frame.hand[side] = open_hand(side);
        hands.fade[side].frame(HandFade::fading, true, 1);
    }
    frame.time = HandFade::fading;
    hands.push(frame);
    return hands;
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
    Motion motion = no_motion();
    float size[side_count];
    stream->sample(newest.time, motion.to.data(), size);
    for (Joint<double>& joint : motion.to) joint.p = by.at + by.zoom * joint.p;
    float opacity[side_count];
    for (int side = 0; side < side_count; ++side)
        opacity[side] = fade[side].frame(newest.time, newest.hand[side].tracked, size[side]);
    const std::vector<Side> sides = tool_sides(by);
    for (const Side side : sides) motion.stretch.push_back(stream->stretch(newest.time, side));
    for (std::size_t tool = 0; tool < sides.size(); ++tool) {
        const Side side = sides[tool];
        if (opacity[side] <= 0) continue;
        motion.active.assign(sides.size(), 0);
        motion.active[tool] = 1;
        for (HandLook& look : hand_looks(by, motion, opacity[side])) {
            look.glow = cue[side].glow(newest.time);
            all.push_back(std::move(look));
        }
    }
    return all;
}

void HeadsetHands::feel(const LiveState& state, Feel felt[side_count])
{
    std::fill(felt, felt + int(side_count), Feel::nothing);
    if (state.version == felt_version) return;
    felt_version = state.version;
    const FrameStats& stats = state.frame.stats;
    bool now[side_count] = {false, false}, blade[side_count] = {false, false};
    for (std::size_t k = 0; k < state.tools.size(); ++k) {
        const LiveTool& tool = state.tools[k];
        if (!tool.active || !(stats.touched & tool_bit(int(k)))) continue;
        now[tool.side] = true, blade[tool.side] = has_blade(tool);
    }
    for (int side = 0; side < side_count; ++side) {
        const Feel steady = stats[Count::yielded] == 0 ? Feel::nothing
                            : blade[side]              ? Feel::cutting
                                                       : Feel::yielding;
        if (now[side]) felt[side] = touched[side] ? steady : Feel::contact;
        touched[side] = now[side];
        cue[side].show(felt[side], newest.time);
    }
}

void HandCue::show(Feel feel, double time)
{
    if (feel == Feel::contact)
        struck = time;
    else if (feel != Feel::nothing)
        steady = feel, felt = time;
}

Vec3<float> HandCue::glow(double time) const
{
    constexpr Vec3<float> green{0.1f, 0.9f, 0.6f}, red{1, 0.25f, 0.15f};
    const auto left = [time](double since) {
        return clamp(float(1 - (time - since) / lasting), 0.f, 1.f);
    };
    return 2 * left(struck) * green +
           left(felt) * (steady == Feel::cutting ? 1.4f * red : 1.1f * green);
}

float strength_of(Feel feel)
{
    switch (feel) {
        case Feel::nothing:
            return 0;
        case Feel::contact:
            return 0.5f;
        case Feel::yielding:
            return 0.15f;
        case Feel::cutting:
            return 0.35f;
    }
    return 0;
}

}  // namespace knead
