// What a material feels like, in a few words beside its pascals.
#pragma once
#include <string>

#include "host/solver/material_spec.h"

namespace knead {

// For example "soft, keeps a light press". The words of the yield stress compare it with a
// fingertip of 1 cm^2: 1 N is 10 kPa.
std::string feel_of(const MaterialSpec& material);

}  // namespace knead
