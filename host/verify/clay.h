// Bodies of clay and tools for the checks, built in code, without files or random numbers.
#pragma once
#include <functional>
#include <vector>

#include "host/solver/simulator.h"

namespace knead {

using Place = Vec3<double>;  // [m]

// A lattice with `cells` free cells between walls, which are 3 nodes inside the lattice.
Setup between_walls(Int3 cells, double dx, ContactMode mode, double friction);
// Centre of the floor [m].
Place floor_of(const Setup& setup);

Material<double> elastic(double young, double poisson, double density);
Material<double> plastic(double young, double poisson, double density, double yield);

// Adds an object between `from` and `to`: a particle in the centre of each cube of edge dx /
// per_axis, starting at `from`, if `inside` accepts the centre. Returns the object's index.
int fill(
    Setup& setup, Material<double> material, Place from, Place to, int per_axis,
    const std::function<bool(Place)>& inside = [](Place) { return true; });

// Adds a tool of one sphere bound to a new joint; returns the joint's index.
int add_ball_tool(Setup& setup, double radius, ContactMode mode, double friction);

// Particles in the order of the setup, for any solver.
std::vector<Particle<double>> by_id(const Simulator& solver);

// Advances in frames of `frame` [s] from t = 0 to `end` [s], with tool joints `at(t)`. Calls
// `look(time)` after each frame; false ends the run. Returns the accumulated counters.
FrameStats drive(Simulator& solver, double frame, double end,
                 const std::function<std::vector<Joint<double>>(double)>& at,
                 const std::function<bool(double)>& observe);
// Without tools.
FrameStats drive(Simulator& solver, double frame, double end,
                 const std::function<bool(double)>& observe);

inline Joint<double> stands_at(Place p) { return {{1, 0, 0, 0}, p}; }

}  // namespace knead
