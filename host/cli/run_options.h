// What the options of a run ask of its scene, and which of them do not go together.
#pragma once
#include "host/cli/verbs.h"
#include "host/scene/scene.h"

namespace knead {

// Read, not built. Throws InputError, UsageError.
Scene scene_of(const RunOptions& options);
// Throws UsageError.
void check_options(const RunOptions& options);

}  // namespace knead
