// How far a surface has come on since the one before.
#include "cuda/surface/advance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/solver/editable_simulator.h"
#include "host/surface/gpu_surface.h"
#include "host/surface/surface.h"
#include "tests/solver/samples.h"
#include "tests/surface/surface_clay.h"

namespace knead {
namespace {

TEST(Advance, OfARampIsWhatItHasMoved)
{
    const Vec3<double> n{0.6, 0, -0.8};
    for (const double slope : {0.1, 0.5})
        for (const double way : {-0.7, 0.0, 0.3}) {
            const auto ramp = [&](double moved) {
                return [=](Int3 k) { return 0.5 - slope * (k.x * n.x + k.z * n.z - moved); };
            };
            const Vec3<double> x{0.33, 0.5, 0.12};
            EXPECT_NEAR(advance(x, 0.1, ramp(way), ramp(0)), 0.1 * way, 1e-12);
        }
}

TEST(Advance, IsANodeAtMostAndNothingWhereThereIsNoSlope)
{
    const auto ramp = [](double moved) { return [=](Int3 k) { return 0.2 * (k.x + moved); }; };
    EXPECT_NEAR(advance(Vec3<double>{}, 0.1, ramp(9), ramp(0)), 0.1, 1e-12);
    EXPECT_NEAR(advance(Vec3<double>{}, 0.1, ramp(-9), ramp(0)), -0.1, 1e-12);
    const auto flat = [](double value) { return [=](Int3) { return value; }; };
    EXPECT_EQ(advance(Vec3<double>{}, 0.1, flat(1), flat(0)), 0);
}

using Particles = std::vector<Particle<double>>;

Particles moved(Particles all, Vec3<double> way)
{
    for (Particle<double>& q : all) q.x = q.x + way;
    return all;
}

SurfaceOptions moving(int nodes)
{
    SurfaceOptions options = rule_of(nodes);
    options.moving = true;
    return options;
}

// Of all vertices from the way along their normals, root of the mean square and largest [m].
struct Off {
    double rms = 0, most = 0;
};
Off distance(const Mesh& mesh, Vec3<double> way)
{
    Off o;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const double wanted = dot(way, cast<double>(mesh.normals[v]));
        const double is = std::fabs(double(mesh.advance[v]) - wanted);
        o.rms += is * is / double(mesh.vertices.size()), o.most = std::fmax(o.most, is);
    }
    o.rms = std::sqrt(o.rms);
    return o;
}

const double h = 1.0 / 48;
const std::vector<Material<double>> materials{clay(h)};
Particles ball_of_clay() { return filled(h, 11, 0, ball({0.5, 0.5, 0.5}, 0.25)); }

// Of a ball that flies half a node: its surface has come on by as much of that as lies along it.
TEST(Advance, OfABallThatFliesIsItsWayAlongTheNormals)
{
    const Vec3<double> way{0.3 / 64, -0.4 / 64, 0};
    SurfaceHistory past;
    const Particles first = ball_of_clay();
    const std::vector<Mesh> before = surface(first, materials, moving(64), nullptr, &past);
    ASSERT_EQ(before.size(), 1u);
    for (const float a : before[0].advance) ASSERT_EQ(a, 0) << "nothing was before";
    const std::vector<Mesh> after =
        surface(moved(first, way), materials, moving(64), nullptr, &past);
    ASSERT_EQ(after[0].advance.size(), after[0].vertices.size());
    const Off o = distance(after[0], way);
    EXPECT_LT(o.rms, 0.1 * length(way));
    EXPECT_LT(o.most, 0.4 * length(way));
    const std::vector<Mesh> still =
        surface(moved(first, way), materials, moving(64), nullptr, &past);
    for (const float a : still[0].advance) ASSERT_EQ(a, 0) << "it has not moved";
    EXPECT_TRUE(surface(first, materials, rule_of(64), nullptr, &past)[0].advance.empty());
    EXPECT_TRUE(past.densities.empty());
}

TEST(Advance, IsTheSameOnADevice)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    const Vec3<double> way{0.3 / 64, -0.4 / 64, 0};
    const Particles first = ball_of_clay(), then = moved(first, way);
    GpuSurface device(first, materials, moving(64));
    const std::vector<Mesh> began = device.surface(first);
    for (const float a : began.at(0).advance) ASSERT_EQ(a, 0);
    const std::vector<Mesh> flown = device.surface(then);
    SurfaceHistory past;
    surface(first, materials, moving(64), nullptr, &past);
    const std::vector<Mesh> wanted = surface(then, materials, moving(64), nullptr, &past);
    const Off mine = distance(flown.at(0), way), theirs = distance(wanted.at(0), way);
    EXPECT_NEAR(mine.rms, theirs.rms, 1e-3 * length(way));
    EXPECT_NEAR(mine.most, theirs.most, 1e-2 * length(way));
    const auto kept = device.kept(first);
    EXPECT_LT(distance(kept->meshes().at(0), -1.0 * way).rms, 0.1 * length(way));
    EXPECT_TRUE(device.kept(first)->meshes().at(0).advance.empty()) << "all 0";
    device.reset_advance();
    EXPECT_TRUE(device.kept(then)->meshes().at(0).advance.empty());
    device.forget();
    EXPECT_TRUE(device.kept(first)->meshes().at(0).advance.empty());
    GpuSurface plain(first, materials, rule_of(64));
    plain.surface(first);
    EXPECT_TRUE(plain.surface(then)[0].advance.empty());
}

}  // namespace
}  // namespace knead
