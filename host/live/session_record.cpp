#include "host/live/session_record.h"

#include <algorithm>
#include <cmath>

#include "host/document/command_table.h"

namespace knead {
namespace {

constexpr std::size_t longest_recording = 90 * 3600;  // frames

}  // namespace

void SessionRecord::begin(const LiveScene& scene, int number, double now)
{
    history = number;
    began = now, rate = scene.scene.frame_rate;
    hands.frames.clear();
    commands = {scene.scene.path, scene.settings, "", {}};
    add({});
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

void SessionRecord::add(std::vector<AppliedCommand> applied)
{
    waiting.insert(waiting.end(), std::make_move_iterator(applied.begin()),
                   std::make_move_iterator(applied.end()));
    for (const AppliedCommand& one : waiting)
        if (one.history == history) put(one);
    std::erase_if(waiting, [&](const AppliedCommand& one) { return one.history <= history; });
}

void SessionRecord::put(const AppliedCommand& applied)
{
    constexpr double rounding = 1e-9;  // [s]
    std::vector<LoggedCommand>& all = commands.commands;
    if (all.size() >= most_commands) {
        if (!commands_full)
            notify("the limit of recorded commands is reached; further ones are not recorded");
        commands_full = true;
        return;
    }
    const long before = all.empty() ? 0 : all.back().frame;
    const long frame = long(std::floor((applied.time - began + rounding) * rate));
    Command command = applied.issued.command;
    const bool begins = std::holds_alternative<Open>(command) ||
                        std::holds_alternative<Reset>(command) ||
                        std::holds_alternative<SetLattice>(command);
    if (begins) command = Mark{row_of(command).name};  // a run of the log begins the scene itself
    all.push_back({applied.frame == 0 ? 0 : std::max(before, frame), std::move(command)});
}

}  // namespace knead
