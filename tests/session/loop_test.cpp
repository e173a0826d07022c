// The session loop: the order of a frame, who is told of it, and how it ends.
#include "host/session/loop.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>

#include "host/bench/ball.h"

namespace knead {
namespace {

// Refuses every edit.
class Unedited : public EditableSimulator {
  public:
    std::vector<int> add_each(const Material<double>&, Clays) override { refuse(); }
    void remove_each(std::span<const int>) override { refuse(); }
    void set_material(int, const Material<double>&) override { refuse(); }
    void move(int, const RigidMotion<double>&) override { refuse(); }
    void set_gravity(Vec3<double>) override { refuse(); }
    void set_walls(const WallOptions&) override { refuse(); }
    void set_contact(const BodyContact&) override { refuse(); }
    void set_tools(const Rig&, const std::vector<Tool<double>>&) override { refuse(); }
    void attach(int, const std::vector<Vec3<double>>&) override { refuse(); }
    void set_gaussians(const std::vector<Gaussian<double>>&) override { refuse(); }
    void edit_gaussians(const GaussianEdits&) override { refuse(); }
    const SimulationConfig& config() const override { return nothing; }
    std::shared_ptr<const Snapshot> snapshot() const override { refuse(); }
    void restore(const Snapshot&) override { refuse(); }
    SnapshotData held(const Snapshot&) const override { refuse(); }
    void replace(const SimulationConfig&, const ClayRows&) override { refuse(); }
    void replace(const SimulationConfig&, const InitialState&) override { refuse(); }
    ClayRows rows(const Snapshot&) const override { refuse(); }
    SavedState saved(const Snapshot&) const override { refuse(); }
    SavedState save() const override { refuse(); }
    void load(const SavedState&) override { refuse(); }

  private:
    [[noreturn]] static void refuse() { throw std::logic_error("takes no edits"); }
    SimulationConfig nothing;
};

// A solver that writes into a diary what it is asked to do, where others write, too.
class Diary : public Unedited {
  public:
    explicit Diary(std::string& to) : text(to) {}
    FrameStats advance(const Motion& motion, double duration) override
    {
        submit(motion, duration);
        return collect();
    }
    void submit(const Motion& motion, double) override
    {
        if (++submitted == fails_to_begin) throw std::runtime_error("cuda: no memory");
        text += "s" + std::to_string(submitted) + " ";
        motions.push_back(motion);
        most_under_way = std::max(most_under_way, submitted - collected);
    }
    FrameStats collect() override
    {
        if (++collected == fails_to_end) throw std::runtime_error("cuda: gone");
        text += "c" + std::to_string(collected) + " ";
        FrameStats stats;
        stats.substeps = 10 * collected;
        stats[Count::moved] = collected == still_at ? 0 : 1;
        return stats;
    }
    std::vector<Particle<double>> particles() const override
    {
        ++fetched;
        return std::vector<Particle<double>>(1);
    }
    std::vector<double> penetration() const override { return {}; }
    std::size_t memory() const override { return 1; }
    std::string name() const override { return "diary"; }

    std::string& text;
    int submitted = 0, collected = 0, most_under_way = 0;
    int fails_to_begin = 0, fails_to_end = 0, still_at = 0;
    mutable int fetched = 0;
    std::vector<Motion> motions;
};

class Loop : public testing::Test {
  protected:
    // A loop of so many frames, of 0.1 s each, whose motions and frames are in the diary.
    SessionLoop& loop(int frames, int first = 0)
    {
        SessionLoopOptions options;
        options.duration = 0.1, options.hand_rate = 8, options.frames = frames,
        options.first_frame = first;
        options.interrupted = [this] { return solver.submitted == interrupted_after; };
        options.surface.lattice = {{16, 16, 16}, 1.0f / 16};
        Material<double> clay{};
        clay.density = 1000, clay.mass = 1e-3, clay.volume = 1e-6;
        options.materials = {clay};
        made = std::make_unique<SessionLoop>(
            solver,
            [this](double from, double to) {
                text += "m ";
                sampled.push_back({from, to});
                return no_motion();
            },
            options);
        made->observe(
            [this](const FrameResult& f) { text += "w" + std::to_string(f.number) + " "; });
        return *made;
    }
    std::string text;
    Diary solver{text};
    int interrupted_after = -1;
    std::vector<std::pair<double, double>> sampled;
    std::unique_ptr<SessionLoop> made;
};

TEST_F(Loop, AFrameIsMotionSolverAndThenTheWatchersInTheirOrder)
{
    SessionLoop& l = loop(2);
    l.observe([&](const FrameResult& f) {
        EXPECT_EQ(f.stats.substeps, 10 * f.number);
        EXPECT_DOUBLE_EQ(f.simulated, 0.1 * f.number);
        EXPECT_DOUBLE_EQ(f.hand_time, f.number / 8.0);
        text += "x ";
    });
    EXPECT_TRUE(l.step());
    EXPECT_EQ(text, "m s1 c1 w1 x ");
    l.run();
    EXPECT_EQ(text, "m s1 c1 w1 x m s2 c2 w2 x ");
    EXPECT_FALSE(l.step());
    EXPECT_EQ(l.end(), End::complete);
    EXPECT_EQ(l.last().number, 2);
    EXPECT_FALSE(l.failure());
}

TEST_F(Loop, TheNextFrameIsHandedOverBeforeTheLastIsWaitedFor)
{
    SessionLoop& l = loop(5);
    l.observe([&](const FrameResult& f) {
        if (f.number == 1) l.submit_ahead();
    });
    l.run();
    EXPECT_EQ(text, "m s1 c1 w1 m s2 m s3 c2 w2 m s4 c3 w3 m s5 c4 w4 c5 w5 ");
    EXPECT_EQ(solver.most_under_way, 2);
}

TEST_F(Loop, MotionIsAskedForWithoutAGap)
{
    for (const bool ahead : {false, true}) {
        sampled.clear();
        SessionLoop& l = loop(6, 3);
        if (ahead) l.submit_ahead();
        l.run();
        ASSERT_EQ(sampled.size(), 6u);
        EXPECT_EQ(sampled.front().first, 3 / 8.0);
        EXPECT_EQ(sampled.back().second, 9 / 8.0);
        for (std::size_t f = 1; f < sampled.size(); ++f)
            EXPECT_EQ(sampled[f].first, sampled[f - 1].second);
    }
}

TEST_F(Loop, AWatcherMayStopItAndFramesUnderWayAreStillWatched)
{
    for (const bool ahead : {false, true}) {
        text.clear(), solver.submitted = solver.collected = 0;
        SessionLoop& l = loop(-1);
        if (ahead) l.submit_ahead();
        l.observe([&](const FrameResult& f) {
            if (f.number == 3) l.stop(End::numerical_failure), l.stop(End::time_limit);
        });
        l.run();
        EXPECT_EQ(l.end(), End::numerical_failure);  // the first reason
        EXPECT_EQ(l.last().number, ahead ? 4 : 3);
        EXPECT_EQ(solver.submitted, solver.collected);
    }
}

TEST_F(Loop, EditsAreMadeOnceBetweenFramesWithNoneUnderWay)
{
    for (const bool ahead : {false, true}) {
        text.clear(), solver.submitted = solver.collected = 0;
        SessionLoop& l = loop(4);
        if (ahead) l.submit_ahead();
        l.observe([&](const FrameResult& f) {
            if (f.number != 1) return;
            for (const char* name : {"e ", "f "})
                l.edit([&, name](EditableSimulator& edited) {
                    EXPECT_EQ(&edited, &solver);
                    text += name;
                });
        });
        l.run();
        EXPECT_EQ(text, ahead ? "m s1 m s2 c1 w1 c2 w2 e f m s3 m s4 c3 w3 c4 w4 "
                              : "m s1 c1 w1 e f m s2 c2 w2 m s3 c3 w3 m s4 c4 w4 ");
    }
}

TEST_F(Loop, WhatTheSolverThrowsLeavesTheFramesBeforeWatched)
{
    const auto what = [](const SessionLoop& l) -> std::string {
        try {
            if (l.failure()) std::rethrow_exception(l.failure());
        } catch (const std::runtime_error& e) {
            return e.what();
        }
        return "";
    };
    for (const bool ahead : {false, true})
        for (const bool at_the_end : {false, true}) {
            text.clear(), solver.submitted = solver.collected = 0;
            (at_the_end ? solver.fails_to_end : solver.fails_to_begin) = 3;
            (at_the_end ? solver.fails_to_begin : solver.fails_to_end) = 0;
            SessionLoop& l = loop(9);
            if (ahead) l.submit_ahead();
            l.run();
            EXPECT_EQ(l.last().number, 2);
            EXPECT_NE(text.find("w2"), text.npos);
            EXPECT_EQ(text.find("w3"), text.npos);
            EXPECT_EQ(l.end(), End::device);
            EXPECT_EQ(what(l), at_the_end ? "cuda: gone" : "cuda: no memory");
            EXPECT_FALSE(l.step());
        }
}

TEST_F(Loop, AnInterruptIsHeardBeforeTheNextFrame)
{
    interrupted_after = 2;
    SessionLoop& l = loop(9);
    l.run();
    EXPECT_EQ(l.end(), End::interrupted);
    EXPECT_EQ(l.last().number, 2);
    EXPECT_EQ(text, "m s1 c1 w1 m s2 c2 w2 ");
}

TEST_F(Loop, NoFrameBeginsAfterTheTimeLimit)
{
    SessionLoopOptions options;
    options.hand_rate = 1, options.time_limit = 1e-12;
    SessionLoop l(solver, recorded_motion(nullptr, {}), options);
    l.run();
    EXPECT_EQ(l.end(), End::time_limit);
    EXPECT_LE(solver.submitted, 1);
}

TEST_F(Loop, TheStateIsFetchedOnceAFrameAndNotWhileOneIsUnderWay)
{
    SessionLoop& l = loop(4);
    l.observe([&](const FrameResult& f) {
        if (f.number < 3) {
            EXPECT_EQ(l.particles(), l.particles());
            l.meshes();
            EXPECT_EQ(solver.fetched, f.number);
        }
        if (f.number == 2) l.submit_ahead();
        if (f.number != 3) return;
        EXPECT_THROW(l.particles(), std::logic_error);
        EXPECT_THROW(l.meshes(), std::logic_error);
    });
    l.run();
    EXPECT_EQ(l.last().number, 4);
    EXPECT_EQ(l.particles()->size(), 1u);
}

TEST_F(Loop, MeshesStandWhileNoClayMovesAndNothingIsEdited)
{
    solver.still_at = 2;
    SessionLoop& l = loop(4);
    EXPECT_FALSE(l.meshes_current());
    std::vector<bool> stood;
    std::vector<Meshes> seen{l.meshes()};
    l.observe([&](const FrameResult& f) {
        stood.push_back(l.meshes_current());
        seen.push_back(l.meshes());
        if (f.number == 2) l.edit([&](EditableSimulator&) { solver.still_at = 3; });
    });
    l.run();
    EXPECT_EQ(stood, (std::vector<bool>{false, true, false, false}));
    EXPECT_EQ(seen[1], seen[2]);
    EXPECT_NE(seen[2], seen[3]);
    EXPECT_GT(l.last().times.surface, 0);
}

// What is left of a ball between closing tools, all of it, to the bit; the first number is how
// often they touched. `waits` counts those of the host while frames were handed over, from the
// fifth on.
std::vector<std::uint64_t> squeezed(const Setup& setup, EditableSimulator& solver, bool ahead,
                                    long& waits)
{
    SessionLoopOptions options;
    options.duration = 2e-3, options.hand_rate = 500, options.frames = 8, options.first_frame = 10;
    options.materials = setup.materials;
    options.surface.lattice = {setup.lattice.size, float(setup.lattice.dx)};
    SessionLoop l(
        solver, [](double from, double to) { return closing(from, to - from); }, options);
    l.launch_surfaces();
    if (ahead) l.submit_ahead();
    std::vector<std::uint64_t> all{0};
    l.observe([&](const FrameResult& f) {
        all[0] += std::uint64_t(f.stats[Count::projected]);
        if (f.number > 4) waits += f.waits;
    });
    l.run();
    for (const Particle<double>& q : *l.particles())
        for (double x : {q.x.x, q.x.y, q.x.z, q.v.x, q.v.y, q.v.z, q.e.xx, q.e.xy})
            all.push_back(std::bit_cast<std::uint64_t>(x));
    return all;
}

void expect_same_bits_ahead(
    const std::function<std::unique_ptr<EditableSimulator>(const Setup&)>& make)
{
    Setup setup = ball(16);
    add_tools(setup);
    setup.deterministic = true;
    long waits = 0, waits_ahead = 0;
    const auto one_by_one = squeezed(setup, *make(setup), false, waits);
    EXPECT_GT(one_by_one[0], 0u);
    EXPECT_EQ(one_by_one, squeezed(setup, *make(setup), true, waits_ahead));
    const char* graph = std::getenv("KNEAD_GRAPH");  // "0": substep by substep, each of them waits
    EXPECT_TRUE(waits_ahead == 0 || (graph && std::string(graph) == "0")) << waits_ahead;
}

TEST(LoopOnTheCpu, HandedOverAheadGivesTheSameBits) { expect_same_bits_ahead(cpu_solver); }

TEST(LoopOnTheGpu, HandedOverAheadGivesTheSameBitsAndNobodyWaits)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    expect_same_bits_ahead([](const auto& setup) { return gpu_solver(setup, 0); });
}

TEST(LoopOnTheGpu, KeptSurfacesComeWithTheirFramesAndCostOneWait)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    knead::Setup setup = ball(24);
    add_tools(setup);
    const auto solver = gpu_solver(setup, 0);
    SessionLoopOptions options;
    options.duration = 2e-3, options.hand_rate = 500, options.frames = 6, options.first_frame = 10;
    options.materials = setup.materials;
    options.surface.lattice = {setup.lattice.size, float(setup.lattice.dx)};
    SessionLoop l(
        *solver, [](double from, double to) { return closing(from, to - from); }, options);
    l.launch_surfaces(true);
    std::vector<std::shared_ptr<const DeviceMesh>> kept;
    std::vector<Meshes> fetched;
    l.observe([&](const FrameResult& f) {
        const long before = gpu_waits();
        kept.push_back(l.device_mesh());
        EXPECT_EQ(gpu_waits() - before, 1) << f.number;
        if (f.number == 3) l.edit([](EditableSimulator& s) { s.set_gravity({0, -5, 0}); });
        fetched.push_back(l.meshes());
    });
    l.run();
    ASSERT_EQ(kept.size(), 6u);
    for (std::size_t frame = 0; frame < kept.size(); ++frame) {
        const std::vector<Mesh> a = kept[frame]->meshes(), &b = *fetched[frame];
        ASSERT_EQ(a.size(), b.size());
        ASSERT_EQ(a.at(0).vertices.size(), b.at(0).vertices.size());
        for (std::size_t i = 0; i < a[0].vertices.size(); ++i)
            ASSERT_EQ(length(a[0].vertices[i] - b[0].vertices[i]), 0) << frame << ": " << i;
    }
}

}  // namespace
}  // namespace knead
