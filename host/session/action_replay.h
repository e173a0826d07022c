// Replays a recording with its recorded actions (hand_actions.h): the same edits between the same
// frames, and the hand filter restarted where it was.
#pragma once
#include <functional>
#include <string>

#include "host/hands/filter.h"
#include "host/hands/motion.h"
#include "host/paging/scene_splats.h"
#include "host/session/hand_actions.h"
#include "host/session/loop.h"

namespace knead {

class ActionReplay {
  public:
    // `options`: the scene's hands. `rate`: simulated frames per second of the recording. Throws
    // InputError for a recording that check() refuses.
    ActionReplay(Recording recording, const HandsOptions& options, double rate,
                 std::vector<HandAction> actions);
    ActionReplay(const ActionReplay&) = delete;

    // Motion of the tools in the frame from `from` to `to` [s of the recording].
    Motion motion(double from, double to) const { return source(from, to); }
    // Queues in the loop the actions that precede frame `number` + 1. `refused` is called with a
    // message for each edit that the solver refuses, as in the recorded session.
    void before_frame(int number, SessionLoop& loop, SceneSplats& splats,
                      const std::function<void(const std::string&)>& refused);
    double duration() const { return recording.frames.back().time; }  // of the recording [s]

  private:
    void perform(const HandAction& action, int number, EditableSimulator& solver,
                 SceneSplats& splats);
    void begin_hands(double after);

    const Recording recording;
    HandsOptions options;
    const double rate;
    const std::vector<HandAction> actions;
    std::size_t next = 0;
    MotionSource source;
};

}  // namespace knead
