#include "host/session/command_replay.h"

#include "host/hands/recording.h"

namespace knead {

RecordedHands::RecordedHands(Recording of, const HandsOptions& by, double per_second)
    : recording(std::move(of)), options(by), rate(per_second)
{
    check(recording);
    begin(-1);
}

// Restarts the hand filter with the frames later than `after` [s].
void RecordedHands::begin(double after)
{
    const auto stream = std::make_shared<HandStream>(options);
    for (const HandFrame& frame : recording.frames)
        if (frame.time > after) stream->push(frame);
    stream->close();
    source = stream_motion(stream, options);
}

void RecordedHands::set(const HandsOptions& to, long number)
{
    constexpr double rounding = 1e-9;  // [s]
    const bool alike = move_alike(to, options);
    options = to;
    if (alike) return;
    // The frames so far have consumed all hand frames up to the first one at or after their end.
    double last_time = -1;
    for (const HandFrame& frame : recording.frames) {
        if (number == 0 || last_time >= double(number) / rate - rounding) break;
        last_time = frame.time;
    }
    begin(last_time);
}

std::optional<Refusal> apply_in_run(SceneEditor& editor, const Command& command)
{
    const std::string why = row_of(command).why_not(editor.situation(false));
    return why.empty() ? editor.apply(command).refusal : Refusal{why, ""};
}

void CommandReplay::after_frame(long number, SceneEditor& editor, const By& by)
{
    for (; next < log.size() && log[next].frame <= number; ++next) {
        const LogEntry& entry = log[next];
        if (by.may && !by.may(entry)) return;
        const Moved* moved = std::get_if<Moved>(&entry.done);
        const std::optional<Refusal> refusal = moved ? editor.move(moved->object, moved->motion)
                                                     : by.apply(std::get<Command>(entry.done));
        if (refusal) by.refused(entry, *refusal);
    }
}

}  // namespace knead
