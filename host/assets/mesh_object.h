// Meshes of a scene's objects: reads their files as closed bodies, which stay in memory.
#pragma once
#include <memory>

#include "host/scene/scene.h"

namespace knead {

// Reads the files of the scene's objects of shape `mesh` and sets Object::solid for build(). A file
// that was read with the same `up` and `turn`, and has not changed since, is not read again. Throws
// InputError with the object's place for a file that is no mesh or not closed, with the place of a
// hole, and for one that is larger than shape_fault() allows.
void load_meshes(Scene& scene);

// The body of an object whose file has been read, changed since or not; null if it has not been, or
// was forgotten after others: the sixteen that were read last are kept.
std::shared_ptr<const SolidMesh> known_solid(const Object& object);

}  // namespace knead
