// How hands take part in a scene.
#pragma once
#include <string>

#include "cuda/contact/contact.h"
#include "host/hands/hands.h"

namespace knead {

enum class Filter { none, average, adaptive };  // of recorded hands; see host/hands/filter.h

struct HandsOptions {
    std::string recording;  // path beside the scene, or a generator's name: "squeeze", ...
    double zoom = 1;        // simulation metres per real metre, about `at`
    Vec3<double> at{};      // where the recording's origin stands in the simulation [m]
    Topology topology = Topology::h25;
    std::string held[side_count];  // "" bare hand, or a tool's name
    bool present[side_count] = {true, true};
    ContactMode mode = ContactMode::separate;
    double friction = 0.4;  // Coulomb
    Filter filter = Filter::adaptive;
};

}  // namespace knead
