// Bodies of clay and tools for the checks, built in code: no file and no random number decides.
#pragma once
#include <functional>
#include <vector>

#include "host/solver/solver.h"

namespace knead {

using Place = Vec3<double>;  // [m]

// A lattice of free cells between walls, 3 nodes inside of it.
Setup between_walls(Int3 cells, double dx, ContactMode mode, double friction);
// The middle of the floor.
Place floor_of(const Setup& setup);

Material<double> elastic(double young, double poisson, double density);
Material<double> plastic(double young, double poisson, double density, double yield);

// Adds an object: a particle in the middle of each cube of edge dx / per_axis, counted from `from`
// on, whose middle `inside` accepts. Returns the object.
int fill(
    Setup& setup, Material<double> material, Place from, Place to, int per_axis,
    const std::function<bool(Place)>& inside = [](Place) { return true; });

// Adds a tool of one sphere on a joint of its own; returns the joint.
int add_ball_tool(Setup& setup, double radius, ContactMode mode, double friction);

// In the order of the setup, whatever the solver.
std::vector<Particle<double>> by_id(const Solver& solver);

// Adds what a frame did to what those before it did.
void add_to(FrameStats& all, const FrameStats& frame);

// Advances in frames of `frame` [s] from t = 0 to `end`; tools are where `at` says. After each
// frame `look(time)` may end it by false. Returns all frames' counts in one.
FrameStats drive(Solver& solver, double frame, double end,
                 const std::function<std::vector<Joint<double>>(double)>& at,
                 const std::function<bool(double)>& look);
// Without tools.
FrameStats drive(Solver& solver, double frame, double end, const std::function<bool(double)>& look);

inline Joint<double> stands_at(Place p) { return {{1, 0, 0, 0}, p}; }

}  // namespace knead
