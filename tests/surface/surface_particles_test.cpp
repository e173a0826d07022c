// The surface of particles as a whole: closed, of the right volume, and the same bits from any
// number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "cuda/math/box.h"
#include "host/base/parallel.h"
#include "host/surface/surface.h"
#include "tests/solver/samples.h"
#include "tests/surface/closed_mesh.h"
#include "tests/surface/surface_clay.h"

namespace knead {
namespace {

// The paper's ball: diameter 1/2 m, 8 particles in each cell of 1/64 m, density on 128^3.
TEST(SurfaceOfParticles, PaperBallHasOnePieceNoPockAndItsVolumeWithinOnePercent)
{
    const double h = 1.0 / 128;
    const auto jittered = filled(h, 5, 0, ball({0.503, 0.497, 0.511}, 0.25));
    auto strewn = jittered;  // the worst case: every particle anywhere
    Draw draw(6);
    for (Particle<double>& q : strewn) do
            q.x = Vec3<double>{0.503, 0.497, 0.511} + draw.vector(0.25);
        while (!ball({0.503, 0.497, 0.511}, 0.25)(q.x));
    for (const auto& particles : {jittered, strewn}) {
        const auto meshes = surface(particles, {clay(h)}, rule_of(128));
        ASSERT_EQ(meshes.size(), 1u);
        EXPECT_EQ(fault(meshes[0]), "");
        EXPECT_EQ(components(meshes[0]), 1);
        EXPECT_EQ(euler(meshes[0]), 2);
        EXPECT_NEAR(volume(meshes[0]) / (double(particles.size()) * h * h * h), 1, 0.01);
    }
}

TEST(SurfaceOfParticles, NodesStandAtTheirIndexTimesSpacing)
{
    const double h = 1.0 / 64;
    std::vector<Particle<double>> particles;  // centred cubes: the density is symmetric about 1/2
    for (int i = 0; i < 64 * 64 * 64; ++i) {
        Particle<double> q{};
        q.x = h * Vec3<double>{i % 64 + 0.5, i / 64 % 64 + 0.5, i / 4096 + 0.5};
        if (ball({0.5, 0.5, 0.5}, 0.3)(q.x)) particles.push_back(q);
    }
    for (const int nodes : {40, 64, 96}) {
        const auto meshes = surface(particles, {clay(h)}, rule_of(nodes));
        ASSERT_EQ(meshes.size(), 1u);
        Box3<double> box = empty_box<double>();
        for (const Vec3<float> v : meshes[0].vertices) grow(box, cast<double>(v));
        EXPECT_LT(length(centre(box) - Vec3<double>{0.5, 0.5, 0.5}), 0.02 / nodes);
    }
}

TEST(SurfaceOfParticles, RandomCloudsOnLatticesCoarseAndFineAreClosedManifolds)
{
    Draw draw(12);
    std::size_t triangles = 0;
    for (int round = 0; round < 20; ++round) {
        std::vector<Particle<double>> particles(std::size_t(1 + draw.below(3000)));
        for (Particle<double>& q : particles)
            q.x = {draw.in(0.1, 0.9), draw.in(0.3, 0.9), draw.in(0.3, 0.6)};
        const double h = draw.in(0.02, 0.08);
        for (const Smoothing smoothing : {Smoothing::none, Smoothing::laplace, Smoothing::taubin})
            for (const Mesh& m :
                 surface(particles, {clay(h)}, rule_of(8 + 4 * draw.below(10), smoothing))) {
                EXPECT_EQ(fault(m), "");
                triangles += m.triangles.size();
            }
    }
    EXPECT_GT(triangles, 10000u);
}

TEST(SurfaceOfParticles, SurfaceIsClosedAtTheBorderOfTheLatticeToo)
{
    const double h = 1.0 / 32;
    const auto particles = filled(h, 8, 0, [](Vec3<double>) { return true; });  // the whole lattice
    SurfaceStats stats;
    const auto meshes = surface(particles, {clay(h)}, rule_of(32), &stats);
    ASSERT_EQ(meshes.size(), 1u);
    EXPECT_EQ(fault(meshes[0]), "");
    EXPECT_EQ(euler(meshes[0]), 2);
    EXPECT_GT(stats.outside, 0);
    for (const Vec3<float> v : meshes[0].vertices) {
        EXPECT_GE(std::min({v.x, v.y, v.z}), -1.0f / 32);
        EXPECT_LE(std::max({v.x, v.y, v.z}), 1.0f);
    }
}

TEST(SurfaceOfParticles, EachCategoryHasASurfaceOfItsOwn)
{
    const double h = 1.0 / 64;
    const Vec3<double> left{0.4, 0.5, 0.5}, right{0.6, 0.5, 0.5};
    auto particles = filled(h, 1, 0, ball(left, 0.2));  // they overlap
    const std::size_t first = particles.size();
    for (const int object : {1, 2}) {
        const auto more = filled(h, 2, object, ball(right, object == 1 ? 0.2 : 0.01));
        particles.insert(particles.end(), more.begin(), more.end());
    }
    const std::vector<Material<double>> materials{clay(h, 5), clay(h, -3), clay(h, 9)};
    const auto meshes = surface(particles, materials, rule_of(64));
    ASSERT_EQ(meshes.size(), 2u);  // the crumb of category 9 is too small to have a surface
    EXPECT_EQ(meshes[0].category, -3);
    EXPECT_EQ(meshes[1].category, 5);
    particles.resize(first);
    const auto alone = surface(particles, materials, rule_of(64));
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_EQ(volume(alone[0]), volume(meshes[1]));
}

TEST(SurfaceOfParticles, SameBitsFromOneTwoAndThreeThreads)
{
    const double h = 1.0 / 64;
    auto particles = filled(h, 3, 0, ball({0.5, 0.5, 0.5}, 0.3));
    const auto more = filled(h, 4, 1, ball({0.7, 0.5, 0.5}, 0.25));
    particles.insert(particles.end(), more.begin(), more.end());
    const int before = loop_threads();
    std::vector<std::vector<Mesh>> runs;
    for (const int threads : {1, 2, 3}) {
        set_loop_threads(threads);
        runs.push_back(surface(particles, {clay(h), clay(h, 1)}, rule_of(64)));
    }
    set_loop_threads(before);
    const auto same = [](const auto& a, const auto& b) {
        return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
    };
    for (const auto& run : runs) {
        ASSERT_EQ(run.size(), 2u);
        for (std::size_t k = 0; k < 2; ++k) {
            EXPECT_TRUE(same(run[k].vertices, runs[0][k].vertices));
            EXPECT_TRUE(same(run[k].normals, runs[0][k].normals));
            EXPECT_TRUE(same(run[k].triangles, runs[0][k].triangles));
        }
    }
}

TEST(SurfaceOfParticles, ParticlesOfNoUseAreLeftOutAndCounted)
{
    const Mixed given = mixed(1.0 / 32);
    SurfaceStats stats;
    const auto meshes = surface(given.all, given.materials, rule_of(32), &stats);
    EXPECT_EQ(stats.unusable, 7);
    EXPECT_EQ(stats.outside, 2);
    ASSERT_EQ(meshes.size(), 1u);
    EXPECT_EQ(volume(meshes[0]), volume(surface(given.good, given.materials, rule_of(32)).at(0)));
}

TEST(SurfaceOfParticles, NoParticlesMakeNoMesh)
{
    EXPECT_TRUE(surface({}, {}, rule_of(32)).empty());
    EXPECT_TRUE(surface({Particle<double>{}}, {clay(0.01)}, rule_of(32)).empty());
    EXPECT_EQ(volume(Mesh{}), 0);
    EXPECT_EQ(components(Mesh{}), 0);
}

TEST(SurfaceOfParticles, RuleWithoutMeaningIsRefused)
{
    const auto refused = [](auto change) {
        SurfaceOptions options = rule_of(32);
        change(options);
        EXPECT_THROW(surface({}, {}, options), std::invalid_argument);
    };
    refused([](SurfaceOptions& r) { r.iso = 0; });
    refused([](SurfaceOptions& r) { r.iso = NAN; });
    refused([](SurfaceOptions& r) { r.iterations = -1; });
    refused([](SurfaceOptions& r) { r.lattice.dx = 0; });
    refused([](SurfaceOptions& r) { r.lattice.dx = INFINITY; });
    refused([](SurfaceOptions& r) { r.lattice.size.y = 2; });
    refused([](SurfaceOptions& r) { r.lattice.size.z = 1 << 30; });
}

TEST(SurfaceOfParticles, LatticeTooLargeForMemoryIsRefusedBeforeItIsMade)
{
    SurfaceOptions options = rule_of(32);
    options.lattice = {{1 << 20, 1 << 20, 1 << 20}, 1e-6f};
    std::vector<Particle<double>> particles(2);
    particles[0].x = {0.1, 0.1, 0.1};
    particles[1].x = {0.9, 0.9, 0.9};
    EXPECT_THROW(surface(particles, {clay(1e-6)}, options), std::runtime_error);
}

}  // namespace
}  // namespace knead
