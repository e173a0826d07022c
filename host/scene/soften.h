// Materials too stiff for the substeps that a frame may take are simulated softer: `soften_beyond`.
#pragma once
#include <string>

#include "host/scene/scene.h"

namespace knead {

// How many times softer than given a solid or liquid of the scene has to be for a frame of
// `step.soften_beyond` substeps, at rest: by the limit (22). 1: as it is, or the key is 0.
double softening(const Scene& scene, const Material<double>& given);

// The same material with elastic constants divided by `times`. What it yields at stays a stress:
// yield stress, hardening and cohesion in pascals are kept, and so are viscosity and density. The
// strains at which snow is packed and comes apart are kept.
Material<double> softer(Material<double> given, double times);

// Young's modulus; of a liquid the bulk modulus [Pa].
double elastic_modulus(const Material<double>& material);

// Softens the scene's objects and remembers how much. Throws InputError where a substep's length is
// given, and where a material would yield at no less than its own softened stiffness.
void soften(Scene& scene);

// For people: what an object of a softened scene is simulated with instead of what was given, and
// what follows. Empty where nothing was changed.
std::string softened_text(const Scene& scene, const Object& object);

}  // namespace knead
