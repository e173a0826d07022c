// The constitutive laws once more, from textbooks: of the deformation gradient F, by its singular
// values, in double. Shares nothing with cuda/mpm but the constants of a material.
#pragma once
#include <random>

#include "cuda/math/vec.h"
#include "cuda/mpm/material_data.h"

namespace knead::oracle {

// What the laws say at the left Cauchy-Green tensor I + e.
struct State {
    Sym3<double> tau;  // Kirchhoff stress [Pa]
    double energy;     // per volume at rest [J/m^3]
    double log_J;      // [1]
};
// A solid; factor: on both Lame parameters (snow's hardening).
State solid(const Material<double>& m, const Sym3<double>& e, double factor = 1);

// Magnitudes of the deviator, and minus the mean, of a stress [Pa].
double shear(const Sym3<double>& tau);
double pressure(const Sym3<double>& tau);
// The magnitude that Matsuoka and Nakai's cone allows a deviator in the direction of tau's, over
// the pressure; `friction` in triaxial compression.
double cone(const Sym3<double>& tau, double friction);

// Random states, the same on every run.
class Draw {
  public:
    explicit Draw(unsigned seed) : engine(seed) {}
    double in(double low, double high)
    {
        return low + (high - low) * double(engine() >> 11) * 0x1p-53;
    }
    int below(int n) { return int(engine() % std::uint64_t(n)); }
    Mat3<double> rotation();
    // b - I of principal stretches in [low, high], turned anyhow.
    Sym3<double> strain(double low, double high);

  private:
    std::mt19937_64 engine;
};

}  // namespace knead::oracle
