// The device's surface against the CPU's: the same density within rounding, from the same density
// the same mesh but for the order of its parts, and the same bits in every run.
#include "host/surface/gpu_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "host/solver/editable_simulator.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/samples.h"
#include "tests/surface/closed_mesh.h"
#include "tests/surface/mesh_keys.h"
#include "tests/surface/surface_clay.h"

namespace knead {
namespace {

using Particles = std::vector<Particle<double>>;

class GpuSurfaces : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

// Scenes of many kinds: lattices coarser and finer than the particles, and clay at the border.
struct Scene {
    Particles particles;
    double h;
    int nodes;
};
std::vector<Scene> scenes()
{
    const auto everywhere = [](Vec3<double>) { return true; };
    const auto two = [](Vec3<double> x) {
        return length(x - Vec3<double>{0.3, 0.5, 0.5}) < 0.18 ||
               length(x - Vec3<double>{0.7, 0.55, 0.5}) < 0.22;
    };
    return {{filled(1.0 / 64, 5, 0, ball({0.503, 0.497, 0.511}, 0.25)), 1.0 / 64, 64},
            {filled(1.0 / 64, 6, 0, two), 1.0 / 64, 31},
            {filled(1.0 / 32, 7, 0, two), 1.0 / 32, 90},
            {filled(1.0 / 32, 8, 0, everywhere), 1.0 / 32, 33},
            {filled(1.0 / 12, 9, 0, two), 1.0 / 12, 50}};
}

TEST_F(GpuSurfaces, DensityIsTheCpusWithinRounding)
{
    for (const Scene& s : scenes()) {
        const SurfaceOptions options = rule_of(s.nodes, Smoothing::none);
        std::vector<Deposit> deposits;
        const float dx = options.lattice.dx, volume = float(clay(s.h).mass / clay(s.h).density);
        SurfaceStats stats;
        GpuSurface device(s.particles, {clay(s.h)}, options);
        device.surface(s.particles, &stats);
        for (const Particle<double>& q : s.particles) {
            const Vec3<float> x = cast<float>(q.x);
            const auto in = [&](float t) {
                return t / dx >= 0.5f && t / dx < float(s.nodes) - 1.5f;
            };
            if (in(x.x) && in(x.y) && in(x.z)) deposits.push_back({x, volume});
        }
        EXPECT_EQ(std::size_t(stats.outside), s.particles.size() - deposits.size());
        const Field f = density(deposits, options.lattice), g = device.density(0);
        std::size_t full = 0;
        double sum = 0, sum_g = 0, worst = 0;
        for (int z = 0; z < g.size.z; ++z)
            for (int y = 0; y < g.size.y; ++y)
                for (int x = 0; x < g.size.x; ++x) {
                    const Int3 n = g.low + Int3{x, y, z} - f.low;
                    const bool has = n.x >= 0 && n.y >= 0 && n.z >= 0 && n.x < f.size.x &&
                                     n.y < f.size.y && n.z < f.size.z;
                    const double a =
                        has ? double(f.value[std::size_t((n.z * f.size.y + n.y) * f.size.x + n.x)])
                            : 0;
                    const double b =
                        double(g.value[std::size_t((z * g.size.y + y) * g.size.x + x)]);
                    worst = std::max(worst, std::fabs(a - b) / std::max(a, 0.05));
                    full += a > 0.5;
                    sum += a, sum_g += b;
                }
        EXPECT_LT(worst, 1e-5) << s.nodes;
        EXPECT_NEAR(sum_g / sum, 1, 1e-6);
        EXPECT_GT(full, 500u);
    }
}

TEST_F(GpuSurfaces, SameDensityMakesTheSameMeshButForTheOrder)
{
    for (const Scene& s : scenes()) {
        GpuSurface device(s.particles, {clay(s.h)}, rule_of(s.nodes, Smoothing::none));
        const std::vector<Mesh> meshes = device.surface(s.particles);
        ASSERT_EQ(meshes.size(), 1u);
        const Field f = device.density(0);
        const Mesh cpu = isosurface(f, 0.5f);
        EXPECT_EQ(fault(meshes[0]), "");
        EXPECT_EQ(meshes[0].triangles.size(), cpu.triangles.size());
        const std::vector<std::size_t> match = matched(cpu, meshes[0], f.dx);
        double farthest = 0;
        for (std::size_t v = 0; v < match.size(); ++v)
            farthest = std::max(
                farthest, double(length(cpu.vertices[v] - meshes[0].vertices[match[v]])) / f.dx);
        EXPECT_LT(farthest, 2e-5) << s.nodes;  // of a float at 90 spacings: 1e-5
        EXPECT_NEAR(volume(meshes[0]) / volume(cpu), 1, 1e-6);
    }
}

TEST_F(GpuSurfaces, SmoothingAndNormalsAreTheCpus)
{
    for (const Smoothing smoothing : {Smoothing::none, Smoothing::laplace, Smoothing::taubin})
        for (const Scene& s : scenes()) {
            GpuSurface raw(s.particles, {clay(s.h)}, rule_of(s.nodes, Smoothing::none));
            GpuSurface device(s.particles, {clay(s.h)}, rule_of(s.nodes, smoothing));
            const Mesh before = raw.surface(s.particles).at(0);
            const Mesh after = device.surface(s.particles).at(0);
            const Field f = device.density(0);
            Mesh cpu = isosurface(f, 0.5f);
            const std::vector<std::size_t> match = matched(cpu, before, f.dx);
            smooth(cpu, smoothing, 5);
            double farthest = 0, turned = 0;
            for (std::size_t v = 0; v < match.size(); ++v) {
                farthest = std::max(
                    farthest, double(length(cpu.vertices[v] - after.vertices[match[v]])) / f.dx);
                turned = std::max(turned, double(length(cpu.normals[v] - after.normals[match[v]])));
                EXPECT_NEAR(length(after.normals[match[v]]), 1, 1e-5);
            }
            EXPECT_LT(farthest, 1e-4) << s.nodes;
            EXPECT_LT(turned, 2e-3) << s.nodes;
            EXPECT_NEAR(volume(after) / volume(cpu), 1, 1e-5);
            EXPECT_EQ(fault(after), "");
        }
}

TEST_F(GpuSurfaces, RandomCloudsOnLatticesCoarseAndFineAreClosedManifolds)
{
    Draw draw(12);
    std::size_t triangles = 0;
    for (int round = 0; round < 20; ++round) {
        Particles particles(std::size_t(1 + draw.below(3000)));
        for (Particle<double>& q : particles)
            q.x = {draw.in(0.1, 0.9), draw.in(0.3, 0.9), draw.in(0.3, 0.6)};
        const double h = draw.in(0.02, 0.08);
        const SurfaceOptions options = rule_of(8 + draw.below(40), Smoothing::none);
        GpuSurface device(particles, {clay(h)}, options);
        for (const Mesh& m : device.surface(particles)) {
            EXPECT_EQ(fault(m), "");
            matched(isosurface(device.density(0), 0.5f), m, options.lattice.dx);
            triangles += m.triangles.size();
        }
    }
    EXPECT_GT(triangles, 10000u);
}

TEST_F(GpuSurfaces, EachCategoryHasASurfaceOfItsOwn)
{
    const double h = 1.0 / 64;
    const Vec3<double> left{0.4, 0.5, 0.5}, right{0.6, 0.5, 0.5};
    Particles particles = filled(h, 1, 0, ball(left, 0.2));  // they overlap
    const Particles first = particles;
    for (const int object : {1, 2}) {
        const auto more = filled(h, 2, object, ball(right, object == 1 ? 0.2 : 0.01));
        particles.insert(particles.end(), more.begin(), more.end());
    }
    const std::vector<Material<double>> materials{clay(h, 5), clay(h, -3), clay(h, 9)};
    GpuSurface device(particles, materials, rule_of(64));
    const auto meshes = device.surface(particles), cpu = surface(particles, materials, rule_of(64));
    ASSERT_EQ(meshes.size(), 2u);  // the crumb of category 9 is too small to have a surface
    ASSERT_EQ(cpu.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(meshes[k].category, cpu[k].category);
        EXPECT_EQ(fault(meshes[k]), "");
        EXPECT_NEAR(volume(meshes[k]) / volume(cpu[k]), 1, 1e-5);
    }
    Particles mixed = particles;  // no block of threads sees one category alone
    std::shuffle(mixed.begin(), mixed.end(), std::mt19937(3));
    EXPECT_TRUE(same_bits(device.surface(mixed), meshes));
    const auto alone = GpuSurface(first, materials, rule_of(64)).surface(first);
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_TRUE(same_bits(alone[0].vertices, meshes[1].vertices));
}

TEST_F(GpuSurfaces, SameBitsInAnyOrderOfTheParticles)
{
    const double h = 1.0 / 64;
    Particles particles = filled(h, 3, 0, ball({0.5, 0.5, 0.5}, 0.3));
    GpuSurface device(particles, {clay(h)}, rule_of(64));
    const auto first = device.surface(particles);
    EXPECT_FALSE(first.empty());
    std::mt19937 source(5);
    for (int round = 0; round < 3; ++round) {
        std::shuffle(particles.begin(), particles.end(), source);
        EXPECT_TRUE(same_bits(device.surface(particles), first));
    }
}

TEST_F(GpuSurfaces, NothingOfTheLastSurfaceIsLeftInTheNext)
{
    const double h = 1.0 / 48;
    const Particles left = filled(h, 3, 0, ball({0.3, 0.5, 0.5}, 0.2)),
                    right = filled(h, 4, 0, ball({0.6, 0.4, 0.5}, 0.25));
    GpuSurface used(right, {clay(h)}, rule_of(64));
    const auto first = used.surface(right);
    used.surface(left);
    EXPECT_TRUE(used.surface(Particles{}).empty());
    EXPECT_TRUE(same_bits(used.surface(right), first));
    EXPECT_TRUE(
        same_bits(GpuSurface(left, {clay(h)}, rule_of(64)).surface(left), used.surface(left)));
}

// After an edit, without taking other memory.
TEST_F(GpuSurfaces, OfOtherMaterialsIsTheSameAsANewOne)
{
    const double h = 1.0 / 48;
    Particles first = filled(h, 1, 0, ball({0.3, 0.5, 0.5}, 0.2));
    const auto other = filled(h, 2, 1, ball({0.7, 0.5, 0.5}, 0.2));
    first.insert(first.end(), other.begin(), other.end());
    Particles second = filled(h, 3, 2, ball({0.5, 0.5, 0.5}, 0.2));
    const auto more = filled(h, 4, 3, ball({0.5, 0.8, 0.5}, 0.15));
    second.insert(second.end(), more.begin(), more.end());
    GpuSurface used(first, {clay(h, 5), clay(h, -3)}, rule_of(48));
    used.surface(first);
    const std::vector<Material<double>> edited{{}, {}, clay(h, 5), clay(h, -3)};
    ASSERT_TRUE(used.set_materials(edited));
    EXPECT_TRUE(
        same_bits(used.surface(second), GpuSurface(second, edited, rule_of(48)).surface(second)));
    EXPECT_FALSE(used.set_materials({clay(h, 5), clay(h, 4)})) << "a category that is new";
    EXPECT_FALSE(used.set_materials({clay(1.1 * h, 5)})) << "larger particles";
    EXPECT_TRUE(
        same_bits(used.surface(second), GpuSurface(second, edited, rule_of(48)).surface(second)));
}

// Categories change, back and forth, in the memory of the first.
TEST_F(GpuSurfaces, OfOtherCategoriesIsTheSameAsANewOne)
{
    const double h = 1.0 / 48;
    Particles particles = filled(h, 1, 0, ball({0.35, 0.5, 0.5}, 0.2));
    const auto add = [&](double spacing, int object, Vec3<double> centre) {
        const auto more = filled(spacing, 2, object, ball(centre, 0.2));
        particles.insert(particles.end(), more.begin(), more.end());
    };
    add(h, 1, {0.65, 0.5, 0.5});
    const auto expect_same = [&](GpuSurface& used, const std::vector<Material<double>>& materials) {
        GpuSurface fresh(particles, materials, rule_of(48));
        const std::vector<Mesh> wanted = fresh.surface(particles);
        EXPECT_TRUE(same_bits(used.surface(particles), wanted));
        EXPECT_TRUE(same_bits(used.kept(particles)->meshes(), wanted));
        return wanted.size();
    };
    GpuSurface used(particles, {clay(h, 5), clay(h, -3)}, rule_of(48));
    for (const auto& [first, second] : {std::pair{5, -3}, {5, 5}, {-3, -3}, {-3, 5}, {5, -3}}) {
        const std::vector<Material<double>> materials{clay(h, first), clay(h, second)};
        ASSERT_TRUE(used.set_materials(materials));
        EXPECT_EQ(expect_same(used, materials), first == second ? 1u : 2u);
    }
    // A category that its largest particles leave is softened less.
    add(2 * h, 2, {0.5, 0.7, 0.5}), add(2 * h, 3, {0.5, 0.3, 0.5});
    const std::vector<Material<double>> coarse{clay(h, 5), clay(h, -3), clay(2 * h, 5),
                                               clay(2 * h, -3)};
    GpuSurface mixed(particles, coarse, rule_of(48));
    EXPECT_EQ(expect_same(mixed, coarse), 2u);
    std::vector<Material<double>> moved = coarse;
    moved[2].category = -3;
    EXPECT_FALSE(mixed.set_materials(moved));
    EXPECT_EQ(expect_same(mixed, coarse), 2u);
    moved[0].category = -3, moved[1].category = 5, moved[2].category = 5;
    EXPECT_TRUE(mixed.set_materials(moved)) << "both have some of the largest";
    EXPECT_EQ(expect_same(mixed, moved), 2u);
}

TEST_F(GpuSurfaces, MeasuringLeavesTheSurfaceAsItWas)
{
    const double h = 1.0 / 48;
    const Particles particles = filled(h, 3, 0, ball({0.5, 0.5, 0.5}, 0.3));
    GpuSurface device(particles, {clay(h)}, rule_of(48));
    EXPECT_TRUE(device.stage_times().empty());  // there is none yet
    const auto before = device.surface(particles);
    EXPECT_EQ(device.replays(3).size(), 3u);
    EXPECT_EQ(device.stage_times().size(), 9u);
    EXPECT_TRUE(same_bits(device.meshes(), before));
}

TEST_F(GpuSurfaces, ParticlesOfNoUseAreLeftOutAndCounted)
{
    const Mixed given = mixed(1.0 / 32);
    SurfaceStats stats;
    GpuSurface device(given.all, given.materials, rule_of(32));
    const auto meshes = device.surface(given.all, &stats);
    EXPECT_EQ(stats.unusable, 7);
    EXPECT_EQ(stats.outside, 2);
    EXPECT_TRUE(same_bits(meshes, device.surface(given.good, &stats)));
    EXPECT_EQ(stats.unusable + stats.outside, 0);
}

TEST_F(GpuSurfaces, NoParticlesMakeNoMesh)
{
    GpuSurface empty({}, {}, rule_of(32));
    EXPECT_TRUE(empty.surface(Particles{}).empty());
    SurfaceStats stats;
    EXPECT_TRUE(empty.surface({Particle<double>{}}, &stats).empty());
    EXPECT_EQ(stats.unusable, 1);
    GpuSurface crumb({Particle<double>{}}, {clay(0.01)}, rule_of(32));
    EXPECT_TRUE(crumb.surface({Particle<double>{}}, &stats).empty());
    EXPECT_EQ(stats.outside, 1);
}

TEST_F(GpuSurfaces, SurfaceThatDoesNotFitIsReportedAndEmpty)
{
    const double h = 1.0 / 48;
    const Particles particles = filled(h, 3, 0, ball({0.5, 0.5, 0.5}, 0.3));
    GpuSurface roomy(particles, {clay(h)}, rule_of(48));
    const auto meshes = roomy.surface(particles);
    const std::size_t vertices = meshes.at(0).vertices.size(),
                      triangles = meshes.at(0).triangles.size();
    EXPECT_EQ(roomy.needed().vertices, vertices);
    EXPECT_EQ(roomy.needed().triangles, triangles);
    for (const SurfaceRoom room : {SurfaceRoom{vertices - 1, triangles},
                                   SurfaceRoom{vertices, triangles - 1}, SurfaceRoom{1, 1}}) {
        GpuSurface narrow(particles, {clay(h)}, rule_of(48), room);
        try {
            narrow.surface(particles);
            ADD_FAILURE() << "it fitted";
        } catch (const std::runtime_error& e) {
            const std::string said = e.what();
            EXPECT_NE(said.find(std::to_string(vertices)), std::string::npos) << said;
            EXPECT_NE(said.find(std::to_string(room.triangles)), std::string::npos) << said;
        }
        EXPECT_TRUE(narrow.meshes().empty());
    }
    GpuSurface exact(particles, {clay(h)}, rule_of(48), {vertices, triangles});
    EXPECT_TRUE(same_bits(exact.surface(particles), meshes));
}

TEST_F(GpuSurfaces, RoomGrowsWhereItWasLeftOpen)
{
    const double h = 0.5 / 64;
    Particles particles(16 * 16 * 16);  // crumbs of one particle each
    for (int i = 0; i < int(particles.size()); ++i)
        particles[std::size_t(i)].x =
            1.0 / 64 *
            Vec3<double>{2.4 + 3.8 * (i % 16), 2.4 + 3.8 * (i / 16 % 16), 2.4 + 3.8 * (i / 256)};
    SurfaceOptions options = rule_of(64, Smoothing::laplace);
    options.iso = 0.004f;
    GpuSurface device(particles, {clay(h)}, options);
    const std::size_t before = device.room().vertices;
    const auto meshes = device.surface(particles);
    ASSERT_EQ(meshes.size(), 1u);
    EXPECT_EQ(fault(meshes[0]), "");
    EXPECT_EQ(components(meshes[0]), 16 * 16 * 16);
    EXPECT_GT(meshes[0].vertices.size(), before);
    EXPECT_GT(device.room().vertices, meshes[0].vertices.size());
}

TEST_F(GpuSurfaces, ClayTooDenseToBeSummedIsRefused)
{
    Particles particles(3000);
    for (Particle<double>& q : particles) q.x = {0.5, 0.5, 0.5};
    GpuSurface device(particles, {clay(1.0 / 32)}, rule_of(32));
    EXPECT_THROW(device.surface(particles), std::runtime_error);
    particles.resize(300);
    EXPECT_EQ(fault(device.surface(particles).at(0)), "");
}

TEST_F(GpuSurfaces, RuleWithoutMeaningAndLatticeTooLargeAreRefused)
{
    SurfaceOptions options = rule_of(32);
    options.iso = 0;
    EXPECT_THROW(GpuSurface({}, {}, options), std::invalid_argument);
    options = rule_of(32);
    options.lattice.size = {1 << 20, 1 << 20, 1 << 20};
    EXPECT_THROW(GpuSurface({}, {}, options), std::runtime_error);
    EXPECT_THROW(GpuSurface({}, {}, rule_of(32), {}, 1000), std::runtime_error);
}

}  // namespace
}  // namespace knead
