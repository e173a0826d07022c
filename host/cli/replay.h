// What was done beside the hands of a recording, played by `knead run`.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "host/run/run.h"
#include "host/session/action_replay.h"

namespace knead {

using Note = std::function<void(const std::string&)>;

// Of the recording that the scene names, if it has a side file; else null. Throws InputError for
// one of another recording, or that cannot be.
std::unique_ptr<ActionReplay> replay_of(const Scene& scene, const Recording& recording,
                                        const Note& note);
// From now on the run's tools and edits are those. What is refused goes to standard error.
void play(ActionReplay& replay, SceneSplats& splats, RunWatch& watch);

// A live session gives a scene that names no hands some of its own, as its first action says: they
// are the scene's then. False where there are none.
bool begin_with_hands(Scene& scene, const std::string& recording);

}  // namespace knead
