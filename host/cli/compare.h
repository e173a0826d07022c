// What `knead compare` finds.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cuda/mpm/particle.h"
#include "host/cli/verbs.h"

namespace knead {

// Each answers an object with "agree", true or false. `o` names the two for messages and says how
// far they may be apart. Throws InputError for a report without a quantity that every report has.
nlohmann::json compared(const nlohmann::json& first, const nlohmann::json& second,
                        const CompareOptions& o);
nlohmann::json compared(const std::vector<Particle<double>>& first,
                        const std::vector<Particle<double>>& second, const CompareOptions& o);
std::string told(const nlohmann::json& found);  // for people

}  // namespace knead
