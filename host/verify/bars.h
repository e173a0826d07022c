// A free elastic bar and its vibration.
#pragma once
#include <functional>
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead::bars {

constexpr double young = 1e6, density = 1000, bar = 1;  // [Pa] [kg/m^3] [m]

// A bar of 1 m along x, `cells` cells long and `thick` cells wide, away from all walls. With
// Poisson's ratio 0 there is no transverse motion.
Setup free_bar(int cells, int thick, double poisson = 0);
// Corner of the bar with the least coordinates [m].
Place corner_of(const Setup& bar);

// Period and decay of a mode v = A cos(w t + phase).
struct Ringing {
    double period, kept;  // [s]; amplitude after 4 periods over the initial one
};
// From the mode's velocities at intervals of `step` [s]: period from the first and the ninth zero
// crossing, amplitudes by projection on cosine and sine over the first and the fifth period.
Ringing ringing(const std::vector<double>& u, double step);

// Velocity [m/s] at a position relative to corner_of() [m].
using Field = std::function<Vec3<double>(Place)>;
// Sets velocities and velocity gradients of all particles to `share` times the field.
void set_velocities(Setup& bar, const Field& field, double share);
// Releases the bar with 1/1000 of the field as velocities and measures the amplitude of that mode.
// `expected`: period by theory [s].
Ringing rung(Verification& v, Setup bar, double expected, const Field& field);

}  // namespace knead::bars
