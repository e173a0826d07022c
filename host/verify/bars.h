// A free elastic bar, and how it rings.
#pragma once
#include <functional>
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead::bars {

constexpr double young = 1e6, density = 1000, bar = 1;  // [Pa] [kg/m^3] [m]

// A bar of 1 m along x, `cells` long and `thick` cells across, free of all walls. Where Poisson's
// ratio is 0, nothing moves across.
Setup free_bar(int cells, int thick, double poisson = 0);
// Its corner at the least coordinates.
Place corner_of(const Setup& bar);

// Amplitude of a mode in a series: v = A cos(w t + phase), by least squares over whole periods.
struct Ringing {
    double period, kept;  // [s]; amplitude after 4 periods over that at first
};
// From the mode's velocities at even times: period by the first and last zero, amplitude by the
// projections on cosine and sine over the first and the fifth period.
Ringing ringing(const std::vector<double>& u, double step);

// A velocity [m/s] by the place from corner_of().
using Field = std::function<Vec3<double>(Place)>;
// Velocities of all particles, with their gradients, are `share` of the field's.
void set_velocities(Setup& bar, const Field& field, double share);
// Lets the bar go with a thousandth of the field, and follows its share in what moves.
Ringing rung(Verification& v, Setup bar, double expected, const Field& field);

}  // namespace knead::bars
