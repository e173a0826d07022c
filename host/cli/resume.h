// A run that goes on: what its checkpoint keeps of how it was asked for, and back.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/cli/verbs.h"
#include "host/paging/scene_splats.h"
#include "host/run/checkpoint.h"

namespace knead {

// `device`: that the run has; cpu_seconds: of the process so far.
nlohmann::json command_of(const RunOptions& asked, const std::string& device, double cpu_seconds,
                          const Scene& scene);
// How the run of the checkpoint in now.resume was asked for; threads, limit, checkpoints and
// messages as asked for now. Throws InputError where its scene or hands are others by now.
RunOptions options_of(const Checkpoint& from, const RunOptions& now);
double cpu_seconds_of(const Checkpoint& from);

// Puts the solver, made of the checkpoint's scene, into its state. Throws InputError.
// `scene` is that of the run, built anew.
void load(Solver& solver, const Checkpoint& from, const Scene& scene, SceneSplats& splats,
          const std::string& file);

}  // namespace knead
