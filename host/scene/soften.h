// Softens materials that are too stiff for the substeps allowed per frame: `soften_beyond`.
#pragma once
#include <string>

#include "host/scene/scene.h"

namespace knead {

// Factor by which a solid or liquid must be softened so that a frame at rest takes
// `step.soften_beyond` substeps, by the limit (22). 1: no softening needed, or the key is 0.
double softening(const Scene& scene, const Material<double>& given);

// Returns the material with elastic constants divided by `times`. Yield limits stay stresses: yield
// stress, hardening and cohesion in pascals are kept, and so are viscosity and density. The
// critical strains of snow are kept.
Material<double> softer(Material<double> given, double times);

// Young's modulus; of a liquid the bulk modulus [Pa].
double elastic_modulus(const Material<double>& material);

// Sets the scene's materials from those that are stated, softens them, and stores the factors in
// the objects; may be repeated. Throws InputError if the length of a substep is given, and if a
// yield stress would reach or exceed the softened stiffness.
void soften(Scene& scene);

// Message for users: the softened values of an object beside the given ones, and the consequences.
// Empty if nothing was changed.
std::string softened_text(const Scene& scene, const Object& object);

}  // namespace knead
