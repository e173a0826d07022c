// Named materials.
#pragma once
#include <string>
#include <vector>

#include "host/scene/scene.h"
#include "host/solver/material_spec.h"

namespace knead {

const std::vector<MaterialSpec>& material_specs();
const MaterialSpec& material_spec(const std::string& name);  // throws InputError that suggests the
                                                             // nearest name

}  // namespace knead
