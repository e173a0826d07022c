// Categories changed between frames: the clay keeps its bits, and the surfaces are those of a
// simulator made with the new categories.
#include <gtest/gtest.h>

#include <array>
#include <tuple>

#include "host/bench/ball.h"
#include "host/session/loop.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Given = knead::Setup;             // the name is a member of testing::Test
using Categories = std::array<int, 2>;  // by object
constexpr double period = 1.0 / 90;
constexpr int cells = 24;

class Categorised : public OnBothDevices {};
INSTANTIATE_TEST_SUITE_P(Session, Categorised, testing::Values(false, true), device_of);

// The ball between two tools; its upper half is another object.
Given two_halves(Categories categories)
{
    Given s = ball(cells);
    s.deterministic = true, s.threads = 2;
    s.materials.push_back(s.materials[0]);
    for (std::size_t k = 0; k < 2; ++k) s.materials[k].category = categories[k];
    for (Particle<double>& p : s.particles) p.object = p.x.y > 0.5;
    add_tools(s);
    return s;
}

void set_categories(EditableSimulator& solver, Categories to)
{
    for (int object = 0; object < 2; ++object) {
        Material<double> m = solver.config().materials[std::size_t(object)];
        if (m.category == to[std::size_t(object)]) continue;
        m.category = to[std::size_t(object)];
        solver.set_material(object, m);
    }
}

// New ones, one for both, none, exchanged, and the first again.
constexpr Categories category_steps[] = {{1, 2}, {1, 7}, {7, 7}, {2, 2}, {2, 1}, {0, 255}, {1, 2}};

TEST_P(Categorised, ClayKeepsItsBits)
{
    const auto edited = make(two_halves(category_steps[0])),
               other = make(two_halves(category_steps[0]));
    int number = 0;
    for (const Categories categories : category_steps) {
        const long version = edited->version();
        set_categories(*edited, categories);
        if (number > 0) {
            EXPECT_NE(edited->version(), version);
        }
        for (std::size_t k = 0; k < 2; ++k)
            EXPECT_EQ(edited->config().materials[k].category, categories[k]);
        EXPECT_TRUE(same_bits(edited->particles(), other->particles()));
        const Motion motion = closing(number++ * period, period);
        EXPECT_EQ(edited->advance(motion, period).substeps,
                  other->advance(motion, period).substeps);
        EXPECT_TRUE(same_bits(edited->particles(), other->particles())) << number;
    }
}

TEST_P(Categorised, OfAnUnknownObjectIsRefused)
{
    const auto solver = make(two_halves(category_steps[0]));
    Material<double> m = solver->config().materials[1];
    m.category = 9;
    for (const int object : {-1, 2, 1000})
        EXPECT_THROW(solver->set_material(object, m), std::invalid_argument);
    solver->remove(1);
    EXPECT_THROW(solver->set_material(1, m), std::invalid_argument);
}

TEST_P(Categorised, ComesBackWithSnapshotsAndStates)
{
    const auto solver = make(two_halves(category_steps[0]));
    const auto before = solver->snapshot();
    set_categories(*solver, {5, 6});
    const SavedState saved = solver->save();
    EXPECT_EQ(saved.config.materials[0].category, 5);
    solver->restore(*before);
    EXPECT_EQ(solver->config().materials[0].category, 1);
    solver->load(saved);
    EXPECT_EQ(solver->config().materials[1].category, 6);
    solver->advance(closing(0, period), period);
}

TEST_P(Categorised, SleepingClaySleepsOn)
{
    Given s = two_halves(category_steps[0]);
    s.gravity = {};
    s.rest = {RestMode::sleep, 1e-2, 3, 1.0, 0.1};
    s.rig = {}, s.tools = {};
    const auto solver = make(s);
    for (int f = 0; f < 10; ++f) solver->advance({}, period);
    set_categories(*solver, {3, 4});
    EXPECT_EQ(solver->advance({}, period)[Count::moved], 0);
    Material<double> heavy = solver->config().materials[0];
    heavy.density *= 2, heavy.category = 1;
    solver->set_material(0, heavy);
    EXPECT_EQ(solver->config().materials[0].category, 1);
    EXPECT_GT(solver->advance({}, period)[Count::moved], 0);
}

SessionLoopOptions options_of(const Given& s)
{
    SessionLoopOptions options;
    options.duration = period, options.hand_rate = 90;
    options.materials = s.materials;
    options.surface.lattice = {s.lattice.size, float(s.lattice.dx)};
    return options;
}
Motion motion_of(double from, double to) { return closing(from, to - from); }

enum class Way { queued, reported, silent };

class CategorisedSurfaces : public testing::TestWithParam<std::tuple<bool, Way, bool>> {
  protected:
    void SetUp() override
    {
        if (on_device() && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    static bool on_device() { return std::get<0>(GetParam()); }
    static Way way() { return std::get<1>(GetParam()); }
    static bool queued_surfaces() { return std::get<2>(GetParam()); }
    static std::unique_ptr<EditableSimulator> make(const Given& s)
    {
        return on_device() ? gpu_solver(s, 0) : cpu_solver(s);
    }
    static void edit(SessionLoop& loop, EditableSimulator& solver, Categories to)
    {
        if (way() == Way::queued) {
            loop.edit([to](EditableSimulator& s) { set_categories(s, to); });
            return loop.make_edits();
        }
        set_categories(solver, to);
        if (way() == Way::reported) loop.clay_edited();
    }
};
std::string name_of(const testing::TestParamInfo<std::tuple<bool, Way, bool>>& at)
{
    const auto [on_device, way, ahead] = at.param;
    const std::string how = way == Way::queued     ? "queued"
                            : way == Way::reported ? "reported"
                                                   : "silent";
    return (on_device ? "cuda_" : "cpu_") + how + (ahead ? "_ahead" : "");
}
INSTANTIATE_TEST_SUITE_P(Session, CategorisedSurfaces,
                         testing::Combine(testing::Values(false, true),
                                          testing::Values(Way::queued, Way::reported, Way::silent),
                                          testing::Values(false, true)),
                         name_of);

TEST_P(CategorisedSurfaces, AreThoseOfASimulatorMadeWithTheCategories)
{
    const Given first = two_halves(category_steps[0]);
    const auto solver = make(first);
    SessionLoop loop(*solver, motion_of, options_of(first));
    if (queued_surfaces()) loop.launch_surfaces(true);
    int frames = 0;
    for (const Categories categories : category_steps) {
        ASSERT_TRUE(loop.step());
        ++frames;
        loop.meshes(), loop.device_mesh();
        EXPECT_TRUE(loop.meshes_current());
        edit(loop, *solver, categories);
        for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(loop.materials()[k].category, categories[k]);
        EXPECT_EQ(loop.meshes_current(), way() == Way::silent && frames == 1);

        const Given made = two_halves(categories);
        const auto other = make(made);
        SessionLoop fresh(*other, motion_of, options_of(made));
        for (int f = 0; f < frames; ++f) ASSERT_TRUE(fresh.step());
        const std::vector<Mesh> wanted = *fresh.meshes();
        EXPECT_EQ(wanted.size(), categories[0] == categories[1] ? 1u : 2u);
        EXPECT_TRUE(same_bits(*loop.meshes(), wanted)) << frames;
        const auto on = loop.device_mesh();
        ASSERT_EQ(on != nullptr, on_device());
        if (on) {
            EXPECT_TRUE(same_bits(on->meshes(), wanted)) << frames;
        }
        EXPECT_TRUE(loop.meshes_current());
    }
}

// Edits that nobody reports: what is added is seen, what is removed is gone.
TEST_P(CategorisedSurfaces, FollowClayThatIsAddedAndRemoved)
{
    const Given first = two_halves(category_steps[0]);
    const auto solver = make(first);
    SessionLoop loop(*solver, motion_of, options_of(first));
    if (queued_surfaces()) loop.launch_surfaces(true);
    const auto categories = [&] {
        std::vector<int> all;
        for (const Mesh& mesh : *loop.meshes()) all.push_back(mesh.category);
        if (const auto on = loop.device_mesh()) {
            std::vector<int> same;
            for (const Mesh& mesh : on->meshes()) same.push_back(mesh.category);
            EXPECT_EQ(same, all);
        }
        return all;
    };
    ASSERT_TRUE(loop.step());
    EXPECT_EQ(categories(), (std::vector<int>{1, 2}));
    solver->remove(0);
    EXPECT_EQ(categories(), (std::vector<int>{2}));
    Material<double> added = first.materials[0];
    added.category = 4;
    std::vector<Particle<double>> lower;
    for (const Particle<double>& p : first.particles)
        if (p.object == 0) lower.push_back(p);
    solver->add(added, lower);
    ASSERT_TRUE(loop.step());
    EXPECT_EQ(categories(), (std::vector<int>{2, 4}));
    solver->remove_each(std::vector<int>{1, 2});
    EXPECT_TRUE(categories().empty());
    ASSERT_TRUE(loop.step());
    EXPECT_TRUE(categories().empty());
    solver->add(first.materials[1], lower);
    EXPECT_EQ(categories(), (std::vector<int>{2}));
}

}  // namespace
}  // namespace knead
