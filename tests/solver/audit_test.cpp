// What a state of the clay is said to hold.
#include "host/solver/audit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "cuda/mpm/p2g.h"

namespace knead {
namespace {

// Clay as it is seeded fills its room once; two bodies in one place fill it twice, though the
// volume that their strain knows of is what it was. Clay that its strain says is compressed is not
// crowded.
TEST(Audit, ClayInClayIsSeenThoughItsVolumeIsAsItWas)
{
    const double dx = 0.1;
    Material<double> m{};
    m.density = 1000, m.mu = 1e5, m.lambda = 1e5;
    m.volume = dx * dx * dx / 8, m.mass = m.density * m.volume;
    const auto box = [&](double shrunk, Vec3<double> at) {
        std::vector<Particle<double>> made;
        for (int n = 0; n < 16 * 16 * 16; ++n) {
            Particle<double> q{};
            q.x = at +
                  (shrunk * dx / 2) * Vec3<double>{n % 16 + 0.5, n / 16 % 16 + 0.5, n / 256 + 0.5};
            q.e = isotropic(shrunk * shrunk - 1);
            made.push_back(q);
        }
        return made;
    };
    const auto once = box(1, {1, 1, 1});
    EXPECT_EQ(crowding(once, {m}, dx).particles, 0);
    EXPECT_NEAR(crowding(once, {m}, dx).most, 1, 0.05);
    auto twice = once;
    for (const auto& q : box(1, {1.42, 1, 1})) twice.push_back(q);  // nearly half in the other
    const Crowding found = crowding(twice, {m}, dx);
    EXPECT_GT(found.particles, 2700);  // of 3890, less those near the faces
    EXPECT_LE(found.particles, 3900);
    EXPECT_NEAR(found.most, 2, 0.1);
    EXPECT_NEAR(audit(twice, {m}, dx).volume, 2 * audit(once, {m}, dx).volume, 1e-12);
    const auto pressed = box(0.8, {1, 1, 1});
    EXPECT_EQ(crowding(pressed, {m}, dx).particles, 0);
    EXPECT_NEAR(crowding(pressed, {m}, dx).most, 1, 0.05);
    const Audit a = audit(pressed, {m}, dx);
    EXPECT_NEAR(a.volume, 0.512 * a.unloaded, 1e-9 * a.unloaded);
    auto broken = once;
    broken[7].x.x = NAN;
    EXPECT_NEAR(crowding(broken, {m}, dx).most, 1, 0.05);
    EXPECT_EQ(crowding({}, {m}, dx).particles, 0);
}

// The kinetic energy of clay is what its nodes carry: with v and C of a velocity that is affine in
// space these have it exactly.
TEST(Audit, KineticEnergyIsThatOfTheNodes)
{
    const double dx = 0.1;
    Material<double> m{};
    m.density = 1000, m.mu = 0, m.lambda = 0;
    m.volume = dx * dx * dx / 8, m.mass = m.density * m.volume;
    const Mat3<double> C{{1, -3, 2}, {5, -1, 4}, {-2, 7, 3}};  // columns
    std::vector<Particle<double>> all;
    for (int n = 0; n < 6 * 6 * 6; ++n) {
        Particle<double> q{};
        q.x = {0.5 + dx / 2 * (n % 6), 0.52 + dx / 2 * (n / 6 % 6), 0.47 + dx / 2 * (n / 36)};
        q.v = Vec3<double>{0.3, -0.2, 0.1} + C * q.x, q.C = C;
        all.push_back(q);
    }
    std::map<std::array<int, 3>, Node<double>> nodes;
    for (const Particle<double>& q : all) {
        const Stencil<double> s = stencil(q.x, Spacing<double>(dx));
        scatter(q, m, s, Spacing<double>(dx), 1e-3, [&](Int3 step, const Node<double>& share) {
            const Int3 n = s.base + step;
            Node<double>& to = nodes[{n.x, n.y, n.z}];
            to = {to.p + share.p, to.m + share.m};
        });
    }
    double carried = 0;
    for (const auto& [place, node] : nodes)
        if (node.m > 0) carried += dot(node.p, node.p) / (2 * node.m);
    const Audit a = audit(all, {m}, dx);
    EXPECT_NEAR(a.kinetic, carried, 1e-12 * carried);
    double of_means = 0;
    for (const Particle<double>& q : all) of_means += m.mass / 2 * dot(q.v, q.v);
    EXPECT_GT(a.kinetic, 1.005 * of_means);  // by how much C counts here
    // By other velocities, where these are said.
    const std::vector<Vec3<double>> still(all.size());
    const Audit b = audit(all, {m}, dx, still);
    EXPECT_NEAR(b.kinetic, a.kinetic - of_means, 1e-12 * carried);
    EXPECT_EQ(b.fastest, 0);
    EXPECT_EQ(length(b.momentum), 0);
    EXPECT_EQ(b.hash, a.hash);
}

}  // namespace
}  // namespace knead
