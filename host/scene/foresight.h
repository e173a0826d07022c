// Estimate of the substeps of a frame, before the scene is run.
#pragma once
#include <string>

#include "host/scene/scene.h"

namespace knead {

struct Foresight {
    double dt = 0;        // of the first substep, without tools [s]
    double substeps = 0;  // per frame
    std::string key;      // scene key that limits dt: "objects.7.material.viscosity"
};
// From longest_dt() of the clay in its initial state. Tools and faster clay may need more substeps.
Foresight foresee(const Scene& scene);

// Throws InputError if the estimate exceeds `step.most_substeps`.
void check_substeps(const Scene& scene);
// The same for an edit: throws std::invalid_argument if clay of that material, at rest, would need
// more. Such a frame would end a session in stepped time and occupy a GPU for minutes.
void check_substeps(const Scene& scene, const Material<double>& material);

}  // namespace knead
