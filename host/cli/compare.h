// Comparison of `knead compare`.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cuda/mpm/particle.h"
#include "host/cli/verbs.h"

namespace knead {

// Each returns an object with "agree", true or false. `o` has the file names for messages and the
// tolerances. Throws InputError for a report that lacks a mandatory quantity.
nlohmann::json compared(const nlohmann::json& first, const nlohmann::json& second,
                        const CompareOptions& o);
nlohmann::json compared(const std::vector<Particle<double>>& first,
                        const std::vector<Particle<double>>& second, const CompareOptions& o);
std::string text_of(const nlohmann::json& found);  // as text

}  // namespace knead
