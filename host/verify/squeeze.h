// A ball of clay squeezed between two round tools, at any cell size, and the distance between two
// of its results.
#pragma once
#include <vector>

#include "host/verify/scene_options.h"

namespace knead {

// Particle positions relative to the ball's centre [m], initial and final.
struct Squeezed {
    std::vector<Place> from, to;
    double apart = 0;       // initial particle spacing [m]
    std::vector<Place> at;  // final positions of probes(), by carried()
    FrameStats stats;
    double seconds = 0;  // of simulating
    double inside = 0;   // Driven::inside [m]
};
Squeezed squeezed(const Verification& v, const SceneOptions& options);
// The ball alone, centred in a box of 1 m.
struct BallOfClay {
    Setup setup;
    Place middle;
};
BallOfClay ball_of_clay(const SceneOptions& options, double friction);
// Simulates the clay in `setup` from 0 to `end` [s] with tool joints `at(t)`; positions relative to
// `middle`.
Squeezed followed(const Verification& v, const SceneOptions& options, Setup setup, Place middle,
                  double end, const std::function<std::vector<Joint<double>>(double)>& at);

// Second moments about the centre [m^2].
Sym3<double> gyration(const std::vector<Place>& places);
// Distance between two shapes after removing a rigid motion, and that motion.
struct Apart {
    double rms = 0;           // [m]
    double shift = 0;         // [m]
    double turn = 0;          // [rad]
    std::size_t matched = 0;  // number of compared points
};
// Final positions of about 2000 fixed points of the ball, each by a least-squares linear map of the
// particles around it. NaN where there are too few.
std::vector<Place> carried(const Squeezed& s);
// Compares two results of carried().
Apart apart(const std::vector<Place>& coarse, const std::vector<Place>& fine);

// Speed of a ball after release by two tools, one after the other: over positions relative to the
// nodes, at two cell sizes. Part of suite `squeeze`.
void release_checks(Verification& v);

constexpr double squeeze_radius = 0.2;  // of the ball [m]

}  // namespace knead
