// accuracy: an elastic ball pressed between two rigid ones, against Hertz.
#include <fmt/format.h>

#include <cmath>

#include "host/verify/clay.h"
#include "host/verify/oracle.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

constexpr double young = 1e6, poisson = 0.3, density = 1000, dx = 0.01;

// Force at indentation d of each tool, R_eff = R/2, E* = E / (1 - nu^2) [Johnson 1985, 4.2]:
// d = (F / (4/3 E* sqrt(R_eff)))^(2/3). A ball under two forces deforms less than a half space: for
// nu = 0.3, Lur'e's series for a sphere under two caps of Hertz's pressure [Lur'e 1964, chapter 6]
// is lower by 0.178 F / (E R) at cap radius 0.2 R, by 0.187 F / (E R) at 0.25 R.
double hertz_force(double d, double R)
{
    const double stiff = 4.0 / 3 * young / (1 - poisson * poisson) * std::sqrt(R / 2);
    const double far = 0.183 / (young * R);
    double F = 0;
    for (int i = 0; i < 50; ++i) F = stiff * std::pow(d + far * F, 1.5);
    return F;
}

struct Pressed {
    double force;  // over Hertz's, mean from d = R/12 to R/8
    double early;  // maximum force before contact, over that at R/8
};

// Both tools advance by d = R/8 slowly: sound crosses the ball 13 times meanwhile. The force is the
// mean over a slab of width R/2 about the ball's middle, by the oracle's stresses.
Pressed pressed(Verification& v, int cells)
{
    const double R = cells * dx, speed = 0.01 * std::sqrt(young / density), deep = R / 8;
    Setup s =
        between_walls({2 * cells + 8, 2 * cells + 8, 2 * cells + 8}, dx, ContactMode::separate, 0);
    const Place middle = 0.5 * (s.walls.min + s.walls.max);
    const Material<double> m = elastic(young, poisson, density);
    fill(s, m, s.walls.min, s.walls.max, 2, [&](Place x) { return length(x - middle) < R; });
    for (int i = 0; i < 2; ++i) add_ball_tool(s, R, ContactMode::separate, 0);
    const double start = dx, end = (start + deep) / speed;
    const auto at = [&](double t) {
        const double x = 2 * R + start - speed * t;
        return std::vector{stands_at(middle + Place{-x, 0, 0}), stands_at(middle + Place{x, 0, 0})};
    };
    const double volume = s.materials[0].volume, wide = R / 2;
    const auto solver = v.solver(s);
    double ratio = 0, count = 0, early = 0;
    drive(*solver, end / 100, end, at, [&](double t) {
        const double now = speed * t - start;
        if (now < -dx) return true;
        double sum = 0;
        for (const Particle<double>& q : solver->particles())
            if (std::fabs(q.x.x - middle.x) < wide / 2)
                sum -= volume * oracle::solid(m, q.e).tau.xx;
        if (now < 0) early = std::fmax(early, sum / wide);
        if (now > deep / 1.5) ratio += sum / wide / hertz_force(now, R), count += 1;
        return true;
    });
    return {ratio / count, early / hertz_force(deep, R)};
}

}  // namespace

void hertz_part(Verification& v)
{
    for (const int cells : v.quick() ? std::vector{8} : std::vector{8, 12, 16}) {
        const Pressed p = pressed(v, cells);
        const std::string name = fmt::format("ball of R = {} dx between tools: ", cells);
        v.add(near(name + "force, of Hertz's", 100 * p.force, 100, 5, "%",
                   "refine until tools go in by two cells or more"));
        v.add(at_most(name + "force before they touch", 100 * p.early, 5, "%",
                      "tools touch clay too early or too late: move them by that"));
    }
}

}  // namespace knead
