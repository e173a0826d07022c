// Clay of snapshots as planes of floats, and clay that replaces a simulator's: afterwards it does
// what one does that was made of it, to the bit.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/gpu/region_padding.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;
using Gaussians = std::vector<Gaussian<double>>;
constexpr int nodes = 32;
constexpr double frame = 1.0 / 90, dx = 1.0 / nodes;

class Replaced : public OnBothDevices {};
INSTANTIATE_TEST_SUITE_P(Solver, Replaced, testing::Values(false, true), device_of);

Material<double> soft_snow()
{
    Material<double> m = paper_clay(dx, 8);
    m.plasticity = Plasticity::clamp, m.elasticity = Elasticity::fixed_corotated;
    m.compress = 0.025, m.stretch = 0.0075, m.snow = 5;
    return m;
}

Particles cube(Vec3<double> low, int edge, int object)
{
    Particles all;
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x) {
                Particle<double> p{};
                p.x = low + dx / 2 * Vec3<double>{x + 0.5, y + 0.5, z + 0.5};
                p.object = object;
                all.push_back(p);
            }
    return all;
}

void append(Particles& all, const Particles& more)
{
    all.insert(all.end(), more.begin(), more.end());
}

// Clay and snow between two cones; each tenth particle of the clay has a Gaussian.
Given pressed()
{
    Given s = ball(nodes);
    add_tools(s);
    s.deterministic = true, s.threads = 2;
    s.materials.push_back(soft_snow());
    s.particles = cube({0.4, 0.35, 0.4}, 13, 0);
    append(s.particles, cube({0.55, 0.6, 0.45}, 6, 1));
    for (std::size_t i = 0; i < 2197; i += 10)
        s.gaussians.push_back(gaussian_at(s.particles[i].x, 0));
    return s;
}

// With a lump far from the cones, which falls asleep.
Given asleep()
{
    Given s = pressed();
    append(s.particles, cube({0.45, 0.45, 0.12}, 6, 0));
    s.rest = {RestMode::sleep, 5e-2, 2, 4.9, 4 * dx};
    s.gravity = {};
    return s;
}

// With a knife instead of the cones: particles get labels.
Given sliced()
{
    Given s = pressed();
    s.rig = {};
    const Vec3<float> corner[3] = {{0, 0, -0.6f}, {0, 0, 0.6f}, {0, 0.9f, 0}};
    for (const Vec3<float>& c : corner) {
        Binding<float> b{};
        for (int& j : b.joint) j = wrist;
        b.weight[0] = 1, b.offset[0] = c, b.radius = 1e-3f;
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives = {{3, {0, 1, 2}, 0}};
    s.tools = {{ContactMode::separate, 0.1, true, true}};
    return s;
}
Motion stroke(int f)
{
    const auto at = [](double y) {
        auto joints = wrists(0, 0);
        joints[wrist].p.y = y;
        return joints;
    };
    return {at(0.66 - 0.04 * f), at(0.62 - 0.04 * f), {1}};
}

FrameStats advance(EditableSimulator& solver, int f)
{
    const std::vector<Tool<double>>& tools = solver.config().tools;
    const bool knife = !tools.empty() && tools[0].blade;
    return solver.advance(knife ? stroke(f) : closing(f * frame, frame), frame);
}
void play(EditableSimulator& solver, int from, int frames)
{
    for (int f = from; f < from + frames; ++f) advance(solver, f);
}

// Particles as of ClayRows.
Particles at_rest(Particles all)
{
    for (Particle<double>& p : all) p.v = {}, p.C = {};
    return all;
}

// The particles and Gaussians of rows in double.
Particles particles_of(const ClayRows& rows)
{
    Particles all;
    for (std::size_t i = 0; i < rows.count; ++i) all.push_back(cast<double>(particle_at(rows, i)));
    return all;
}
Gaussians gaussians_of(const ClayRows& rows)
{
    Gaussians all;
    for (const Gaussian<float>& g : rows.gaussians) all.push_back(cast<double>(g));
    return all;
}

ClayRows rows_of(const EditableSimulator& solver) { return solver.rows(*solver.snapshot()); }

// What a simulator made of `solver`'s configuration and this clay is given.
Given anew(const EditableSimulator& solver, const Particles& particles, const Gaussians& gaussians)
{
    return {solver.config(), {particles, gaussians}, pressed()};
}

void expect_same_future(EditableSimulator& one, EditableSimulator& other, int from, int frames)
{
    EXPECT_TRUE(same_bits(one.particles(), other.particles()));
    EXPECT_TRUE(same_bits(one.gaussians(), other.gaussians()));
    for (int f = from; f < from + frames; ++f) {
        const FrameStats a = advance(one, f), b = advance(other, f);
        EXPECT_EQ(a.substeps, b.substeps) << f;
        EXPECT_EQ(a[Count::moved], b[Count::moved]) << f;
        EXPECT_EQ(a.fastest, b.fastest) << f;
        EXPECT_EQ(a[Count::repaired], 0) << f;
    }
    EXPECT_TRUE(same_bits(one.particles(), other.particles()));
    EXPECT_TRUE(same_bits(one.gaussians(), other.gaussians()));
}

TEST_P(Replaced, RowsAreWhatASnapshotHoldsWithoutVelocities)
{
    for (const Given& s : {pressed(), asleep(), sliced()}) {
        const auto solver = make(s);
        play(*solver, 0, 4);
        const auto then = solver->snapshot();
        const SnapshotData held = solver->held(*then);
        const FrameStats stats = advance(*solver, 4);
        EXPECT_EQ(stats[Count::moved] < long(s.particles.size()) * stats.substeps,
                  s.rest.mode == RestMode::sleep);
        const ClayRows rows = solver->rows(*then);
        EXPECT_EQ(rows.count, held.particles.size());
        EXPECT_TRUE(same_bits(particles_of(rows), at_rest(held.particles)));
        EXPECT_TRUE(same_bits(gaussians_of(rows), held.gaussians));
        for (const std::uint32_t sides : rows.sides) ASSERT_LE(sides, 2u);
        const auto other = make(s);
        EXPECT_THROW(other->rows(*then), std::invalid_argument);
    }
}

// Of clay that is there already, and of a scene that has shrunk, grown and lost all clay since.
TEST_P(Replaced, ClayGivesTheBitsOfANewSimulator)
{
    for (const Given& s : {pressed(), asleep(), sliced()}) {
        const auto solver = make(s);
        play(*solver, 0, 4);
        const SimulationConfig config = solver->config();
        const ClayRows rows = rows_of(*solver);
        const std::function<void()> before[] = {
            [&] { play(*solver, 4, 2); }, [&] { solver->remove(0); },
            [&] {
                solver->add(paper_clay(dx, 8), cube({0.2, 0.6, 0.6}, 9, 0));
            },
            [&] {
                solver->remove(0);
                if (solver->config().materials.at(1).density > 0) solver->remove(1);
                solver->set_gravity({1, 2, 3});
                solver->set_walls(walls_inside(solver->config().lattice, 4, ContactMode::slip, 0));
                play(*solver, 4, 1);
            },
            [&] {
                GaussianEdits edits;
                for (int k = 0; k < 100; ++k) edits.splits.push_back({k, {0.001, 0, 0}});
                solver->edit_gaussians(edits);
            }};
        for (const auto& change : before) {
            change();
            const long version = solver->version();
            solver->replace(config, rows);
            EXPECT_NE(solver->version(), version);
            EXPECT_EQ(solver->particle_count(), rows.count);
            EXPECT_EQ(solver->config().gravity.x, config.gravity.x);
            const auto fresh = make(anew(*solver, particles_of(rows), gaussians_of(rows)));
            expect_same_future(*solver, *fresh, 4, 3);
        }
    }
}

TEST_P(Replaced, ASceneGoesBackToItsBeginning)
{
    for (const Given& given : {pressed(), asleep(), sliced()}) {
        Given s = given;
        for (Particle<double>& p : s.particles) p.v = {0.1, -0.2, 0.05};
        const auto solver = make(s);
        play(*solver, 0, 4);
        solver->remove(1);
        solver->replace(s, s);
        const auto fresh = make(s);
        expect_same_future(*solver, *fresh, 0, 4);
        // And where nothing but frames lies between.
        solver->replace(s, s);
        expect_same_future(*solver, *make(s), 0, 2);
    }
}

TEST_P(Replaced, NoClayIsClayToo)
{
    const auto solver = make(pressed());
    play(*solver, 0, 2);
    const SimulationConfig config = solver->config();
    const ClayRows rows = rows_of(*solver);
    SimulationConfig without = config;
    without.materials.clear();
    solver->replace(without, ClayRows{});
    EXPECT_EQ(solver->particle_count(), 0u);
    EXPECT_TRUE(solver->gaussians().empty());
    EXPECT_EQ(solver->advance(closing(0, frame), frame)[Count::moved], 0);
    EXPECT_EQ(rows_of(*solver).count, 0u);
    solver->replace(config, rows);
    expect_same_future(*solver, *make(anew(*solver, particles_of(rows), gaussians_of(rows))), 2, 2);
}

TEST_P(Replaced, EditsFollowAsInANewSimulator)
{
    const auto solver = make(pressed());
    play(*solver, 0, 3);
    const SimulationConfig config = solver->config();
    const ClayRows rows = rows_of(*solver);
    play(*solver, 3, 2);
    solver->replace(config, rows);
    const auto fresh = make(anew(*solver, particles_of(rows), gaussians_of(rows)));
    const auto edit = [](EditableSimulator& of) {
        EXPECT_EQ(of.add(soft_snow(), cube({0.2, 0.2, 0.6}, 5, 0)), 2);
        of.move(1, {{1, 0, 0, 0}, {0, 0.05, 0.1}});
        of.set_material(0, soft_snow());
        of.attach(2, {{0.21, 0.21, 0.61}});
    };
    edit(*solver), edit(*fresh);
    expect_same_future(*solver, *fresh, 3, 2);
    const auto then = solver->snapshot();
    solver->replace(config, rows);
    play(*solver, 0, 1);
    solver->restore(*then);
    expect_same_future(*solver, *fresh, 5, 2);
}

// Tools that have come since stay, and particles keep labels of blades that are no more.
TEST_P(Replaced, TheToolsStay)
{
    const auto solver = make(sliced());
    play(*solver, 0, 4);
    const SimulationConfig config = solver->config();
    const ClayRows rows = rows_of(*solver);
    EXPECT_GT(std::count_if(rows.sides.begin(), rows.sides.end(), [](auto s) { return s != 0; }),
              0);
    const Given other = pressed();
    solver->set_tools(other.rig, other.tools);
    play(*solver, 4, 1);
    solver->replace(config, rows);
    EXPECT_FALSE(solver->config().tools.at(0).blade);
    EXPECT_TRUE(solver->config().cuts);
    expect_same_future(*solver, *make(anew(*solver, particles_of(rows), gaussians_of(rows))), 4, 2);
    // Before any blade.
    const Given s = pressed();
    solver->replace(s, s);
    EXPECT_FALSE(solver->config().cuts);
    expect_same_future(*solver, *make(anew(*solver, s.particles, s.gaussians)), 0, 2);
}

TEST_P(Replaced, WhatCannotBeIsSaidAndChangesNothing)
{
    const auto solver = make(pressed()), untouched = make(pressed());
    play(*solver, 0, 2), play(*untouched, 0, 2);
    const SimulationConfig config = solver->config();
    const ClayRows rows = rows_of(*solver);
    const long version = solver->version();
    const auto refused = [&](const char* reason, const std::function<void(ClayRows&)>& spoil,
                             const std::function<void(SimulationConfig&)>& spoil_config = {}) {
        ClayRows bad = rows;
        SimulationConfig other = config;
        if (spoil) spoil(bad);
        if (spoil_config) spoil_config(other);
        try {
            solver->replace(other, bad);
            ADD_FAILURE() << "accepted: " << reason;
        } catch (const std::invalid_argument& e) {
            EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
        }
    };
    const std::size_t n = rows.count;
    refused("behind a wall", [](ClayRows& r) { r.planes[5] = -1; });
    refused("behind a wall", [&](ClayRows& r) { r.planes[n + 7] = 40; });
    refused("not finite", [](ClayRows& r) { r.planes[3] = NAN; });
    refused("not finite", [&](ClayRows& r) { r.planes[9 * n] = INFINITY; });
    refused("no object 2", [](ClayRows& r) { r.object[11] = 2; });
    refused("no object -1", [](ClayRows& r) { r.object[11] = -1; });
    refused("no longer an object 1", {}, [](SimulationConfig& c) { c.materials[1] = {}; });
    refused("invalid label", [](ClayRows& r) { r.sides[1] = 3; });
    refused("invalid label", [](ClayRows& r) { r.sides[1] = Particle<float>::still_bit; });
    refused("clay of", [](ClayRows& r) { r.planes.pop_back(); });
    refused("clay of", [](ClayRows& r) { r.object.pop_back(); });
    refused("clay of", [](ClayRows& r) { r.sides.push_back(0); });
    refused("a Gaussian", [](ClayRows& r) { r.gaussians[3].x.z = 9; });
    refused("no object 7", [](ClayRows& r) { r.gaussians[3].object = 7; });
    refused("lattice", {}, [](SimulationConfig& c) { c.lattice.dx *= 2; });
    refused("options", {}, [](SimulationConfig& c) { c.passes = 3; });
    refused("options", {}, [](SimulationConfig& c) { c.rest.mode = RestMode::sleep; });
    refused("options", {}, [](SimulationConfig& c) { c.step.fixed = 1e-3; });
    refused("gravity", {}, [](SimulationConfig& c) { c.gravity.y = NAN; });
    refused("walls", {}, [](SimulationConfig& c) { c.walls.min.x = -1; });
    refused("density", {}, [](SimulationConfig& c) { c.materials[0].mass = 0; });
    InitialState thrown{solver->particles(), {}};
    thrown.particles[4].v.x = NAN;
    EXPECT_THROW(solver->replace(config, thrown), std::invalid_argument);
    EXPECT_EQ(solver->version(), version);
    expect_same_future(*solver, *untouched, 2, 2);
}

// Clay in two corners needs more nodes than there is memory for.
TEST(ReplacedOnAGpu, WhereMemoryEndsAllIsAsItWas)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    Given s = pressed();
    s.rig = {}, s.tools = {}, s.gaussians.clear();
    s.particles = cube({0.45, 0.45, 0.45}, 6, 0);
    const RegionPadding room{0, 20000};
    const auto solver = gpu_solver(s, 0, room), untouched = gpu_solver(s, 0, room);
    play(*solver, 0, 2), play(*untouched, 0, 2);
    InitialState far{cube({0.12, 0.12, 0.12}, 4, 0), {}};
    append(far.particles, cube({0.8, 0.8, 0.8}, 4, 1));
    SimulationConfig other = solver->config();
    other.gravity = {5, 0, 0};
    EXPECT_THROW(solver->replace(other, far), std::runtime_error);
    EXPECT_EQ(solver->config().gravity.x, s.gravity.x);
    expect_same_future(*solver, *untouched, 2, 2);
}

}  // namespace
}  // namespace knead
