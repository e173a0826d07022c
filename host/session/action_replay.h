// A recording played again with what was done beside it (hand_actions.h): the same edits between
// the same frames, and hands that begin anew where they did.
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
    // `options`: the scene's hands. `rate`: frames of the simulation per second of the recording.
    // Throws InputError for a recording that check() refuses.
    ActionReplay(Recording recording, const HandsOptions& options, double rate,
                 std::vector<HandAction> actions);
    ActionReplay(const ActionReplay&) = delete;

    // The tools in the frame from `from` to `to` [s of the recording].
    Motion motion(double from, double to) const { return source(from, to); }
    // Hands the loop what was done before the frame that follows the one of that number. What a
    // solver refuses it refused then, too; `refused` is told.
    void before_frame(int number, SessionLoop& loop, SceneSplats& splats,
                      const std::function<void(const std::string&)>& refused);
    // Of the recording [s].
    double duration() const { return recording.frames.back().time; }

  private:
    void perform(const HandAction& action, int number, Solver& solver, SceneSplats& splats);
    void begin_hands(double after);

    const Recording recording;
    HandsOptions options;
    const double rate;
    const std::vector<HandAction> actions;
    std::size_t next = 0;
    MotionSource source;
};

}  // namespace knead
