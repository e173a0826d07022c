// The hands that a scene names.
#pragma once
#include "host/hands/recording.h"
#include "host/scene/scene.h"

namespace knead {

// The recording that the scene names: a file, or a scripted gesture on a ball as wide as its first
// object. Throws InputError for a file that cannot be read, and for a name that is neither.
Recording hands_of(const Scene& scene);

}  // namespace knead
