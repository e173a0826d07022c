// A ball of clay between two round tools that close on it, at any size of cells; and how far two of
// its results are from each other.
#pragma once
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {

struct SqueezeRule {
    int cells = 32;      // along 1 m
    int per_axis = 2;    // particles along a cell
    double courant = 0;  // 0: the default
    bool in_double = false;
};

// Places about the ball's middle, [m], where they began and where they ended.
struct Squeezed {
    std::vector<Place> from, to;
    double apart = 0;  // of neighbouring particles at first [m]
    FrameStats stats;
    double seconds = 0;  // of simulating
};
Squeezed squeezed(const Verification& v, const SqueezeRule& rule);
// The ball alone, its middle in the middle of a room of 1 m.
struct BallOfClay {
    Setup setup;
    Place middle;
};
BallOfClay ball_of_clay(const SqueezeRule& rule, double friction);
// Any clay in `setup` about `middle`, from 0 to `end` [s], with tools where `at` says.
Squeezed followed(const Verification& v, const SqueezeRule& rule, Setup setup, Place middle,
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
// Where both took the same 2000 places of the ball.
Apart apart(const Squeezed& coarse, const Squeezed& fine);

// How fast a ball leaves two tools that let it go one after the other: over places of the same ball
// and tools between the nodes, at two sizes of cells. Part of `squeeze`.
void release_checks(Verification& v);

constexpr double squeeze_radius = 0.2;  // of the ball [m]

}  // namespace knead
