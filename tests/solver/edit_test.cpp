// A solver that is edited while it lives does what one does that was made of the edited scene, to
// the bit: on the CPU, and on a GPU in the deterministic mode.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

constexpr double frame = 1.0 / 90;
using Scene = knead::Setup;  // Setup is a name of GoogleTest
using Particles = std::vector<Particle<double>>;

struct Backend {
    const char* name;
    bool gpu;
};

class Edit : public ::testing::TestWithParam<Backend> {
  protected:
    void SetUp() override
    {
        if (GetParam().gpu && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    static std::unique_ptr<EditableSimulator> make(const Scene& s)
    {
        return GetParam().gpu ? gpu_solver(s, 0) : cpu_solver(s);
    }
};

// A ball of radius r [m] around c, of the lattice's 8 particles a cell.
Particles clay_around(Vec3<double> c, double r, double dx)
{
    Particles out;
    const int n = int(2 * r / dx) + 1;
    for (int z = -n; z <= n; ++z)
        for (int y = -n; y <= n; ++y)
            for (int x = -n; x <= n; ++x) {
                const Vec3<double> d{dx / 2 * (x + 0.5), dx / 2 * (y + 0.5), dx / 2 * (z + 0.5)};
                Particle<double> p{};
                p.x = c + d;
                if (length(d) < r) out.push_back(p);
            }
    return out;
}

Material<double> snow(double dx)
{
    Material<double> m = paper_clay(dx, 8);
    m.plasticity = Plasticity::clamp, m.elasticity = Elasticity::fixed_corotated;
    m.compress = 0.025, m.stretch = 0.0075, m.snow = 5;
    return m;
}

constexpr int nodes = 32;
constexpr double dx = 1.0 / nodes;

// A ball of clay and one of snow over the floor, with two cones.
Scene two_balls()
{
    Scene s = ball(nodes);
    s.deterministic = true, s.threads = 2;
    s.particles = clay_around({0.42, 0.5, 0.5}, 0.12, dx);
    s.materials.push_back(snow(dx));
    for (Particle<double> p : clay_around({0.68, 0.45, 0.5}, 0.08, dx)) {
        p.object = 1;
        s.particles.push_back(p);
    }
    add_tools(s);
    return s;
}

void play(EditableSimulator& solver, int from, int frames)
{
    for (int f = from; f < from + frames; ++f) solver.advance(closing(f * frame, frame), frame);
}

// The scene as it stands, made anew.
Scene anew(const EditableSimulator& solver)
{
    return {solver.config(), {solver.particles(), {}}, two_balls()};
}

// Plays two frames, edits the one solver, and the scene that the other is made of.
void expect_equal_to_one_made_so(
    const std::function<std::unique_ptr<EditableSimulator>(const Scene&)>& make,
    const std::function<void(EditableSimulator&)>& edit,
    const std::function<void(Scene&)>& edit_scene)
{
    const std::unique_ptr<EditableSimulator> edited = make(two_balls());
    play(*edited, 0, 2);
    Scene scene = anew(*edited);
    edit_scene(scene);
    edit(*edited);
    const std::unique_ptr<EditableSimulator> fresh = make(scene);
    EXPECT_TRUE(same_bits(edited->particles(), fresh->particles()));
    play(*edited, 2, 3), play(*fresh, 2, 3);
    const Particles one = edited->particles(), other = fresh->particles();
    EXPECT_TRUE(same_bits(one, other));
    ASSERT_FALSE(one.empty());
    EXPECT_TRUE(std::isfinite(one[0].x.x));
}

TEST_P(Edit, AddedClayIsAsIfItHadBeenThere)
{
    const Particles more = clay_around({0.5, 0.75, 0.5}, 0.08, dx);
    expect_equal_to_one_made_so(
        make, [&](EditableSimulator& s) { EXPECT_EQ(s.add(snow(dx), more), 2); },
        [&](Scene& s) {
            s.materials.push_back(snow(dx));
            for (Particle<double> p : more) p.object = 2, s.particles.push_back(p);
        });
}

TEST_P(Edit, RemovedClayIsAsIfItHadNotBeenThere)
{
    expect_equal_to_one_made_so(
        make, [](EditableSimulator& s) { s.remove(0); },
        [](Scene& s) { std::erase_if(s.particles, [](const auto& p) { return p.object == 0; }); });
}

TEST_P(Edit, AnotherMaterialIsAsIfItHadBeenThere)
{
    expect_equal_to_one_made_so(
        make, [](EditableSimulator& s) { s.set_material(0, snow(dx)); },
        [](Scene& s) {
            s.materials[0] = snow(dx);
            for (Particle<double>& p : s.particles)
                if (p.object == 0) change_law(p, Plasticity::von_mises, Plasticity::clamp);
        });
}

TEST_P(Edit, MovedClayIsAsIfItHadBeenThere)
{
    const RigidMotion<double> motion{turn_about(Vec3<double>{0, 1, 0}, 0.4), {-0.15, 0.2, 0.25}};
    expect_equal_to_one_made_so(
        make, [&](EditableSimulator& s) { s.move(1, motion); },
        [&](Scene& s) {
            for (Particle<double>& p : s.particles)
                if (p.object == 1) move(p, motion);
        });
}

TEST_P(Edit, GravityWallsAndToolsAreAsIfTheyHadBeenSo)
{
    Scene other = ball(nodes);
    add_tools(other);
    for (Binding<float>& b : other.rig.spheres) b.radius *= 0.5f;
    other.tools[0].mode = ContactMode::slip;
    expect_equal_to_one_made_so(
        make,
        [&](EditableSimulator& s) {
            s.set_gravity({0, 3, -9.81});
            s.set_walls(walls_inside(other.lattice, 4, ContactMode::sticky, 0.1));
            s.set_tools(other.rig, other.tools);
        },
        [&](Scene& s) {
            s.gravity = {0, 3, -9.81};
            s.walls = walls_inside(other.lattice, 4, ContactMode::sticky, 0.1);
            s.rig = other.rig, s.tools = other.tools;
        });
}

// Two balls that touch; of the same category they would stay welded.
TEST_P(Edit, ContactOfBodiesIsAsIfItHadBeenSo)
{
    const auto category = [](Material<double> m, int c) { return m.category = c, m; };
    const RigidMotion<double> to_the_other{{1, 0, 0, 0}, {-0.07, 0.02, 0}};
    const BodyContact contact{true, 0.7};
    const auto before = [&](const Scene& s) {
        auto solver = make(s);
        solver->set_material(1, category(snow(dx), 1));
        solver->move(1, to_the_other);
        return solver;
    };
    const auto one = before(two_balls()), other = before(two_balls());
    play(*one, 0, 2), play(*other, 0, 2);
    Scene scene = anew(*one);
    scene.contact = contact;
    one->set_contact(contact);
    EXPECT_EQ(one->config().contact, contact);
    const auto fresh = make(scene);
    play(*one, 2, 3), play(*fresh, 2, 3), play(*other, 2, 3);
    EXPECT_TRUE(same_bits(one->particles(), fresh->particles()));
    EXPECT_FALSE(same_bits(one->particles(), other->particles()));
    EXPECT_THROW(one->set_contact({true, -0.1}), std::invalid_argument);
    EXPECT_THROW(one->set_contact({true, std::nan("")}), std::invalid_argument);
    EXPECT_EQ(one->config().contact, contact);
    one->set_contact({});
    const auto welded = make(anew(*one));
    play(*one, 5, 2), play(*welded, 5, 2);
    EXPECT_TRUE(same_bits(one->particles(), welded->particles()));
}

TEST_P(Edit, ToolsMayGoAndBladesMayCome)
{
    Scene blade = ball(nodes);
    add_tools(blade);
    for (Tool<double>& tool : blade.tools) tool.blade = true;
    const auto solver = make(two_balls());
    play(*solver, 0, 2);
    solver->set_tools({}, {});
    for (int f = 0; f < 2; ++f) solver->advance({}, frame);
    solver->set_tools(blade.rig, blade.tools);
    play(*solver, 4, 3);
    solver->set_tools({}, {});
    for (int f = 0; f < 2; ++f) EXPECT_EQ(solver->advance({}, frame)[Count::repaired], 0);
    EXPECT_TRUE(solver->config().cuts);
    EXPECT_EQ(solver->particles().size(), two_balls().particles.size());
}

TEST_P(Edit, ASnapshotBringsTheSameFutureBack)
{
    const auto solver = make(two_balls());
    play(*solver, 0, 3);
    const auto snapshot = solver->snapshot();
    const Particles then = solver->particles();
    play(*solver, 3, 4);
    const Particles first = solver->particles();
    const long version = solver->version();
    solver->restore(*snapshot);
    EXPECT_NE(solver->version(), version);
    EXPECT_TRUE(same_bits(solver->particles(), then));
    play(*solver, 3, 4);
    EXPECT_TRUE(same_bits(solver->particles(), first));
    EXPECT_GT(snapshot->bytes(), then.size() * 50);

    // And after edits of everything.
    solver->remove(0);
    const int object = solver->add(snow(dx), clay_around({0.25, 0.25, 0.25}, 0.1, dx));
    solver->set_material(object, paper_clay(dx, 8));
    solver->move(object, {{1, 0, 0, 0}, {0.5, 0.45, 0.4}});
    solver->set_gravity({});
    solver->set_tools({}, {});
    for (int f = 0; f < 2; ++f) solver->advance({}, frame);
    solver->restore(*snapshot);
    EXPECT_TRUE(same_bits(solver->particles(), then));
    EXPECT_EQ(solver->config().gravity.y, two_balls().gravity.y);
    play(*solver, 3, 4);
    EXPECT_TRUE(same_bits(solver->particles(), first));
}

TEST_P(Edit, ASnapshotOutlivesItsSolverAndKnowsIt)
{
    auto solver = make(two_balls());
    const auto snapshot = solver->snapshot();
    solver = make(two_balls());
    EXPECT_THROW(solver->restore(*snapshot), std::invalid_argument);
    solver.reset();
    EXPECT_GT(snapshot->bytes(), 0u);
}

TEST_P(Edit, ASavedStateGoesOnInAnotherSolver)
{
    const auto solver = make(two_balls());
    play(*solver, 0, 3);
    solver->remove(0);
    solver->add(snow(dx), clay_around({0.35, 0.7, 0.5}, 0.1, dx));
    play(*solver, 3, 2);
    SavedState state = solver->save();
    play(*solver, 5, 3);
    const auto other = make(two_balls());
    play(*other, 0, 1);
    other->load(state);
    play(*other, 5, 3);
    EXPECT_TRUE(same_bits(solver->particles(), other->particles()));
    EXPECT_THROW(other->add(snow(dx), {Particle<double>{}}), std::invalid_argument);
    SavedState slow = state, soft = state;
    state.order[0] = state.order[1], slow.speed_squared = -1, soft.stiffness = NAN;
    for (const SavedState& bad : {state, slow, soft})
        EXPECT_THROW(other->load(bad), std::invalid_argument);
    EXPECT_TRUE(same_bits(solver->particles(), other->particles()));
}

TEST_P(Edit, WhatCannotBeIsSaidAndChangesNothing)
{
    const auto solver = make(two_balls());
    play(*solver, 0, 2);
    solver->remove(1);
    const Particles before = solver->particles();
    const Material<double> clay = paper_clay(dx, 8);
    Particles bad = clay_around({0.5, 0.7, 0.5}, 0.05, dx);
    bad.back().v.y = NAN;
    Material<double> hollow = clay, soft = clay;
    hollow.density = 0;
    soft.elasticity = Elasticity::fixed_corotated;
    EXPECT_THROW(solver->set_material(0, soft), std::invalid_argument);
    for (int object : {-1, 1, 2, 1000000}) {
        EXPECT_THROW(solver->remove(object), std::invalid_argument);
        EXPECT_THROW(solver->set_material(object, clay), std::invalid_argument);
        EXPECT_THROW(solver->move(object, {{1, 0, 0, 0}, {}}), std::invalid_argument);
    }
    EXPECT_THROW(solver->add(clay, bad), std::invalid_argument);
    EXPECT_THROW(solver->add(hollow, {}), std::invalid_argument);
    EXPECT_THROW(solver->set_material(0, hollow), std::invalid_argument);
    EXPECT_THROW(solver->add(clay, clay_around({0.5, 0.02, 0.5}, 0.05, dx)), std::invalid_argument);
    EXPECT_THROW(solver->move(0, {{1, 0, 0, 0}, {0, 5, 0}}), std::invalid_argument);
    EXPECT_THROW(solver->move(0, {{2, 0, 0, 0}, {}}), std::invalid_argument);
    EXPECT_THROW(solver->set_gravity({0, INFINITY, 0}), std::invalid_argument);
    Scene tools = two_balls();
    tools.rig.primitives[0].sphere[1] = 77;
    EXPECT_THROW(solver->set_tools(tools.rig, tools.tools), std::invalid_argument);
    EXPECT_TRUE(same_bits(solver->particles(), before));
    play(*solver, 2, 1);
}

TEST_P(Edit, AllClayMayGoAndComeBack)
{
    const auto solver = make(two_balls());
    play(*solver, 0, 1);
    const auto snapshot = solver->snapshot();
    solver->remove(0), solver->remove(1);
    EXPECT_TRUE(solver->particles().empty());
    EXPECT_EQ(solver->advance(closing(0, frame), frame)[Count::moved], 0);
    EXPECT_TRUE(solver->penetration().empty());
    const Particles more = clay_around({0.5, 0.5, 0.5}, 0.1, dx);
    EXPECT_EQ(solver->add(snow(dx), more), 2);
    play(*solver, 1, 2);
    EXPECT_EQ(solver->particles().size(), more.size());
    solver->restore(*snapshot);
    EXPECT_EQ(solver->particles().size(), two_balls().particles.size());
    play(*solver, 1, 2);
}

TEST_P(Edit, ASetupWithoutMaterialsTakesClay)
{
    Scene empty = two_balls();
    const Scene full = empty;
    empty.particles.clear(), empty.materials.clear();
    const auto solver = make(empty);
    play(*solver, 0, 2);
    EXPECT_TRUE(solver->particles().empty());
    for (int object = 0; object < int(full.materials.size()); ++object) {
        Particles clay;
        for (const Particle<double>& q : full.particles)
            if (q.object == object) clay.push_back(q);
        EXPECT_EQ(solver->add(full.materials[std::size_t(object)], clay), object);
    }
    play(*solver, 2, 3);
    EXPECT_EQ(solver->particles().size(), full.particles.size());
}

// What is touched wakes up; what is far sleeps on.
TEST_P(Edit, OnlyWhatAnEditTouchesWakes)
{
    Scene s = two_balls();
    s.gravity = {};
    s.rest = {RestMode::sleep, 1e-2, 3, 1.0, 0.1};
    s.rig = {}, s.tools = {};
    const auto solver = make(s);
    FrameStats stats;
    for (int f = 0; f < 10; ++f) stats = solver->advance({}, frame);
    EXPECT_EQ(stats[Count::moved], 0);
    const RigidMotion<double> up{{1, 0, 0, 0}, {0, 0.2, 0}};
    solver->move(1, up);
    stats = solver->advance({}, frame);
    const auto of = [&](int object) {
        long n = 0;
        for (const Particle<double>& p : s.particles) n += p.object == object;
        return n * stats.substeps;
    };
    EXPECT_GE(stats[Count::moved], of(1));
    EXPECT_LT(stats[Count::moved], of(0) + of(1));
    const SavedState state = solver->save();
    const auto other = make(s);
    other->load(state);
    EXPECT_EQ(solver->advance({}, frame)[Count::moved], other->advance({}, frame)[Count::moved]);
}

// Whatever comes in whatever order: nobody is lost, nothing breaks.
TEST_P(Edit, AThousandRandomEditsKeepTheBooks)
{
    Draw draw(11);
    Scene start = two_balls();
    start.particles = clay_around({0.5, 0.5, 0.5}, 0.06, dx);
    start.materials.resize(1);
    const auto solver = make(start);
    std::vector<std::pair<int, std::size_t>> objects{{0, start.particles.size()}};
    std::vector<std::shared_ptr<const Snapshot>> snapshots;
    std::vector<decltype(objects)> then;
    const auto place = [&] {
        return Vec3<double>{draw.in(.2, .8), draw.in(.2, .8), draw.in(.2, .8)};
    };
    for (int round = 0; round < 1000; ++round) {
        const int kind = draw.below(10);
        const std::size_t which =
            objects.empty() ? 0 : std::size_t(draw.below(int(objects.size())));
        const int object = objects.empty() ? -1 : objects[which].first;
        if (kind < 2 || objects.empty()) {
            const Particles clay = clay_around(place(), draw.in(0.02, 0.07), dx);
            const int id = solver->add(draw.below(2) ? snow(dx) : paper_clay(dx, 8), clay);
            objects.push_back({id, clay.size()});
        } else if (kind == 2 || objects.size() > 8) {
            solver->remove(object);
            objects.erase(objects.begin() + long(which));
        } else if (kind == 3) {
            solver->set_material(object, draw.below(2) ? snow(dx) : paper_clay(dx, 8));
        } else if (kind == 4) {
            try {
                solver->move(object,
                             {turn_about(draw.direction(), draw.in(0, 6)), draw.vector(0.3)});
            } catch (const std::invalid_argument&) {  // behind a wall
            }
        } else if (kind == 5) {
            solver->set_gravity(draw.vector(10));
        } else if (kind == 6) {
            Scene tools = ball(8);
            add_tools(tools);
            for (Tool<double>& tool : tools.tools) tool.blade = draw.below(4) == 0;
            if (draw.below(3) == 0) tools.rig = {}, tools.tools = {};
            solver->set_tools(tools.rig, tools.tools);
        } else if (kind == 7) {
            snapshots.push_back(solver->snapshot()), then.push_back(objects);
        } else if (kind == 8 && !snapshots.empty()) {
            const auto at = std::size_t(draw.below(int(snapshots.size())));
            solver->restore(*snapshots[at]), objects = then[at];
            if (snapshots.size() > 6) snapshots.clear(), then.clear();
        }
        if (round % 10 == 0) {
            const FrameStats stats = solver->advance(closing(0.02, 1e-3), 1e-3);
            ASSERT_EQ(stats[Count::repaired], 0) << round;
        }
        if (round % 50 != 0) continue;
        std::vector<std::size_t> found(solver->config().materials.size(), 0);
        for (const Particle<double>& p : solver->particles()) {
            ASSERT_TRUE(std::isfinite(length(p.x) + length(p.v))) << round;
            ++found.at(std::size_t(p.object));
        }
        for (const auto& [id, count] : objects) {
            ASSERT_EQ(found[std::size_t(id)], count) << round;
            found[std::size_t(id)] = 0;
        }
        for (std::size_t left : found) ASSERT_EQ(left, 0u) << round;
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, Edit,
                         ::testing::Values(Backend{"cpu", false}, Backend{"gpu", true}),
                         [](const auto& backend) { return backend.param.name; });

}  // namespace
}  // namespace knead
