// Simulators without particles and without objects: constructed so, emptied by edits, and filled.
#include <gtest/gtest.h>

#include <cmath>

#include "host/bench/ball.h"
#include "host/scene/foresight.h"
#include "host/session/loop.h"
#include "host/solver/audit.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Given = knead::Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;
constexpr double frame = 1.0 / 90;
constexpr int nodes = 24;

class WithoutClay : public AgainstTheReference {
  protected:
    static std::unique_ptr<EditableSimulator> make(const Given& s) { return GetParam().make(s); }
};

TEST_P(WithoutClay, BeginsAndTakesItLater)
{
    knead::Setup full = ball(24);
    full.threads = 1;
    add_tools(full);
    knead::Setup bare = full;
    bare.particles.clear();
    full.materials.push_back(full.materials.at(0));
    for (Particle<double>& p : full.particles) p.object = 1;
    const auto later = GetParam().make(bare), once = GetParam().make(full);
    EXPECT_TRUE(later->particles().empty());
    EXPECT_EQ(later->advance(closing(0, frame), frame)[Count::moved], 0);
    EXPECT_TRUE(later->penetration().empty());
    EXPECT_EQ(later->add(full.materials[1], full.particles), 1);
    const auto edited = GetParam().make(full);  // rows to build an edit in have room, too
    EXPECT_EQ(edited->add(full.materials[1], {full.particles[0]}), 2);
    EXPECT_LT(double(later->memory()), 1.1 * double(edited->memory()))
        << "of nodes about the clay alone";
    long projected = 0;
    for (int f = 0; f < 4; ++f) {
        projected += later->advance(closing(f * frame, frame), frame)[Count::projected];
        once->advance(closing(f * frame, frame), frame);
    }
    EXPECT_GT(projected, 0);
    const std::vector<Particle<double>> a = later->particles(), b = once->particles();
    ASSERT_EQ(a.size(), b.size());
    if (GetParam().deterministic) {
        EXPECT_TRUE(same_bits(a, b));
    }
    Vec3<double> middle{}, other{};
    for (std::size_t i = 0; i < a.size(); ++i) middle = middle + a[i].x, other = other + b[i].x;
    EXPECT_LT(length(middle - other), 1e-5 * double(a.size()));
}

// The tools, walls and lattice of the ball, without an object.
Given empty_scene(RestMode rest = RestMode::none)
{
    Given s = ball(nodes);
    s.particles.clear(), s.materials.clear();
    s.threads = 2;
    s.rest = {rest, 1e-2, 3, 1.0, 0.1};
    add_tools(s);
    return s;
}

constexpr RestMode rest_modes[] = {RestMode::none, RestMode::sleep, RestMode::localized};

Material<double> clay_of(int category)
{
    Material<double> m = paper_clay(1.0 / nodes, 8);
    m.category = category;
    return m;
}

Particles clay_of_ball(Vec3<double> shift = {})
{
    Particles all = ball(nodes).particles;
    for (Particle<double>& p : all) p.x = p.x + shift;
    return all;
}

// A small block with a corner at `low`, of 8 particles a cell.
Particles block(Vec3<double> low)
{
    Particles all;
    for (int i = 0; i < 1000; ++i) {
        Particle<double> p{};
        const Vec3<double> at{i % 10 + 0.5, i / 10 % 10 + 0.5, i / 100 + 0.5};
        p.x = low + 0.5 / nodes * at;
        all.push_back(p);
    }
    return all;
}

FrameStats play(Simulator& solver, int from, int frames)
{
    FrameStats stats;
    for (int f = from; f < from + frames; ++f)
        stats = solver.advance(closing(f * frame, frame), frame);
    return stats;
}

// All that a frame without clay reports: finite, and nothing but substeps.
void expect_nothing(const FrameStats& stats, bool on_device)
{
    each_statistic([&](const auto& row) {
        const auto& value = stats[row.member];
        if constexpr (std::is_array_v<std::remove_reference_t<decltype(value)>>) {
            long sum = 0;
            for (const long count : value) sum += count;
            EXPECT_EQ(sum, stats.substeps) << row.name;
        } else {
            EXPECT_TRUE(std::isfinite(double(value))) << row.name;
            const std::string name = row.name;
            if (name == "substeps" || name == "dt_min_s" || name == "dt_max_s") return;
            EXPECT_EQ(double(value), 0) << name;
        }
    });
    if (on_device) {
        EXPECT_EQ(stats.substeps, 0);
        EXPECT_EQ(stats.dt_max, 0);
        return;
    }
    EXPECT_GE(stats.substeps, 1);
    EXPECT_GT(stats.dt_min, 0);
    EXPECT_LE(stats.dt_max, Given{}.step.largest);
}

void expect_empty(EditableSimulator& solver)
{
    EXPECT_EQ(solver.particle_count(), 0u);
    EXPECT_TRUE(solver.particles().empty());
    EXPECT_TRUE(solver.gaussians().empty());
    EXPECT_TRUE(solver.places({{0, 0, 0}, {1, 1, 1}}).empty());
    EXPECT_TRUE(solver.penetration().empty());
    EXPECT_TRUE(solver.velocities().empty());
    EXPECT_GT(solver.memory(), 0u);
    const Audit state = audit(solver.particles(), solver.config().materials, 1.0 / nodes);
    EXPECT_EQ(state.mass + state.volume + state.kinetic + state.fastest, 0);
    EXPECT_EQ(crowding({}, solver.config().materials, 1.0 / nodes).most, 0);
}

TEST_P(WithoutClay, FramesAndViewsOfNoObjectAreEmpty)
{
    for (const RestMode rest : rest_modes) {
        const auto solver = make(empty_scene(rest));
        expect_empty(*solver);
        for (int f = 0; f < 3; ++f) {
            expect_nothing(play(*solver, f, 1), GetParam().device);
            expect_empty(*solver);
        }
        solver->submit(closing(0, frame), frame), solver->submit(closing(0, frame), frame);
        expect_nothing(solver->collect(), GetParam().device);
        expect_nothing(solver->collect(), GetParam().device);
        EXPECT_TRUE(solver->config().materials.empty());
        if (!GetParam().device) {
            EXPECT_FALSE(stage_times(*solver).empty());
        }
        for (const StageTime& stage : stage_times(*solver))
            EXPECT_TRUE(std::isfinite(stage.seconds)) << stage.name;
    }
}

TEST_P(WithoutClay, SurfacesOfNoObjectAreNone)
{
    const auto solver = make(empty_scene());
    SessionLoopOptions options;
    options.duration = frame, options.hand_rate = 90, options.frames = 4;
    options.surface.lattice = {{nodes, nodes, nodes}, 1.0f / nodes};
    SessionLoop loop(
        *solver, [](double from, double to) { return closing(from, to - from); }, options);
    loop.launch_surfaces(true);
    std::vector<std::size_t> meshes;
    loop.observe([&](const FrameResult& f) {
        const auto on_device = loop.device_mesh();
        EXPECT_TRUE(!on_device || f.number == 3 || on_device->empty());
        meshes.push_back(loop.meshes()->size());
        if (f.number == 2)
            loop.edit([](EditableSimulator& s) { s.add(clay_of(4), clay_of_ball()); });
        if (f.number == 3) loop.edit([](EditableSimulator& s) { s.remove(0); });
    });
    loop.run();
    EXPECT_FALSE(loop.failure());
    EXPECT_EQ(meshes, (std::vector<std::size_t>{0, 0, 1, 0}));
}

TEST_P(WithoutClay, EditsOfTheSceneWork)
{
    for (const RestMode rest : rest_modes) {
        const Given bare = empty_scene(rest);
        const auto solver = make(bare);
        solver->set_gravity({0, -1, 0});
        play(*solver, 0, 1);
        solver->set_walls(walls_inside(bare.lattice, 4, ContactMode::sticky, 0.1));
        play(*solver, 0, 1);
        solver->set_tools({}, {});
        solver->advance({}, frame);
        Given blade = bare;
        for (Tool<double>& tool : blade.tools) tool.blade = true;
        solver->set_tools(blade.rig, blade.tools);
        play(*solver, 0, 2);
        solver->set_gaussians({});
        solver->edit_gaussians({});
        expect_nothing(play(*solver, 0, 1), GetParam().device);
        const Material<double> clay = clay_of(0);
        EXPECT_THROW(solver->set_material(0, clay), std::invalid_argument);
        EXPECT_THROW(solver->remove(0), std::invalid_argument);
        EXPECT_THROW(solver->move(0, {{1, 0, 0, 0}, {}}), std::invalid_argument);
        EXPECT_THROW(solver->attach(0, {{0.5, 0.5, 0.5}}), std::invalid_argument);
        EXPECT_THROW(solver->edit_gaussians({{}, {{0, {}}}}), std::invalid_argument);
        solver->remove_each({});
        EXPECT_TRUE(solver->add_each(clay, {}).empty());
        expect_empty(*solver);
    }
}

// An object of no particles, which may have Gaussians all the same.
TEST_P(WithoutClay, AnObjectMayBeWithoutParticles)
{
    const auto solver = make(empty_scene());
    EXPECT_EQ(solver->add(clay_of(1), {}), 0);
    expect_empty(*solver);
    solver->attach(0, {{0.3, 0.8, 0.8}, {0.8, 0.2, 0.2}});
    Material<double> soft = clay_of(2);
    soft.mu /= 2;
    solver->set_material(0, soft);
    play(*solver, 0, 2);
    ASSERT_EQ(solver->gaussians().size(), 2u);
    EXPECT_NEAR(solver->gaussians()[1].x.x, 0.8, 1e-6);
    solver->move(0, {{1, 0, 0, 0}, {-0.1, 0, 0}});
    play(*solver, 0, 1);
    EXPECT_NEAR(solver->gaussians()[1].x.x, 0.7, 1e-6);
    EXPECT_EQ(solver->add(clay_of(1), clay_of_ball()), 1);
    EXPECT_GT(play(*solver, 0, 1)[Count::moved], 0);
    solver->remove(1);
    play(*solver, 0, 1);
    solver->remove(0);
    play(*solver, 0, 1);
    expect_empty(*solver);
}

TEST_P(WithoutClay, SnapshotsAndStatesOfNothingComeBack)
{
    for (const RestMode rest : rest_modes) {
        const Given bare = empty_scene(rest);
        const auto solver = make(bare);
        play(*solver, 0, 1);
        const auto nothing = solver->snapshot();
        const SavedState saved = solver->save();
        EXPECT_TRUE(solver->held(*nothing).particles.empty());
        EXPECT_TRUE(solver->held(*nothing).gaussians.empty());
        EXPECT_TRUE(solver->gaussians_of(*nothing, {}).indices.empty());
        EXPECT_TRUE(saved.order.empty());
        solver->restore(*nothing);
        expect_nothing(play(*solver, 0, 1), GetParam().device);

        solver->add(clay_of(0), clay_of_ball());
        solver->attach(0, {{0.5, 0.5, 0.5}});
        play(*solver, 0, 2);
        const auto full = solver->snapshot();
        const SavedState saved_full = solver->save();
        const Particles then = solver->particles();
        solver->restore(*nothing);
        expect_empty(*solver);
        EXPECT_TRUE(solver->config().materials.empty());
        expect_nothing(play(*solver, 0, 1), GetParam().device);
        solver->restore(*full);
        EXPECT_TRUE(same_bits(solver->particles(), then));
        play(*solver, 2, 2);
        const Particles after = solver->particles();

        const auto other = make(bare);
        other->load(saved_full);
        EXPECT_TRUE(same_bits(other->particles(), then));
        EXPECT_EQ(other->gaussians().size(), 1u);
        play(*other, 2, 2);
        if (GetParam().deterministic || !GetParam().device) {
            EXPECT_TRUE(same_bits(other->particles(), after));
        }
        other->load(saved);
        expect_empty(*other);
        expect_nothing(play(*other, 0, 1), GetParam().device);
    }
}

// The same bits as of one constructed with these objects; on the device in the deterministic mode.
TEST_P(WithoutClay, ClayAddedLaterIsAsIfItHadBeenThere)
{
    for (const RestMode rest : rest_modes) {
        const Given bare = empty_scene(rest);
        const auto later = make(bare);
        play(*later, 0, 2);
        const std::vector<Particles> clays{clay_of_ball(), {}, block({0.14, 0.14, 0.14})};
        EXPECT_EQ(later->add_each(clay_of(3), clays), (std::vector<int>{0, 1, 2}));
        Given full = bare;
        full.materials.assign(3, clay_of(3));
        for (std::size_t k = 0; k < clays.size(); ++k)
            for (Particle<double> p : clays[k]) {
                p.object = int(k);
                full.particles.push_back(p);
            }
        const auto once = make(full);
        EXPECT_EQ(later->particle_count(), full.particles.size());
        EXPECT_TRUE(same_bits(later->particles(), once->particles()));
        const FrameStats a = play(*later, 2, 3), b = play(*once, 2, 3);
        EXPECT_GT(a.substeps, 0);
        EXPECT_TRUE(std::isfinite(length(later->particles().at(0).x)));
        if (!GetParam().deterministic && GetParam().device) continue;
        EXPECT_EQ(a.substeps, b.substeps);
        EXPECT_EQ(a.dt_min, b.dt_min);
        EXPECT_EQ(a[Count::moved], b[Count::moved]);
        EXPECT_TRUE(same_bits(later->particles(), once->particles()));
    }
}

TEST_P(WithoutClay, TheLastObjectMayGoAndAnotherCome)
{
    for (const RestMode rest : rest_modes) {
        const auto solver = make(empty_scene(rest));
        for (int round = 0; round < 3; ++round) {
            EXPECT_EQ(solver->add(clay_of(round), clay_of_ball()), round);
            EXPECT_GT(play(*solver, 0, 2).substeps, 0);
            solver->attach(round, {{0.5, 0.5, 0.5}});
            play(*solver, 2, 1);
            solver->remove(round);
            expect_empty(*solver);
            expect_nothing(play(*solver, 0, 1), GetParam().device);
            solver->set_gravity({0, -double(round), 0});
            expect_nothing(play(*solver, 0, 1), GetParam().device);
            EXPECT_EQ(solver->save().config.materials.size(), std::size_t(round) + 1);
        }
    }
}

// After add(a), add(b), remove(a), the next frames have the bits of a simulator constructed of b,
// but for the object's number: numbers are never used twice, so b stays object 1. Ids, which are
// indices into particles(), are those of the other simulator. On a device, kernels for scenes of
// one object are others: there it has the bits of one in which object 0 has no particles.
TEST_P(WithoutClay, ARemovedObjectLeavesNothingButItsNumber)
{
    for (const RestMode rest : rest_modes) {
        const Given bare = empty_scene(rest);
        const auto edited = make(bare);
        const Particles b = clay_of_ball();
        EXPECT_EQ(edited->add(clay_of(3), block({0.14, 0.14, 0.14})), 0);
        EXPECT_EQ(edited->add(clay_of(4), b), 1);
        edited->remove(0);
        ASSERT_EQ(edited->config().materials.size(), 2u);
        EXPECT_EQ(edited->config().materials[0], Material<double>{});
        const int number = GetParam().device ? 1 : 0;
        Given alone = bare;
        alone.materials.assign(std::size_t(number) + 1, clay_of(4)), alone.particles = b;
        for (Particle<double>& p : alone.particles) p.object = number;
        const auto fresh = make(alone);
        const auto expect_equal = [&] {
            Particles of_edited = edited->particles();
            for (Particle<double>& p : of_edited) {
                ASSERT_EQ(p.object, 1);
                p.object = number;
            }
            EXPECT_TRUE(same_bits(of_edited, fresh->particles()));
        };
        expect_equal();
        const FrameStats one = play(*edited, 0, 4), two = play(*fresh, 0, 4);
        if (!GetParam().deterministic && GetParam().device) continue;
        EXPECT_EQ(one.substeps, two.substeps);
        EXPECT_EQ(one[Count::projected], two[Count::projected]);
        expect_equal();
    }
}

INSTANTIATE_TEST_SUITE_P(BackEnds, WithoutClay, ::testing::ValuesIn(back_ends),
                         [](const auto& device) { return device.param.name; });

TEST(ReferenceWithoutClay, AdvancesAndIsEmpty)
{
    Reference reference(empty_scene());
    for (int f = 0; f < 2; ++f) expect_nothing(play(reference, f, 1), false);
    EXPECT_TRUE(reference.particles().empty());
    EXPECT_TRUE(reference.penetration().empty());
    EXPECT_TRUE(reference.velocities().empty());
    EXPECT_TRUE(reference.gaussians().empty());
    EXPECT_GT(reference.memory(), 0u);
    EXPECT_EQ(reference.particle_count(), 0u);
}

TEST(Foresee, WithoutObjectsTheLargestStepCounts)
{
    Scene scene{};
    scene.setup = empty_scene();
    scene.frame_rate = 90;
    const Foresight f = foresee(scene);
    EXPECT_EQ(f.key, "step.largest");
    EXPECT_EQ(f.substeps, std::ceil(frame_duration(scene) / scene.setup.step.largest));
    EXPECT_TRUE(std::isfinite(f.dt) && f.dt > 0);
    EXPECT_LE(f.dt, scene.setup.step.largest);
    check_substeps(scene);
    scene.frame_rate = 1000;
    EXPECT_EQ(foresee(scene).substeps, 1);
    scene.setup.step.fixed = 1e-4;
    EXPECT_EQ(foresee(scene).key, "step.fixed");
}

}  // namespace
}  // namespace knead
