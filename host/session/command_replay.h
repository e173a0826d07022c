// Applies a log of commands in a batch run, each between the two frames that the log gives.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "host/document/actions_file.h"
#include "host/hands/filter.h"
#include "host/hands/motion.h"
#include "host/session/scene_editor.h"

namespace knead {

// Recorded hands in a run whose commands change tools, zoom and position. Restarts the hand filter
// after the same frames as the session did.
class RecordedHands {
  public:
    // `options`: the scene's hands. `rate`: simulated frames per second of the recording. Throws
    // InputError for a recording that check() refuses.
    RecordedHands(Recording recording, const HandsOptions& options, double rate);
    // Motion of the tools in the frame from `from` to `to` [s of the recording].
    Motion motion(double from, double to) const { return source(from, to); }
    void set(const HandsOptions& options, long number);  // after frame `number`

  private:
    void begin(double after);

    const Recording recording;
    HandsOptions options;
    const double rate;
    MotionSource source;
};

// Applies a command in a batch run, if it is available there.
std::optional<Refusal> apply_in_run(SceneEditor& editor, const Command& command);

class CommandReplay {
  public:
    // `log` in order of frames.
    explicit CommandReplay(std::vector<LogEntry> entries) : log(std::move(entries)) {}

    struct By {
        std::function<std::optional<Refusal>(const Command&)> apply;
        // Called for each entry that is refused; may throw to end the run.
        std::function<void(const LogEntry&, const Refusal&)> refused;
        // Entries before the first for which this is false are applied; null: all.
        std::function<bool(const LogEntry&)> may{};
    };
    // Applies the entries of frame `number` with no frame in flight; motions of older recordings by
    // the editor.
    void after_frame(long number, SceneEditor& editor, const By& by);
    std::size_t left() const { return log.size() - next; }  // entries not reached yet
    // Whether entries of frame `number` wait.
    bool due(long number) const { return next < log.size() && log[next].frame <= number; }

  private:
    const std::vector<LogEntry> log;
    std::size_t next = 0;
};

}  // namespace knead
