// Independent implementation of the constitutive laws, from textbooks: by the singular values of
// the deformation gradient F, in double. Shares only the material constants with cuda/mpm.
#pragma once
#include <random>

#include "cuda/math/vec.h"
#include "cuda/mpm/material_data.h"

namespace knead::oracle {

// State at the left Cauchy-Green tensor I + e.
struct StressState {
    Sym3<double> tau;  // Kirchhoff stress [Pa]
    double energy;     // per volume at rest [J/m^3]
    double log_J;      // [1]
};
// State of a solid; `factor` scales both Lame parameters (hardening of snow).
StressState solid(const Material<double>& m, const Sym3<double>& e, double factor = 1);

// Magnitude of the deviator, and pressure (minus the mean), of a stress [Pa].
double shear(const Sym3<double>& tau);
double pressure(const Sym3<double>& tau);
// Largest deviator magnitude over pressure on the Matsuoka-Nakai cone in the direction of tau's
// deviator; `friction` is the value in triaxial compression.
double cone(const Sym3<double>& tau, double friction);

// Reproducible random states.
class Draw {
  public:
    explicit Draw(unsigned seed) : engine(seed) {}
    double in(double low, double high)
    {
        return low + (high - low) * double(engine() >> 11) * 0x1p-53;
    }
    int below(int n) { return int(engine() % std::uint64_t(n)); }
    Mat3<double> rotation();
    // b - I with principal stretches in [low, high], randomly rotated.
    Sym3<double> strain(double low, double high);

  private:
    std::mt19937_64 engine;
};

}  // namespace knead::oracle
