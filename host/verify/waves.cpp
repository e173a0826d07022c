// convergence: vibration of free elastic bodies, against wave and beam theory.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/verify/bars.h"
#include "host/verify/verify.h"

namespace knead {
namespace {
using std::numbers::pi;
using namespace bars;

void longitudinal(Verification& v)
{
    const double c = std::sqrt(young / density), expected = 2 * bar / c;
    double off[2] = {};
    const int sizes[2] = {32, 64};
    const double period_bound[2] = {0.5, 0.15}, lost_bound[2] = {1.5, 0.3};
    for (int i = 0; i < 2; ++i) {
        const Ringing r = rung(v, free_bar(sizes[i], 4), expected, [](Place x) {
            return Place{std::cos(pi * x.x / bar), 0, 0};
        });
        off[i] = r.period / expected - 1;
        v.add(near(fmt::format("bar of {} cells: longitudinal period, off 2L/c", sizes[i]),
                   100 * off[i], 0, period_bound[i], "%", "waves of few cells run slow: refine"));
        v.add(at_most(fmt::format("bar of {} cells: amplitude lost after 4 periods", sizes[i]),
                      100 * (1 - r.kept), lost_bound[i], "%",
                      "clay rings shorter than it should; longer substeps lose less"));
    }
    v.add(at_least("bar: order of the period's error", std::log2(std::fabs(off[0] / off[1])), 1.8,
                   "", "halving dx gains less than it should"));
}

// Period of the first bending mode of a free beam of unit length and thickness h after Timoshenko,
// by Ritz's method with Legendre polynomials: exact to the digits that matter here.
double bending_period(double h, double poisson)
{
    constexpr int n = 10, points = 24;
    const double G = young / (2 * (1 + poisson));
    const double factor = 10 * (1 + poisson) / (12 + 11 * poisson);  // [Cowper 1966]
    const double shear = factor * G * h * h, stiff = young * h * h * h * h / 12,
                 mass = density * h * h, inertia = density * h * h * h * h / 12;
    ::Eigen::MatrixXd K = ::Eigen::MatrixXd::Zero(2 * n, 2 * n), M = K;
    for (int i = 0; i < points; ++i) {  // midpoint rule in the angle: Gauss-Chebyshev
        const double angle = pi * (i + 0.5) / points, s = std::cos(angle);
        double weight = 0;  // Fejer
        for (int k = 1; k <= points / 2; ++k) weight += std::cos(2 * k * angle) / (4.0 * k * k - 1);
        weight = (1 - 2 * weight) / points;  // of [0, 1]
        ::Eigen::VectorXd p(n), d(n);
        p(0) = 1, p(1) = s, d(0) = 0, d(1) = 1;
        for (int k = 1; k + 1 < n; ++k) {
            p(k + 1) = ((2 * k + 1) * s * p(k) - k * p(k - 1)) / (k + 1);
            d(k + 1) = d(k - 1) + (2 * k + 1) * p(k);
        }
        d *= 2;  // per length
        ::Eigen::VectorXd slope(2 * n), curve(2 * n), place(2 * n), turn(2 * n);
        slope << d, -p;
        curve << ::Eigen::VectorXd::Zero(n), d;
        place << p, ::Eigen::VectorXd::Zero(n);
        turn << ::Eigen::VectorXd::Zero(n), p;
        K += weight * (shear * slope * slope.transpose() + stiff * curve * curve.transpose());
        M += weight * (mass * place * place.transpose() + inertia * turn * turn.transpose());
    }
    const ::Eigen::GeneralizedSelfAdjointEigenSolver<::Eigen::MatrixXd> e(K, M);
    return 2 * pi / std::sqrt(e.eigenvalues()(2));  // the first two are rigid motions
}

// First bending mode of a free beam [Rayleigh].
double bent(double x)
{
    constexpr double b = 4.730040744862704;
    const double k = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
    return (std::cosh(b * x) + std::cos(b * x) - k * (std::sinh(b * x) + std::sin(b * x))) / 2;
}

// Error of a beam's first period [%].
double beam_off(Verification& v, int thick, double poisson)
{
    const double expected = bending_period(1.0 / 8, poisson);
    const Setup s = free_bar(8 * thick, thick, poisson);
    return 100 * (rung(v, s, expected,
                       [](Place r) {
                           return Place{0, bent(r.x / bar), 0};
                       }).period /
                      expected -
                  1);
}

void bending(Verification& v)
{
    const std::string advice = "thin parts bend too easily or too hard: refine";
    const double rough = beam_off(v, 4, 0);
    v.add(
        near("free beam 4 cells thick: bending period, off Timoshenko", rough, 0, 5, "%", advice));
    if (v.quick()) return;
    const double fine = beam_off(v, 8, 0);
    v.add(at_most("free beam: error at 8 cells over that at 4", std::fabs(fine / rough), 0.5, "",
                  "refining thin parts does not help"));
    for (const double poisson : {0.3, 0.45, 0.49})
        v.add(near(fmt::format("free beam 4 cells thick, nu = {}: bending period", poisson),
                   beam_off(v, 4, poisson), 0, 5, "%", "keep Poisson's ratio at 0.45 or below"));
}

// Patch test of uniform strain: the transfers reproduce its velocity field, and its stress gives no
// internal force.
void patch(Verification& v)
{
    const double h = 0.01;
    Setup s = between_walls({18, 18, 18}, h, ContactMode::separate, 0);
    const Place low = s.walls.min + Place{4 * h, 4 * h, 4 * h}, size{10 * h, 10 * h, 10 * h};
    fill(s, elastic(young, 0.3, density), low, low + size, 2);
    const Mat3<double> L{{0.3, -0.1, 0.2}, {0.15, -0.2, 0.1}, {-0.25, 0.05, 0.1}};
    for (Particle<double>& q : s.particles) q.v = L * (q.x - low), q.C = L;
    s.step.fixed = 1e-5;
    const auto inner = [&](Place x) {
        const Place a = x - low;
        const auto within = [&](double at) { return at > 3 * h && at < 7 * h; };
        return within(a.x) && within(a.y) && within(a.z);
    };
    const auto moving = v.reference(s);
    moving->advance({}, 1e-5);
    double worst = 0;
    const std::vector<Particle<double>> now = moving->particles();
    for (std::size_t i = 0; i < now.size(); ++i) {
        if (!inner(s.particles[i].x)) continue;
        const Mat3<double> off = now[i].C - L;
        worst =
            std::fmax(worst, std::sqrt(dot(off.a, off.a) + dot(off.b, off.b) + dot(off.c, off.c)));
    }
    v.add(at_most("patch test: gradient of an affine field, error", worst, 1e-11, "1/s"));
    for (Particle<double>& q : s.particles)
        q.v = {}, q.C = {}, q.e = {0.02, -0.01, 0.01, 0.005, 0.01, -0.005};
    const auto strained = v.reference(s);
    strained->advance({}, 1e-5);
    worst = 0;
    for (const Particle<double>& q : strained->particles())
        if (inner(q.x)) worst = std::fmax(worst, length(q.v) / 1e-5);
    // At a free face the same stress accelerates by about E e / (rho dx) = 2e3.
    v.add(at_most("patch test: acceleration inside uniform stress", worst, 1e-7, "m/s^2",
                  "uniform stress pushes clay that it should not"));
}

}  // namespace

void waves_part(Verification& v) { longitudinal(v), bending(v); }
void patch_part(Verification& v) { patch(v); }

}  // namespace knead
