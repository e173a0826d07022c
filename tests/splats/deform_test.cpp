// What a Gaussian takes from the nodes around it: exact for what they say, bounded where they say
// little.
#include "cuda/splats/deform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cuda/math/sym_eigen.h"
#include "cuda/mpm/g2p.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
using Nodes = std::array<Node<R>, 27>;
int place(Int3 step) { return 9 * step.z + 3 * step.y + step.x; }
Int3 step_of(int n) { return {n % 3, n / 3 % 3, n / 9}; }
constexpr double dx = 0.03;

// Velocities A (x - middle of the cell) + b at the nodes that hold mass [particles].
template <class R>
Nodes<R> affine(const Stencil<R>& s, const Mat3<double>& A, Vec3<double> b,
                const std::array<double, 27>& mass)
{
    Nodes<R> nodes{};
    for (int n = 0; n < 27; ++n) {
        const Int3 at = s.base + step_of(n);
        const Vec3<double> x = dx * Vec3<double>{double(at.x), double(at.y), double(at.z)};
        if (mass[std::size_t(n)] > 0)
            nodes[std::size_t(n)] = {cast<R>(A * x + b), R(mass[std::size_t(n)])};
    }
    return nodes;
}

template <class R>
LinearField<R> fitted(const Nodes<R>& nodes, const Stencil<R>& s, bool& held)
{
    return fitted_field(
        node_sums(s, [&](Int3 step) { return node_share(nodes[std::size_t(place(step))], R(1)); }),
        s, R(dx), held);
}

// The smallest eigenvalue of the nodes' second moments about their mean, in squared steps.
template <class R>
double smallest_moment(const Stencil<R>& s, const std::array<double, 27>& mass)
{
    double sum = 0;
    Vec3<double> mean{};
    Mat3<double> second{};
    for (int n = 0; n < 27; ++n) {
        const Int3 k = step_of(n);
        const double w = double(s.w[k.x].x) * double(s.w[k.y].y) * double(s.w[k.z].z) *
                         std::fmin(mass[std::size_t(n)], 1);
        const Vec3<double> r{double(k.x), double(k.y), double(k.z)};
        sum += w, mean = mean + w * r, second = second + outer(w * r, r);
    }
    if (sum == 0) return 0;
    mean = (1 / sum) * mean;
    const Vec3<double> v = eigen(symmetric((1 / sum) * second - outer(mean, mean))).value;
    return std::fmin(v.x, std::fmin(v.y, v.z));
}

Vec3<double> somewhere(Draw& draw) { return Vec3<double>{0.3, 0.3, 0.3} + draw.vector(2 * dx); }

// In float a velocity of 1 m/s is rounded by 6e-8: over dx and the least moment that a gradient is
// divided by, 1/256, 5e-4 1/s.
template <class R>
class Deform : public testing::Test {
};
TYPED_TEST_SUITE(Deform, Scalars);

TYPED_TEST(Deform, AnAffineFieldComesBackFromAnyNodesThatSpanSpace)
{
    using R = TypeParam;
    Draw draw(1);
    int spanning = 0;
    for (int i = 0; i < 4000; ++i) {
        const Vec3<R> x = cast<R>(somewhere(draw));
        const Stencil<R> s = stencil(x, R(dx));
        std::array<double, 27> mass{};
        const int nodes = 4 + draw.below(24);
        for (int n = 0; n < nodes; ++n) mass[std::size_t(draw.below(27))] = draw.power(-2, 1);
        if (smallest_moment(s, mass) < 3.0 / 256) continue;
        ++spanning;
        const Mat3<double> A = draw.matrix();
        const Vec3<double> b = draw.vector(0.1);
        bool held;
        const LinearField<R> f = fitted(affine(s, A, b, mass), s, held);
        ASSERT_TRUE(held);
        EXPECT_LT(size(cast<double>(f.C) - A), either<R>(2e-3, 1e-11));
        EXPECT_LT(length(cast<double>(f.v) - (A * cast<double>(x) + b)), either<R>(2e-5, 1e-13));
    }
    EXPECT_GT(spanning, 1000);
}

TYPED_TEST(Deform, ARotationComesBackFromNodesOfOnePlane)
{
    using R = TypeParam;
    Draw draw(2);
    for (int i = 0; i < 300; ++i) {
        const Vec3<R> x = cast<R>(somewhere(draw));
        const Stencil<R> s = stencil(x, R(dx));
        std::array<double, 27> mass{};
        const int axis = draw.below(3), layer = draw.below(3);
        for (int n = 0; n < 27; ++n) {
            const Int3 k = step_of(n);
            if ((axis == 0 ? k.x : axis == 1 ? k.y : k.z) == layer) mass[std::size_t(n)] = 8;
        }
        const Vec3<double> w = draw.vector();
        const Mat3<double> W = {{0, w.z, -w.y}, {-w.z, 0, w.x}, {w.y, -w.x, 0}};
        bool held;
        const LinearField<R> f = fitted(affine(s, W, {0, 0, 0}, mass), s, held);
        EXPECT_TRUE(held || s.w[layer].x * s.w[layer].y * s.w[layer].z < 1e-9);
        if (!held) continue;
        EXPECT_LT(size(cast<double>(f.C) - W), either<R>(2e-3, 1e-11));
        EXPECT_LT(length(cast<double>(f.v) - cross(w, cast<double>(x))), either<R>(6e-5, 1e-13));
    }
}

// Of what spread of velocities however few nodes there are, and however little they hold.
TYPED_TEST(Deform, AGradientIsNeverMoreThanAFewTimesTheNodesDifferBy)
{
    using R = TypeParam;
    Draw draw(3);
    double most = 0, farthest = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3<R> x = cast<R>(somewhere(draw));
        const Stencil<R> s = stencil(x, R(dx));
        Nodes<R> nodes{};
        const int count = 1 + draw.below(27);
        for (int n = 0; n < count; ++n)
            nodes[std::size_t(draw.below(27))] = {cast<R>(draw.direction()), R(draw.power(-7, 1))};
        bool held;
        const LinearField<R> f = fitted(nodes, s, held);
        if (!held) continue;
        most = std::fmax(most, dx * double(size(f.C)));
        farthest = std::fmax(farthest, double(length(f.v)));
        ASSERT_TRUE(std::isfinite(most) && std::isfinite(farthest)) << i;
    }
    EXPECT_LT(most, 8);
    EXPECT_LT(farthest, 12);
    EXPECT_GT(most, 1);
}

TYPED_TEST(Deform, OneNodeCarriesWithoutStrainAndNoneNotAtAll)
{
    using R = TypeParam;
    Draw draw(4);
    for (int n = 0; n < 27; ++n) {
        Nodes<R> nodes{};
        const Vec3<R> v = cast<R>(draw.vector());
        Gaussian<R> g = gaussian_at(cast<R>(somewhere(draw)), 0);
        const Vec3<R> from = g.x;
        const auto node = [&](Int3 step) {
            return node_share(nodes[std::size_t(place(step))], R(1));
        };
        EXPECT_FALSE(deform(g, R(dx), R(0.001), 1, node));
        EXPECT_EQ(length(g.x - from), 0);
        EXPECT_EQ(determinant(g.F), 1);
        nodes[std::size_t(n)] = {v, R(0.5)};
        EXPECT_TRUE(deform(g, R(dx), R(0.001), 1, node));
        EXPECT_LT(length(g.x - (from + R(0.001) * v)), either<R>(3e-7, 1e-15));
        EXPECT_LT(size(g.F - diagonal(R(1))), either<R>(1e-5, 1e-13));
    }
}

TYPED_TEST(Deform, AmongNodesThatAllHoldClayItIsTheGatherOfParticles)
{
    using R = TypeParam;
    Draw draw(5);
    for (int i = 0; i < 200; ++i) {
        Nodes<R> nodes;
        for (Node<R>& n : nodes) n = {cast<R>(draw.vector()), R(draw.in(1, 20))};
        Particle<R> q{};
        q.x = cast<R>(somewhere(draw));
        const Stencil<R> s = stencil(q.x, R(dx));
        bool held;
        const LinearField<R> f = fitted(nodes, s, held);
        gather(q, s, R(dx), [&](Int3 step) { return nodes[std::size_t(place(step))].p; });
        EXPECT_LT(length(f.v - q.v), either<R>(3e-6, 1e-14));
        EXPECT_LT(R(dx) * size(f.C - q.C), either<R>(3e-6, 1e-14));
    }
}

TYPED_TEST(Deform, ANodeThatHoldsNextToNothingHasNextToNoSay)
{
    using R = TypeParam;
    Draw draw(6);
    for (int i = 0; i < 200; ++i) {
        std::array<double, 27> mass;
        mass.fill(4);
        const Vec3<R> x = cast<R>(somewhere(draw));
        const Stencil<R> s = stencil(x, R(dx));
        for (int n = 0; n < 9; ++n) mass[std::size_t(n)] = 0;  // an open surface
        Nodes<R> nodes = affine(s, draw.matrix(), {0, 0, 0}, mass), others = nodes;
        others[std::size_t(draw.below(9))] = {cast<R>(draw.direction()), R(1e-6)};
        bool held;
        const LinearField<R> a = fitted(nodes, s, held), b = fitted(others, s, held);
        EXPECT_LT(length(a.v - b.v), 2e-4);
        EXPECT_LT(dx * double(size(a.C - b.C)), 2e-4);
    }
}

// The gradient of x + dt v is I + dt C: F is exact for how the lattice carries places, whatever
// the substep, and however many are made up for at once. A field v = w x r is no rotation of
// places: it drives them apart by sqrt(1 + (w dt)^2) a substep, and F with them.
TEST(Deform, FIsTheGradientOfHowPlacesAreCarried)
{
    const Vec3<double> c{0.3, 0.3, 0.3};
    const double angle = 0.01, dt = 2e-4;
    const Mat3<double> turn = rotation(turn_about(Vec3<double>{0, 0, 1}, angle));
    const Mat3<double> rigid = (1 / dt) * (turn - diagonal(1.0)),
                       spin = (angle / dt) * Mat3<double>{{0, 1, 0}, {-1, 0, 0}, {0, 0, 0}};
    const int steps = 960;
    for (int k = 0; k < 8; ++k) {
        const bool exact = k % 2 == 0;
        const int at_once = 1 + k / 2;
        int open = 0;
        const Mat3<double>& A = exact ? rigid : spin;
        Gaussian<double> g = gaussian_at(c + Vec3<double>{0.02, 0.01, 0}, 0);
        for (int n = 0; n < steps; n += at_once) {
            const Stencil<double> s = stencil(g.x, dx);
            std::array<double, 27> mass{};
            for (int m = 0; m < 27; ++m) {  // a surface 0.6 cells beyond it, that turns with it
                const Int3 at = s.base + step_of(m);
                const Vec3<double> r = dx * Vec3<double>{double(at.x), double(at.y), 0} - c;
                mass[std::size_t(m)] = r.x * (g.x.x - c.x) + r.y * (g.x.y - c.y) <
                                               length(g.x - c) * (length(g.x - c) + 0.6 * dx)
                                           ? 8
                                           : 0;
                open += mass[std::size_t(m)] == 0;
            }
            const Nodes<double> nodes = affine(s, A, -(A * c), mass);
            ASSERT_TRUE(deform(g, dx, dt, at_once, [&](Int3 step) {
                return node_share(nodes[std::size_t(place(step))], 1.0);
            }));
        }
        const double grown = exact ? 1 : std::pow(1 + angle * angle, steps / 2.0);
        EXPECT_GT(open, 3 * steps / at_once);
        EXPECT_NEAR(determinant(g.F), grown * grown, 1e-9);
        EXPECT_NEAR(length(g.x - c), grown * std::hypot(0.02, 0.01), 1e-11);
        if (!exact) continue;
        EXPECT_LT(size(g.F - rotation(turn_about(Vec3<double>{0, 0, 1}, angle * steps))), 1e-9);
    }
}

TYPED_TEST(Deform, NoSubstepTurnsANeighbourhoodInsideOut)
{
    using R = TypeParam;
    Draw draw(7);
    for (int i = 0; i < 1000; ++i) {
        Gaussian<R> g = gaussian_at(cast<R>(somewhere(draw)), 0);
        const double largest = draw.power(-1, 4);
        for (int n = 0; n < 3; ++n) carry(g, {{}, cast<R>(draw.matrix(largest))}, R(1), 1 + n);
        EXPECT_GT(determinant(g.F), 0);
    }
}

TYPED_TEST(Deform, WhatIsNoNumberGoesBackToWhereItWas)
{
    using R = TypeParam;
    const R none = std::numeric_limits<R>::quiet_NaN(), inf = std::numeric_limits<R>::infinity();
    const Gaussian<R> start = gaussian_at(Vec3<R>{R(0.3), R(0.4), R(0.5)}, 3);
    for (const R wrong : {none, inf, -inf}) {
        Gaussian<R> g = start;
        g.x.y = wrong;
        EXPECT_TRUE(repair(g, start));
        EXPECT_EQ(g.x.y, R(0.4));
        g.F.b.z = wrong;
        EXPECT_TRUE(repair(g, start));
        EXPECT_EQ(g.F.b.z, 0);
        EXPECT_EQ(g.object, 3);
    }
    Gaussian<R> g = start;
    EXPECT_FALSE(repair(g, start));
}

TYPED_TEST(Deform, ARigidMotionTurnsFFromTheLeft)
{
    using R = TypeParam;
    Draw draw(8);
    const Mat3<double> F = draw.matrix(), Q = draw.rotation();
    const Vec3<double> x = draw.vector(), p = draw.vector();
    Gaussian<R> g{cast<R>(x), cast<R>(F), 0, uncut};
    move(g, RigidMotion<R>{cast<R>(quaternion(Q)), cast<R>(p)});
    EXPECT_LT(length(cast<double>(g.x) - (Q * x + p)), either<R>(1e-6, 1e-14));
    EXPECT_LT(size(cast<double>(g.F) - Q * F), either<R>(1e-6, 1e-14));
}

}  // namespace
}  // namespace knead
