#include "host/session/action_replay.h"

#include <fmt/format.h>

#include "host/hands/recording.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

constexpr double rounding = 1e-9;  // [s]

}  // namespace

ActionReplay::ActionReplay(Recording of, const HandsOptions& by, double per_second,
                           std::vector<HandAction> all)
    : recording(std::move(of)), options(by), rate(per_second), actions(std::move(all))
{
    check(recording);
    begin_hands(-1);
}

// Restarts the hand filter with the frames later than `after` [s].
void ActionReplay::begin_hands(double after)
{
    const auto stream = std::make_shared<HandStream>(options);
    for (const HandFrame& frame : recording.frames)
        if (frame.time > after) stream->push(frame);
    stream->close();
    source = stream_motion(stream, options);
}

void ActionReplay::perform(const HandAction& action, int number, EditableSimulator& solver,
                           SceneSplats& splats)
{
    switch (action.act) {
        case ActionType::began:
        case ActionType::pause:
            return;
        case ActionType::material:
            return splats.set_material(action.object, action.material, solver);
        case ActionType::gravity:
            return solver.set_gravity(action.gravity);
        case ActionType::move:
            return solver.move(action.object, action.motion);
        case ActionType::hands:
            break;
    }
    HandsOptions now = options;
    now.zoom = action.hands.zoom, now.at = action.hands.at;
    for (const Side side : {left, right})
        now.held[side] = action.hands.held[side], now.present[side] = action.hands.present[side];
    const HandTools tools = hand_tools(now);
    solver.set_tools(tools.rig, tools.tools);
    splats.set_rig(tools.rig);
    const bool alike = move_alike(now, options);
    options = now;
    if (alike) return;
    // The frames so far have consumed all hand frames up to the first one at or after their end.
    double last_time = -1;
    for (const HandFrame& frame : recording.frames) {
        if (number == 0 || last_time >= number / rate - rounding) break;
        last_time = frame.time;
    }
    begin_hands(last_time);
}

void ActionReplay::before_frame(int number, SessionLoop& loop, SceneSplats& splats,
                                const std::function<void(const std::string&)>& refused)
{
    const double end = (number + 1) / rate;
    for (; next < actions.size() && actions[next].time + rounding < end; ++next)
        loop.edit(
            [this, number, &splats, refused, &action = actions[next]](EditableSimulator& solver) {
                try {
                    perform(action, number, solver, splats);
                } catch (const std::exception& e) {
                    refused(fmt::format(
                        "the action at {:.6g} s is refused, as in the recorded session: {}",
                        action.time, e.what()));
                }
            });
}

}  // namespace knead
