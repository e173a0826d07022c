// Applies the options of a run to its scene, and checks which of them exclude each other.
#pragma once
#include "host/cli/verbs.h"
#include "host/scene/scene.h"

namespace knead {

// All --set of the options, and those that other options stand for. Throws InputError.
std::vector<std::string> settings_of(const RunOptions& options);
// Reads the scene without building it. Throws InputError, UsageError.
Scene scene_of(const RunOptions& options);
// Throws UsageError.
void check_options(const RunOptions& options);

}  // namespace knead
