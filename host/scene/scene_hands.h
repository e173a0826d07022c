// The hands of a scene.
#pragma once
#include "host/hands/recording.h"
#include "host/scene/scene.h"

namespace knead {

// Returns the recording of the scene: from a file, or a generated gesture on a ball as wide as the
// first object; without objects, of the default width. Throws InputError for an unreadable file,
// and for a name that is neither a file nor a gesture.
Recording hands_of(const Scene& scene);

}  // namespace knead
