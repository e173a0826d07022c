#include "host/live/session_record.h"

#include <algorithm>

namespace knead {
namespace {

constexpr std::size_t longest_recording = 90 * 3600;  // frames

}  // namespace

void SessionRecord::begin(const LiveScene& scene, double now)
{
    began = done_to = now;
    hands.frames.clear();
    actions = {scene.scene.path, scene.settings, "", {}};
    if (began_by.empty()) return;
    HandAction by;
    by.by = began_by;
    act(by);
}

bool SessionRecord::frame(HandFrame given, double now)
{
    std::vector<HandFrame>& kept = hands.frames;
    given.time = now - began;
    if (!kept.empty() && !(given.time > kept.back().time)) return false;
    if (kept.size() >= longest_recording && !hands_full)
        notify("the recording has reached one hour; the rest is not recorded");
    hands_full = kept.size() >= longest_recording;
    if (hands_full) kept.pop_back();
    kept.push_back(given);
    return true;
}

void SessionRecord::act(HandAction done)
{
    std::vector<HandAction>& all = actions.all;
    done.time = std::max(all.empty() ? 0.0 : all.back().time, done_to - began);
    if (all.size() < most_actions) return all.push_back(done);
    if (!actions_full)
        notify("the limit of recorded actions is reached; further ones are not recorded");
    actions_full = true;
}

void SessionRecord::pause(bool on)
{
    HandAction action;
    action.act = ActionType::pause, action.on = on;
    act(action);
}

}  // namespace knead
