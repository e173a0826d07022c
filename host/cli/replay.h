// Replay by `knead run` of recorded actions other than hand motion.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "host/run/run.h"
#include "host/session/action_replay.h"

namespace knead {

using Note = std::function<void(const std::string&)>;

// Loads the action file beside the scene's recording; null if there is none. Throws InputError for
// an invalid file or one of another recording.
std::unique_ptr<ActionReplay> replay_of(const Scene& scene, const Recording& recording,
                                        const Note& note);
// Sets the run's tool motion and edits to the recorded ones. Refused actions are reported on
// standard error.
void play(ActionReplay& replay, SceneSplats& splats, RunObserver& watch);

// For a scene without hands: takes the hands that the live session added as its first action, if
// any. Returns false if there are none.
bool begin_with_hands(Scene& scene, const std::string& recording);

}  // namespace knead
