// What a state of the clay is said to hold.
#include "host/solver/audit.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace knead
