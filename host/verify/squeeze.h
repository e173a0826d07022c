// A ball of clay between two round tools that close on it, at any size of cells; and how far two of
// its results are from each other.
#pragma once
#include <vector>

#include "host/verify/scene_options.h"

namespace knead {

// Places about the ball's middle, [m], where they began and where they ended.
struct Squeezed {
    std::vector<Place> from, to;
    double apart = 0;       // of neighbouring particles at first [m]
    std::vector<Place> at;  // where probes() were taken, below
    FrameStats stats;
    double seconds = 0;  // of simulating
    double inside = 0;   // Driven::inside [m]
};
Squeezed squeezed(const Verification& v, const SceneOptions& options);
// The ball alone, its middle in the middle of a room of 1 m.
struct BallOfClay {
    Setup setup;
    Place middle;
};
BallOfClay ball_of_clay(const SceneOptions& options, double friction);
// Any clay in `setup` about `middle`, from 0 to `end` [s], with tools where `at` says.
Squeezed followed(const Verification& v, const SceneOptions& options, Setup setup, Place middle,
                  double end, const std::function<std::vector<Joint<double>>(double)>& at);

// Second moments about the middle, [m^2].
Sym3<double> gyration(const std::vector<Place>& places);
// What is left between two shapes, and the rigid motion that was taken out.
struct Apart {
    double rms = 0;           // [m]
    double shift = 0;         // [m]
    double turn = 0;          // [rad]
    std::size_t matched = 0;  // places of the ball that were compared
};
// Where 2000 places of the ball, the same of all, were taken: by the map that is linear and fits
// the particles around each best. Not a number where there are too few.
std::vector<Place> carried(const Squeezed& s);
// Between two results of carried().
Apart apart(const std::vector<Place>& coarse, const std::vector<Place>& fine);

// How fast a ball leaves two tools that let it go one after the other: over places of the same ball
// and tools between the nodes, at two sizes of cells. Part of `squeeze`.
void release_checks(Verification& v);

constexpr double squeeze_radius = 0.2;  // of the ball [m]

}  // namespace knead
