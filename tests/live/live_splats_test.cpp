// Splats of a live session: split, added, taken up and laid down as by `knead run`.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "host/assets/procedural_object.h"
#include "host/live/simulation_run.h"
#include "host/paging/scene_splats.h"
#include "host/run/run.h"
#include "host/session/backend.h"
#include "tests/folder.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

// What a run and a live session must agree on.
struct Reached {
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians;
    SplatCloud splats;
    std::size_t most_particles = 0;
    long split = 0, taken = 0, frozen = 0;
};

Reached run_to(const LiveScene& live, int frames)
{
    Reached reached;
    const std::unique_ptr<EditableSimulator> solver = cpu_solver(live.scene.setup);
    const HandSource hands(*live.recording, live.scene.hands);
    SceneSplats splats(live.scene, live.splats);
    BatchRunOptions options;
    options.frames = frames, options.audit_every = 1000000;
    RunObserver watch;
    watch.upkeep = [&](const FrameResult& frame) {
        const PagingReport report = splats.after(frame.number, frame.motion, *solver);
        reached.split += report.splats_split;
        reached.taken += report.cubes_activated, reached.frozen += report.cubes_frozen;
        reached.most_particles = std::max(reached.most_particles, solver->particles().size());
        return report;
    };
    run_frames(live.scene, *solver, &hands, options, watch);
    splats.refresh();
    reached.particles = solver->particles(), reached.gaussians = solver->gaussians();
    reached.splats = splats.drawn();
    return reached;
}

LiveOptions live_options(bool stepped, Device device = {DeviceKind::cpu, 0})
{
    LiveOptions options;
    options.make_solver = [device](const Setup& setup) { return make_solver(setup, device); };
    options.stepped = stepped;
    return options;
}

void expect_equal(LiveSession& session, const Reached& wanted)
{
    const auto state = session.state();
    EXPECT_EQ(state->failure, "");
    session.inspect_solver([&](const Simulator& solver) {
        EXPECT_TRUE(same_bits(solver.particles(), wanted.particles));
        EXPECT_TRUE(same_bits(solver.gaussians(), wanted.gaussians));
    });
    ASSERT_TRUE(state->splats && state->gaussians);
    EXPECT_TRUE(same_bits(*state->gaussians, wanted.gaussians)) << "as it was published";
    EXPECT_TRUE(same_bits(state->splats->centre, wanted.splats.centre));
    EXPECT_TRUE(same_bits(state->splats->scale, wanted.splats.scale));
    EXPECT_TRUE(same_bits(state->splats->sh, wanted.splats.sh));
    EXPECT_EQ(state->splats->opacity, wanted.splats.opacity);
}

std::shared_ptr<const LiveScene> ground()
{
    return load_live_scene("scenes/ground.json", {"domain.cells=32", "surface.nodes=32"});
}

TEST(LiveSplats, StandingGroundBecomesClayAtTheHandsAsInARun)
{
    const auto scene = ground();
    ASSERT_TRUE(scene->scene.setup.particles.empty());
    const int frames = 60;
    const Reached wanted = run_to(*scene, frames);
    EXPECT_GT(wanted.taken, 0);
    EXPECT_GT(wanted.most_particles, 100u);
    LiveSession session(scene, live_options(true));
    session.wait_for_commands();
    const auto before = session.state();
    ASSERT_TRUE(before->splats);
    EXPECT_TRUE(before->gaussians->empty()) << "all stands still";
    EXPECT_EQ(before->splats->count(), scene->splats[0].cloud.count());
    session.advance_to(frames / scene->scene.frame_rate);
    EXPECT_GT(session.state()->splat_version, before->splat_version);
    expect_equal(session, wanted);
    session.send(Reset{});
    session.wait_for_commands();
    EXPECT_TRUE(same_bits(session.state()->splats->centre, before->splats->centre));
}

// A pot that is thrown onto the floor is drawn out there.
class ThrownPot : public InFolder {};

TEST_F(ThrownPot, IsSplitAndRefilledAsInARun)
{
    write_splats(path("pot.ply"), glazed_pot(4000));
    std::ofstream(path("scene.json")) << R"({"schema": "knead.scene/1", "frame_rate": 30,
        "domain": {"edge": 0.6, "cells": 24}, "surface": {"nodes": 24},
        "objects": [{"shape": "splats", "file": "pot.ply", "size": 0.2,
                     "centre": [0.3, 0.2, 0.3], "velocity": [0, -5, 0], "material": "soft-clay"}],
        "splats": {"every": 3, "split": {"limit": 1.2, "budget": 50},
                   "refill": {"see_through": 0.05, "budget": 20}},
        "hands": {"recording": "squeeze", "zoom": 0.5}})";
    const auto scene = load_live_scene(path("scene.json"));
    const int frames = 12;
    const Reached wanted = run_to(*scene, frames);
    EXPECT_GT(wanted.split, 50);
    LiveSession session(scene, live_options(true));
    session.advance_to(frames / scene->scene.frame_rate);
    expect_equal(session, wanted);
    EXPECT_GT(session.state()->splats->count(), scene->scene.setup.gaussians.size());
}

// Before any clay came, and when some is there already.
TEST(LiveSplats, LocalClayIsOfTheMaterialThatWasChosen)
{
    const auto scene = ground();
    MaterialSpec stated_soft = scene->scene.objects[0].stated;
    stated_soft.yield *= 0.5;
    const Material<double> soft = made(stated_soft);
    for (const int when : {0, 30}) {
        LiveSession session(scene, live_options(true));
        session.advance_to(when / scene->scene.frame_rate);
        session.send(SetMaterial{ObjectId{1}, stated_soft});
        const auto of_clay = [&] {
            std::size_t clay = 0;
            session.inspect_solver([&](const Simulator& solver) {
                for (const Material<double>& m : solver.editable()->config().materials) {
                    if (!(m.volume > 0)) continue;
                    EXPECT_EQ(m.yield, soft.yield);
                    ++clay;
                }
            });
            return clay;
        };
        EXPECT_EQ(of_clay() > 1, when > 0) << "besides the floor's own";
        session.advance_to((when + 30) / scene->scene.frame_rate);
        EXPECT_GT(of_clay(), 10u);
        EXPECT_EQ(session.state()->refused, 0) << session.state()->refusal;
    }
}

// Whatever the clock of the wall lets through: clay is there where the rod is.
TEST(LiveSplats, InRealTimeFramesAreCutAndLocalClayStillComes)
{
    const auto scene = ground();
    LiveOptions options = live_options(false);
    std::atomic<double> clock = 0;
    options.clock = [&] { return clock.load(); };
    options.budget = 1e-6;  // of this clock, which moves while a frame is computed: all are cut
    LiveSession session(scene, options);
    std::shared_ptr<const LiveState> state;
    bool clay = false;
    for (int i = 0; i < 4000 && !clay; ++i) {
        clock = clock + 0.5 / scene->scene.frame_rate;
        session.wait_for_commands();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        state = session.state();
        clay = state->gaussians && !state->gaussians->empty();
    }
    EXPECT_TRUE(clay);
    EXPECT_EQ(state->failure, "");
    EXPECT_EQ(state->splats->count() >= state->gaussians->size(), true);
}

// In real time hands are rehearsed before a session begins; nothing of that is left.
TEST(LiveSplats, WhatWasRehearsedHasGoneBackToTheBit)
{
    const auto scene = ground();
    LiveOptions options = live_options(false);
    options.paused = true;
    LiveSession session(scene, options), stepped(scene, live_options(true));
    session.wait_for_commands(), stepped.wait_for_commands();
    const auto after = session.state(), wanted = stepped.state();
    ASSERT_EQ(after->failure + wanted->failure, "");
    EXPECT_TRUE(same_bits(after->splats->centre, wanted->splats->centre));
    EXPECT_TRUE(same_bits(after->splats->scale, wanted->splats->scale));
    EXPECT_TRUE(same_bits(after->splats->rotation, wanted->splats->rotation));
    EXPECT_GT(after->splat_version, wanted->splat_version) << "there was a rehearsal";
    EXPECT_TRUE(!after->gaussians || after->gaussians->empty());
    std::size_t left = 1;
    EXPECT_TRUE(session.inspect_solver([&](const Simulator& s) { left = s.particles().size(); }));
    EXPECT_EQ(left, 0u);
}

// In the frame in which clay begins to go back by a thread of its own, splats are still split: what
// is shown of it is looked at before the thread has it.
TEST(LiveSplats, InRealTimeClayGoesBackWhileSplatsAreSplit)
{
    const auto scene = load_live_scene("scenes/ground.json",
                                       {"domain.cells=24", "surface.nodes=24", "splats.every=1",
                                        "splats.split.limit=1.1", "splats.split.budget=1"});
    const LiveOptions options = live_options(false);
    double clock = 0;
    IdSource ids;
    History past;
    SimulationRun run(
        scene, options, ids, past, {}, 0, [&] { return clock; },
        [](const FrameProgress&) { return false; });
    run.rehearse();
    std::size_t most = 0;
    int frame = 0;
    const auto next = [&] {
        clock += 1 / scene->scene.frame_rate, ++frame;
        ASSERT_EQ(run.frame(false), "") << frame;
        most = std::max(most, run.of().particle_count());
        // When hands have gone, every frame finds a plan ready.
        if (frame >= 60) std::this_thread::sleep_for(std::chrono::milliseconds(30));
    };
    while (frame < 60) ASSERT_NO_FATAL_FAILURE(next());
    EXPECT_GT(most, 100u);
    run.play(false);  // and no hand is tracked
    LiveState state;
    while (frame < 300 && run.of().particle_count() > 0) ASSERT_NO_FATAL_FAILURE(next());
    run.publish(state);
    EXPECT_EQ(run.of().particle_count(), 0u);
    EXPECT_GT(state.splats->count(), scene->splats[0].cloud.count()) << "none was split";
}

TEST(LiveSplats, ASolverWithoutEditsSaysThatItHasNoLocalClay)
{
    const auto scene = ground();
    LiveSession session(scene, live_options(true, {DeviceKind::cpu_double, 0}));
    session.wait_for_commands();
    EXPECT_NE(session.state()->failure.find("no local clay"), std::string::npos)
        << session.state()->failure;
}

}  // namespace
}  // namespace knead
