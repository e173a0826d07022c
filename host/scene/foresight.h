// How many substeps a frame will take, as far as a scene says before it is run.
#pragma once
#include <string>

#include "host/scene/scene.h"

namespace knead {

struct Foresight {
    double dt = 0;        // of the first substep, with no tool about [s]
    double substeps = 0;  // a frame
    std::string key;      // of the scene, which asks for them: "objects.7.material.viscosity"
};
// By longest_dt() of the clay as the objects bring it. Tools and faster clay may need more.
Foresight foresee(const Scene& scene);

// Throws InputError where that is more than `step.most_substeps`.
void check_substeps(const Scene& scene);
// The same for an edit: throws std::invalid_argument where clay of that material, at rest, would
// need more. Such a frame would end a stepped session, and a GPU would not answer for minutes.
void check_substeps(const Scene& scene, const Material<double>& material);

}  // namespace knead
