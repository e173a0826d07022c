// Options of the hands in a scene.
#pragma once
#include <string>

#include "cuda/contact/contact.h"
#include "host/hands/hands.h"

namespace knead {

enum class Filter { none, average, adaptive };  // of recorded hands; see host/hands/filter.h

struct HandsOptions {
    std::string recording;  // path relative to the scene, or a gesture: "squeeze", ...
    double zoom = 1;        // simulation metres per real metre, about `at`
    Vec3<double> at{};      // position of the recording's origin in the simulation [m]
    Topology topology = Topology::h25;
    std::string held[side_count];  // "": bare hand; otherwise a tool's name
    bool present[side_count] = {true, true};
    ContactMode mode = ContactMode::separate;
    double friction = 0.4;  // Coulomb coefficient [1]
    Filter filter = Filter::adaptive;
};

}  // namespace knead
