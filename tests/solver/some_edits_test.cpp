// Edits of several objects at once and of some Gaussians among many, and what snapshots hold, on
// both back ends.
#include <gtest/gtest.h>

#include <cmath>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/edits.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;
using Gaussians = std::vector<Gaussian<double>>;
constexpr double frame = 1.0 / 90, dx = 1.0 / 32;

class SomeEdits : public OnBothDevices {};
INSTANTIATE_TEST_SUITE_P(Solver, SomeEdits, testing::Values(false, true), device_of);

Particles block(Vec3<double> low, int edge)
{
    Particles all;
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x) {
                Particle<double> p{};
                p.x = low + dx / 2 * Vec3<double>{x + 0.5, y + 0.5, z + 0.5};
                all.push_back(p);
            }
    return all;
}

// A block of clay that turns, each particle with its Gaussian.
Given turning_block()
{
    Given s{};
    s.lattice = {{32, 32, 32}, dx};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.3);
    s.materials = {paper_clay(dx, 8)};
    s.deterministic = true, s.threads = 2;
    s.particles = block({0.4, 0.4, 0.4}, 12);
    for (Particle<double>& p : s.particles) {
        p.v = cross(Vec3<double>{0, 2, 1}, p.x - Vec3<double>{0.5, 0.5, 0.5});
        s.gaussians.push_back(gaussian_at(p.x, 0));
    }
    return s;
}

void advance(EditableSimulator& solver, int frames)
{
    for (int f = 0; f < frames; ++f) solver.advance({}, frame);
}

TEST_P(SomeEdits, SeveralObjectsComeAndGoAsOneByOne)
{
    const Given s = turning_block();
    const Material<double> m = paper_clay(dx, 8);
    const std::vector<Particles> clays{block({0.2, 0.2, 0.2}, 5), {}, block({0.7, 0.6, 0.7}, 6)};
    const auto at_once = make(s), by_one = make(s);
    advance(*at_once, 2), advance(*by_one, 2);
    const std::vector<int> objects = at_once->add_each(m, clays);
    EXPECT_EQ(objects, (std::vector<int>{1, 2, 3}));
    for (const Particles& clay : clays) by_one->add(m, clay);
    EXPECT_EQ(at_once->particle_count(), s.particles.size() + 125 + 216);
    EXPECT_TRUE(same_bits(at_once->particles(), by_one->particles()));
    advance(*at_once, 2), advance(*by_one, 2);
    EXPECT_TRUE(same_bits(at_once->particles(), by_one->particles()));
    const std::vector<int> gone{0, 3};
    at_once->remove_each(gone), by_one->remove(0), by_one->remove(3);
    EXPECT_EQ(at_once->particle_count(), 125u);
    EXPECT_TRUE(at_once->gaussians().empty());
    advance(*at_once, 2), advance(*by_one, 2);
    EXPECT_TRUE(same_bits(at_once->particles(), by_one->particles()));
}

TEST_P(SomeEdits, OfSeveralObjectsOneThatCannotBeLeavesAllAsItWas)
{
    const auto solver = make(turning_block());
    std::vector<Particles> clays{block({0.2, 0.2, 0.2}, 3), block({0.7, 0.6, 0.7}, 3)};
    clays[1][5].x.y = -1;
    const Particles before = solver->particles();
    EXPECT_THROW(solver->add_each(paper_clay(dx, 8), clays), std::invalid_argument);
    const std::vector<int> twice{0, 0}, unknown{0, 7};
    EXPECT_THROW(solver->remove_each(twice), std::invalid_argument);
    EXPECT_THROW(solver->remove_each(unknown), std::invalid_argument);
    EXPECT_TRUE(same_bits(solver->particles(), before));
    EXPECT_EQ(solver->config().materials.size(), 1u);
}

// As who would take all of them, change some and put them back; more than there was room for.
TEST_P(SomeEdits, SomeGaussiansAreSplitAndSomeAreAddedBesideParticles)
{
    const Given s = turning_block();
    const auto solver = make(s), other = make(s);
    advance(*solver, 3), advance(*other, 3);
    const WallOptions& walls = s.walls;
    for (int round = 0; round < 4; ++round) {
        GaussianEdits edits;
        for (int k = 0; k < 300; ++k)
            edits.splits.push_back({5 * k + round, {0.003, -0.001 * k, 0}});
        for (int k = 0; k < 200; ++k) edits.added.push_back({7 * k, {0, 0.002, 0.01 * round}});
        Gaussians all = other->gaussians();
        const Particles q = other->particles();
        for (const GaussianSplit& k : edits.splits) {
            Gaussian<float> g = cast<float>(all[std::size_t(k.index)]);
            const Gaussian<float> second = split(g, cast<float>(k.way), walls);
            all[std::size_t(k.index)] = cast<double>(g), all.push_back(cast<double>(second));
        }
        for (const GaussianBeside& k : edits.added)
            all.push_back(cast<double>(gaussian_beside(cast<float>(q[std::size_t(k.particle)]),
                                                       cast<float>(k.way), walls)));
        for (int k = 0; k < 100; ++k) {
            const Vec3<float> x =
                cast<float>(all[std::size_t(3 * k)].x) + Vec3<float>{0, 0.001f, 0};
            edits.placed.push_back({x, 0});
            all.push_back(gaussian_at(cast<double>(x), 0));
        }
        other->set_gaussians(all);
        solver->edit_gaussians(edits);
        ASSERT_EQ(solver->gaussians().size(), s.gaussians.size() + 600u * unsigned(round + 1));
        EXPECT_TRUE(same_bits(solver->gaussians(), all)) << round;
        advance(*solver, 2), advance(*other, 2);
        EXPECT_TRUE(same_bits(solver->gaussians(), other->gaussians())) << round;
        EXPECT_TRUE(same_bits(solver->particles(), other->particles())) << round;
    }
}

TEST_P(SomeEdits, OfGaussiansThatThereAreNotAreRefused)
{
    const Given s = turning_block();
    const auto solver = make(s);
    const auto refused = [&](const GaussianEdits& edits) {
        EXPECT_THROW(solver->edit_gaussians(edits), std::invalid_argument);
    };
    const int n = int(s.gaussians.size());
    refused({{{n, {}}}, {}});
    refused({{{-1, {}}}, {}});
    refused({{{3, {}}, {3, {}}}, {}});
    refused({{{3, {NAN, 0, 0}}}, {}});
    refused({{}, {{n, {}}}});
    refused({{}, {{0, {0, INFINITY, 0}}}});
    for (const float x : {NAN, 1e9f}) refused({{}, {}, {{{x, 0.5f, 0.5f}, 0}}});
    refused({{}, {}, {{{0.5f, 0.5f, 0.5f}, 99}}});
    EXPECT_TRUE(same_bits(solver->gaussians(), make(s)->gaussians()));
    solver->edit_gaussians({{{3, {5, 0, 0}}}, {{0, {0, -5, 0}}}});
    EXPECT_FLOAT_EQ(float(solver->gaussians()[3].x.x), float(s.walls.min.x));
    EXPECT_FLOAT_EQ(float(solver->gaussians()[std::size_t(n)].x.x), float(s.walls.max.x));
    EXPECT_FLOAT_EQ(float(solver->gaussians().back().x.y), float(s.walls.min.y));
}

// As who takes all of them and looks for those; then others go with their object, and what is left
// keeps its order.
TEST_P(SomeEdits, GaussiansOfSomeObjectsAreToldAndGoWithThem)
{
    const Given s = turning_block();
    const auto solver = make(s);
    const Particles clay = solver->particles();
    std::vector<int> objects;
    for (int k = 0; k < 3; ++k) {
        objects.push_back(solver->add(s.materials[0], {clay.begin(), clay.begin() + 40}));
        GaussianEdits edits;
        for (std::size_t i = 0; i < 500; ++i) {
            const Vec3<double> x = s.gaussians[i + 7 * std::size_t(k)].x;
            edits.placed.push_back({cast<float>(x), i % 2 ? objects.back() : objects.front()});
        }
        solver->edit_gaussians(edits);
    }
    advance(*solver, 2);
    const Gaussians all = solver->gaussians();
    const int some[] = {objects[2], objects[0], objects[2]};
    const SomeGaussians found = solver->gaussians_of(*solver->snapshot(), some);
    Gaussians wanted, kept;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const bool chosen = all[i].object == objects[0] || all[i].object == objects[2];
        (chosen ? wanted : kept).push_back(all[i]);
    }
    ASSERT_EQ(found.gaussians.size(), 1250u);
    EXPECT_TRUE(same_bits(found.gaussians, wanted));
    for (std::size_t k = 0; k < found.indices.size(); ++k)
        EXPECT_TRUE(same_bits(Gaussians{all[std::size_t(found.indices[k])]},
                              Gaussians{found.gaussians[k]}));
    EXPECT_TRUE(solver->gaussians_of(*solver->snapshot(), {}).indices.empty());
    solver->remove_each({&objects[0], 1}), solver->remove_each({&objects[2], 1});
    EXPECT_TRUE(same_bits(solver->gaussians(), kept));
    advance(*solver, 2);
    GaussianEdits more;
    const Vec3<float> x{0.5f, 0.5f, 0.5f};
    more.splits = {{1, {0.001, 0, 0}}}, more.placed = {{x, objects[1]}};
    solver->edit_gaussians(more);
    ASSERT_EQ(solver->gaussians().size(), kept.size() + 2);
    EXPECT_TRUE(same_bits(Gaussians{solver->gaussians().back()},
                          Gaussians{gaussian_at(cast<double>(x), objects[1])}));
}

TEST_P(SomeEdits, PlacesInABoxAreThoseOfItsParticles)
{
    const auto solver = make(turning_block());
    advance(*solver, 2);
    const Particles q = solver->particles();
    const Box3<double> box{{0.4, 0.4, 0.4}, {0.5, 0.5, 0.5}};
    std::vector<double> wanted, found;
    for (const Particle<double>& p : q)
        if (contains(box, p.x)) wanted.push_back(p.x.x + 10 * p.x.y + 100 * p.x.z);
    for (const Vec3<double>& x : solver->places(box)) found.push_back(x.x + 10 * x.y + 100 * x.z);
    std::sort(wanted.begin(), wanted.end()), std::sort(found.begin(), found.end());
    EXPECT_EQ(found, wanted);
    EXPECT_GT(found.size(), 1u);
    EXPECT_LT(found.size(), q.size() / 2);
}

// What has grown since goes back to what there was, and frames go on as they did.
TEST_P(SomeEdits, ASnapshotTakesThemBackAndTellsWhatItHolds)
{
    const auto solver = make(turning_block());
    advance(*solver, 2);
    const auto then = solver->snapshot();
    const Particles q = solver->particles();
    const Gaussians g = solver->gaussians();
    GaussianEdits edits;
    for (int k = 0; k < 900; ++k) edits.splits.push_back({k, {0.001, 0, 0}});
    solver->edit_gaussians(edits);
    const auto grown = solver->snapshot();
    advance(*solver, 2);
    const Gaussians wanted = solver->gaussians();
    EXPECT_TRUE(same_bits(solver->held(*then).particles, q)) << "while the solver has gone on";
    EXPECT_TRUE(same_bits(solver->held(*then).gaussians, g));
    solver->restore(*then);
    EXPECT_TRUE(same_bits(solver->gaussians(), g));
    advance(*solver, 1);
    solver->restore(*grown);
    EXPECT_EQ(solver->gaussians().size(), g.size() + 900);
    advance(*solver, 2);
    EXPECT_TRUE(same_bits(solver->gaussians(), wanted));
    const auto other = make(turning_block());
    EXPECT_THROW(other->held(*then), std::invalid_argument);
}

}  // namespace
}  // namespace knead
