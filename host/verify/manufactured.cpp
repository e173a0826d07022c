// convergence: manufactured solutions: prescribed motions with the body forces they require.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <tuple>

#include "host/verify/cases.h"

namespace knead {
namespace {
using std::numbers::pi;

constexpr double young = 1e6, density = 1000;  // [Pa] [kg/m^3]
const double bar_wave = std::sqrt(young / density);

// State of the clay with initial position X [m].
struct FieldState {
    Place x;
    Vec3<double> v, force;  // [m/s]; per mass [m/s^2]
    Sym3<double> e;         // F F^T - I
    Mat3<double> L;         // gradient of v [1/s]
};
using Exact = std::function<FieldState(Place X, double t)>;

// u_i = A sin(k X_i) sin(w t + phase_i) along `axes` axes [Wallstedt & Guilkey 2008]. F is diagonal
// and P_ii = mu (F_ii - 1 / F_ii) + lambda ln J / F_ii, of which only F_ii varies along axis i.
Exact along_axes(const Material<double>& m, double A, double k, int axes)
{
    const double w = k * bar_wave;
    return [=](Place X, double t) {
        double x[3] = {X.x, X.y, X.z}, v[3] = {}, F[3] = {1, 1, 1}, L[3] = {}, bend[3] = {};
        for (int i = 0; i < axes; ++i) {
            const double phase = w * t + 2 * pi / 3 * i, s = std::sin(k * x[i]),
                         c = std::cos(k * x[i]);
            v[i] = A * w * s * std::cos(phase);
            F[i] = 1 + A * k * c * std::sin(phase);
            L[i] = A * k * w * c * std::cos(phase) / F[i];
            bend[i] = -k * k * A * s * std::sin(phase);  // d F_ii / d X_i
            x[i] += A * s * std::sin(phase);
        }
        const double log_J = std::log(F[0] * F[1] * F[2]);
        double force[3] = {};
        for (int i = 0; i < axes; ++i) {
            const double slope = m.mu + (m.mu + m.lambda * (1 - log_J)) / (F[i] * F[i]);
            force[i] = (w * w / (k * k) - slope / density) * bend[i];
        }
        FieldState s{
            {x[0], x[1], x[2]}, {v[0], v[1], v[2]}, {force[0], force[1], force[2]}, {}, {}};
        s.e = {F[0] * F[0] - 1, F[1] * F[1] - 1, F[2] * F[2] - 1, 0, 0, 0};
        s.L = {{L[0], 0, 0}, {0, L[1], 0}, {0, 0, L[2]}};
        return s;
    };
}

// A ring from a to b about the z axis that expands and contracts by u = p(R) A sin(w t), with p' ~
// (R - a)(b - R), so that the faces are free of stress for nu = 0 [Wallstedt & Guilkey 2008].
Exact growing_ring(double A, double a, double b)
{
    const double w = pi * bar_wave, scale = 6 / (b * b * (b - 3 * a));
    return [=](Place X, double t) {
        const double R = std::hypot(X.x, X.y), T = A * std::sin(w * t),
                     rate = A * w * std::cos(w * t);
        const double p = scale * R * (-a * b + (a + b) / 2 * R - R * R / 3),
                     p1 = scale * (R - a) * (b - R), p2 = scale * (a + b - 2 * R);
        const double Fr = 1 + T * p1, Fa = 1 + T * p / R, mu = young / 2;
        const double div = mu * ((1 + 1 / (Fr * Fr)) * T * p2 + (Fr - 1 / Fr - Fa + 1 / Fa) / R);
        const Vec3<double> out{X.x / R, X.y / R, 0}, round{-out.y, out.x, 0};
        const auto polar = [&](double r, double angle) {
            return r * outer(out, out) + angle * outer(round, round);
        };
        FieldState s{
            X + (T * p) * out, (rate * p) * out, (-w * w * T * p - div / density) * out, {}, {}};
        s.e = symmetric(polar(Fr * Fr - 1, Fa * Fa - 1));
        s.L = polar(rate * p1 / Fr, rate * p / R / Fa);
        return s;
    };
}

// Periodic images: for each particle the index of its original, itself if it lies within [0,
// period). Images get their original's state in every substep.
std::vector<std::size_t> images(const std::vector<Place>& X, Place period, double h)
{
    std::vector<std::size_t> of;
    std::map<std::tuple<long, long, long>, std::size_t> at;
    const auto cell = [h](double x) { return std::lround(x / h - 0.5); };
    for (std::size_t i = 0; i < X.size(); ++i) at[{cell(X[i].x), cell(X[i].y), cell(X[i].z)}] = i;
    const auto within = [](double x, double p) { return x - p * std::floor(x / p); };
    for (const Place& x : X)
        of.push_back(at.at({cell(within(x.x, period.x)), cell(within(x.y, period.y)),
                            cell(within(x.z, period.z))}));
    return of;
}

// Maximum over time of the rms position error [m]. X is relative to `origin`.
double worst_error(Verification& v, Setup s, const Exact& exact, Place origin, double end,
                   const std::vector<std::size_t>& image)
{
    const double guess = 0.4 * s.lattice.dx / bar_wave;
    const long steps = long(std::ceil(end / guess));
    const double dt = end / double(steps);
    s.step.fixed = dt;
    std::vector<Place> X;
    for (Particle<double>& q : s.particles) {
        X.push_back(q.x - origin);
        // A substep moves positions from t to t + dt with the velocities at t + dt/2 (8).
        const FieldState now = exact(X.back(), 0), half = exact(X.back(), -dt / 2);
        q.x = origin + now.x, q.e = now.e, q.v = half.v, q.C = half.L;
    }
    const auto is_image = [&](std::size_t i) { return !image.empty() && image[i] != i; };
    auto solver = v.solver(s);
    double worst = 0;
    for (long n = 0; n < steps; ++n) {
        double sum = 0, count = 0;
        change(v, solver, s, [&](std::vector<Particle<double>>& all) {
            for (std::size_t i = 0; i < all.size(); ++i) {
                if (is_image(i)) continue;
                const FieldState now = exact(X[i], dt * double(n));
                const Vec3<double> off = all[i].x - origin - now.x;
                sum += dot(off, off), count += 1;
                all[i].v = all[i].v + dt * now.force;
            }
            for (std::size_t i = 0; i < all.size(); ++i) {
                if (!is_image(i)) continue;
                all[i] = all[image[i]];
                all[i].x = all[i].x + X[i] - X[image[i]];
            }
        });
        worst = std::fmax(worst, std::sqrt(sum / count));
        if (!std::isfinite(sum)) return std::nan("");
        solver->advance({}, dt);
    }
    return worst;
}

// A unit cube between slip walls: no shear stress, and zero normal displacement on them.
double in_cube(Verification& v, int n, double A)
{
    const Material<double> m = elastic(young, 0.3, density);
    Setup s = between_walls({n, n, n}, 1.0 / n, ContactMode::slip, 0);
    fill(s, m, s.walls.min, s.walls.max, 2);
    return worst_error(v, s, along_axes(m, A, pi, 3), s.walls.min, 2 / bar_wave, {});
}

// The same motion in a plane, periodic after 1 m and across after one cell: no wall, no free
// surface.
double repeated(Verification& v, int n, double A)
{
    const Material<double> m = elastic(young, 0.3, density);
    const double dx = 1.0 / n;
    Setup s = between_walls({n + 8, n + 8, 9}, dx, ContactMode::separate, 0);
    const Place low = s.walls.min + Place{dx, dx, dx};
    fill(s, m, low, low + Place{1 + 6 * dx, 1 + 6 * dx, 7 * dx}, 2);
    const Place origin = low + Place{3 * dx, 3 * dx, 3 * dx};
    std::vector<Place> X;
    for (const Particle<double>& q : s.particles) X.push_back(q.x - origin);
    return worst_error(v, s, along_axes(m, A, 2 * pi, 2), origin, 1 / bar_wave,
                       images(X, {1, 1, dx}, dx / 2));
}

double in_ring(Verification& v, int n, double A)
{
    const double dx = 1.0 / n, a = 0.4, b = 0.6;
    const int half = int(std::ceil((b + A) * n)) + 4;
    Setup s = between_walls({2 * half, 2 * half, 10}, dx, ContactMode::separate, 0);
    const Place axis = 0.5 * (s.walls.min + s.walls.max);
    fill(s, elastic(young, 0, density), s.walls.min + Place{0, 0, 4 * dx},
         s.walls.max - Place{0, 0, 4 * dx}, 2, [&](Place x) {
             const double R = std::hypot(x.x - axis.x, x.y - axis.y);
             return R > a && R < b;
         });
    return worst_error(v, s, growing_ring(A, a, b), axis, 2 / bar_wave, {});
}

using Error = double (*)(Verification&, int, double);

// Displacement errors over the amplitude A at n and 2 n cells per metre, and their order.
void order(Verification& v, const char* name, Error error, int n, double A, double bound,
           const char* advice)
{
    const double rough = error(v, n, A) / A, fine = error(v, 2 * n, A) / A;
    Check c =
        at_least(fmt::format("manufactured, {}, A = {} m, {} to {} cells/m: order of the error",
                             name, A, n, 2 * n),
                 std::log2(rough / fine), bound, "", advice);
    c.note = fmt::format("{:.3g} % and {:.3g} % of A at {} and {} cells a metre", 100 * rough,
                         100 * fine, n, 2 * n);
    v.add(c);
}

}  // namespace

// A round body of cubes has a stepped face, whose area does not converge: only first order is
// required there.
void manufactured_part(Verification& v)
{
    const bool quick = v.quick();
    for (const double A : {0.005, 0.05})
        order(v, "periodic", repeated, quick ? 12 : 16, A, 1.8,
              "halving dx gains less than 4 times");
    for (const double A : {0.01, 0.1})
        order(v, "cube between walls", in_cube, quick ? 8 : 16, A, 1.8,
              "27 particles a cell where clay is stretched over many cells");
    order(v, "ring", in_ring, quick ? 20 : 40, 0.01, 1, "refine round parts");
    if (!quick)
        order(v, "ring", in_ring, 40, 0.1, 1,
              "27 particles a cell where clay is stretched over many cells");
}

}  // namespace knead
