// Resuming a run: its options to and from the checkpoint.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/cli/verbs.h"
#include "host/paging/scene_splats.h"
#include "host/run/checkpoint.h"

namespace knead {

// The options as JSON. `device`: the device in use; cpu_seconds: CPU time of the run so far [s].
nlohmann::json command_of(const RunOptions& given, const std::string& device, double cpu_seconds,
                          const Scene& scene);
// Options of the run in now.resume, except threads, time limit, checkpoint interval and verbosity,
// which are taken from `now`. Throws InputError if the files of its scene, hands or splats have
// changed.
RunOptions options_of(const Checkpoint& from, const RunOptions& now);
double cpu_seconds_of(const Checkpoint& from);

// Restores the checkpoint's state in `solver` and `splats`, both made from `scene`, the rebuilt
// scene of the run. Throws InputError if they do not match.
void load(EditableSimulator& solver, const Checkpoint& from, const Scene& scene,
          SceneSplats& splats, const std::string& file);

}  // namespace knead
