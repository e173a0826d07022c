// convergence: torsional vibration of a free elastic bar, against Saint-Venant's theory.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "host/verify/bars.h"
#include "host/verify/cases.h"

namespace knead {
namespace {
using std::numbers::pi;
using namespace bars;

constexpr double poisson = 0.3, slender = 8;  // length over thickness

// First torsional mode of a free bar: rotation about its axis by cos(pi x / L).
Field twisting(double thick)
{
    return [thick](Place r) {
        const double angle = std::cos(pi * r.x / bar), y = r.y - thick / 2, z = r.z - thick / 2;
        return Vec3<double>{0, -angle * z, angle * y};
    };
}

// A square section of edge a has the torsional stiffness 0.1406 mu a^4 [Timoshenko & Goodier 1970,
// article 109] and the polar moment a^4 / 6. Warping inertia adds 1e-4 to the period here.
double torsion_period()
{
    const double mu = young / (2 * (1 + poisson));
    return 2 * bar / std::sqrt(6 * 0.1406 * mu / density);
}

double period_off(Verification& v, int thick, double& kept)
{
    const double expected = torsion_period();
    const Ringing r =
        rung(v, free_bar(int(slender) * thick, thick, poisson), expected, twisting(bar / slender));
    kept = r.kept;
    return 100 * (r.period / expected - 1);
}

// Bounds as for bending at the same thickness in cells.
void ringing_bar(Verification& v)
{
    const std::string advice = "thin parts twist too easily or too hard: refine";
    double kept = 0;
    const double rough = period_off(v, 4, kept);
    v.add(near("twisted bar 4 cells thick: period, off 2 L / c", rough, 0, 5, "%", advice));
    const auto lost = [&](int thick) {
        v.add(at_most(
            fmt::format("twisted bar {} cells thick: amplitude lost after 4 periods", thick),
            100 * (1 - kept), 5, "%",
            "clay rings shorter than it should; longer substeps lose less"));
    };
    lost(4);
    if (v.quick()) return;
    const double fine = period_off(v, 8, kept);
    lost(8);
    v.add(at_most("twisted bar: error at 8 cells over that at 4", std::fabs(fine / rough), 0.5, "",
                  "refining thin parts does not help"));
}

// Amplitude between the ends: `turns` turns, without stiffening.
void violent(Verification& v)
{
    constexpr int thick = 4;
    constexpr double turns = 2;
    Case c{"twist", free_bar(int(slender) * thick, thick, poisson)};
    const double rate = turns * pi * 2 * pi / torsion_period();  // angular velocity of an end [1/s]
    set_velocities(c.setup, twisting(bar / slender), rate);
    c.end = 3 * torsion_period(), c.frame = torsion_period() / 60;
    const Outcome o = outcome_of(v, c, 60);
    Check check =
        at_most("bar twisted by two turns: energy at most, of that at first",
                o.ending == Ending::slow ? std::nan("")
                                         : 100 * o.energy / energy_of(c.setup.particles, c.setup),
                105, "%", "shorten the substep where clay is wrung");
    check.note = fmt::format("{}: {}", ending_name(o.ending), o.note);
    v.add(check);
    v.add(at_most("bar twisted by two turns: cases that failed", o.ending == Ending::failed, 0, "",
                  "shorten the substep where clay is wrung"));
}

}  // namespace

void twist_part(Verification& v) { ringing_bar(v), violent(v); }

}  // namespace knead
