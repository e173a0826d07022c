// The live session: both clocks, hands as they come, commands, failures, and what is shed.
#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <new>

#include "host/bench/ball.h"
#include "host/live/live_session.h"
#include "host/run/run.h"
#include "host/scene/presets.h"
#include "host/scene/seed.h"
#include "tests/live/live_slow.h"

namespace knead {
namespace {

const std::vector<std::string> small{"domain.cells=16", "surface.nodes=32", "step.courant=0.9"};

std::shared_ptr<const LiveScene> small_squeeze()
{
    return load_live_scene("scenes/squeeze.json", small);
}

std::vector<std::uint64_t> bits(const std::vector<Particle<double>>& particles)
{
    std::vector<std::uint64_t> all;
    for (const Particle<double>& q : particles)
        for (double x : {q.x.x, q.x.y, q.x.z, q.v.x, q.v.y, q.v.z, q.e.xx, q.e.xy})
            all.push_back(std::bit_cast<std::uint64_t>(x));
    return all;
}
std::vector<std::uint64_t> bits(LiveSession& session)
{
    std::vector<std::uint64_t> all;
    EXPECT_TRUE(session.inspect_solver([&](const Simulator& s) { all = bits(s.particles()); }));
    return all;
}

LiveOptions stepped(bool recorded)
{
    LiveOptions options;
    options.make_solver = [](const Setup& setup) { return cpu_solver(setup); };
    options.stepped = true;
    options.recorded = recorded;
    return options;
}

// By `knead run`: the same frames, from the same hands.
std::vector<std::uint64_t> run_bits(const LiveScene& live, int frames, long* projected)
{
    const std::unique_ptr<EditableSimulator> solver = cpu_solver(live.scene.setup);
    const HandSource hands(*live.recording, live.scene.hands);
    BatchRunOptions options;
    options.frames = frames, options.audit_every = 1000000;
    const RunRecord record = run_frames(live.scene, *solver, &hands, options, {});
    for (const FrameRow& row : record.rows) *projected += row.stats[Count::projected];
    return bits(solver->particles());
}

TEST(LiveStepped, GivesTheBitsOfARunFromRecordedAndFromPushedHands)
{
    const auto scene = small_squeeze();
    const int frames = 100;
    long projected = 0;
    const std::vector<std::uint64_t> wanted = run_bits(*scene, frames, &projected);
    EXPECT_GT(projected, 0) << "the hands touch the clay";
    {
        LiveSession session(scene, stepped(true));
        session.advance_to(frames / 90.0);
        EXPECT_EQ(bits(session), wanted);
        EXPECT_EQ(session.state()->frame.number, frames);
    }
    // Pushed as a tracker would, a little ahead of the time they are for.
    LiveSession session(scene, stepped(false));
    std::size_t pushed = 0;
    const auto& recording = scene->recording->frames;
    for (int frame = 1; frame <= frames; ++frame) {
        while (pushed < recording.size() && recording[pushed].time < frame / 90.0 + 0.05)
            session.push(recording[pushed++]);
        session.advance_to(frame / 90.0);
    }
    EXPECT_EQ(bits(session), wanted);
    const auto state = session.state();
    EXPECT_EQ(state->frame.number, frames);
    EXPECT_DOUBLE_EQ(state->time, frames / 90.0);
    EXPECT_EQ(state->backlog.frames, 0);
    EXPECT_EQ(state->failure, "");
    ASSERT_EQ(state->tools.size(), 2u);
    EXPECT_TRUE(state->tools[0].active);
    EXPECT_EQ(state->tools[0].primitives.size(), 26u);
    ASSERT_TRUE(state->meshes);
    EXPECT_FALSE(state->meshes->empty());
    EXPECT_FALSE(state->stages.empty());
}

TEST(LiveStepped, ASceneWithoutObjectsLivesAndTakesClay)
{
    std::vector<std::string> settings = small;
    settings.push_back("objects=[]");
    const auto scene = load_live_scene("scenes/squeeze.json", settings);
    LiveSession session(scene, stepped(true));
    session.advance_to(0.2);
    const auto state = session.state();
    EXPECT_EQ(state->failure, "");
    EXPECT_EQ(state->frame.number, 18);
    EXPECT_TRUE(!state->meshes || state->meshes->empty());
    EXPECT_TRUE(state->document->objects.empty());
    session.send(SetGravity{{0, -1, 0}});
    session.send(SetMaterial{ObjectId{1}, material_spec("clay")});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->refused, 1);
    EXPECT_NE(session.state()->refusal.find("there is no object 1"), std::string::npos);
    session.send(Reset{});
    session.advance_to(0.3);
    EXPECT_EQ(session.state()->failure, "");
    const Document other = document_of(small_squeeze()->scene);
    session.send(AddObject{*other.objects.at(0)});
    session.advance_to(0.4);
    EXPECT_EQ(session.state()->refused, 1) << session.state()->refusal;
    EXPECT_EQ(session.state()->document->objects.size(), 1u);
    EXPECT_GT(session.digest().particles, 100);
}

TEST(LiveStepped, AResetBeginsTheSameHistoryAgain)
{
    const auto scene = small_squeeze();
    LiveSession session(scene, stepped(true));
    session.advance_to(0.2);
    const std::vector<std::uint64_t> once = bits(session);
    const int history = session.state()->history;
    session.send(Reset{});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->history, history + 1);
    EXPECT_EQ(session.state()->frame.number, 0);
    session.advance_to(0.4);
    EXPECT_EQ(session.state()->frame.number, 18);
    EXPECT_DOUBLE_EQ(session.state()->time, 0.4);
    EXPECT_EQ(bits(session), once);
}

TEST(LiveStepped, PausedTimePassesWithoutFrames)
{
    LiveSession session(small_squeeze(), stepped(false));
    session.advance_to(0.1);
    session.send(Pause{true});
    session.advance_to(0.3);
    EXPECT_EQ(session.state()->frame.number, 9);
    EXPECT_TRUE(session.state()->paused);
    session.send(Advance{2});
    session.wait_for_commands();
    session.inspect_solver([](const Simulator&) {});
    session.send(Pause{false});
    session.advance_to(0.5);
    EXPECT_DOUBLE_EQ(session.state()->time, 0.5);
    EXPECT_THROW(LiveSession(nullptr, {}).advance_to(1), std::logic_error);
}

TEST(LiveStepped, EditsChangeTheClayAndRefusalsLeaveIt)
{
    LiveSession session(small_squeeze(), stepped(true));
    session.advance_to(0.05);
    const std::vector<std::uint64_t> before = bits(session);
    session.send(SetMaterial{ObjectId{8}, material_spec("snow")});
    session.send(PlaceObject{ObjectId{1}, Vec3<double>{90, 0, 0}, {}});
    session.send(SetHands{{}, {{}, "spoon"}, {}, {}});
    session.send(Open{"scenes/no_such_scene.json", {}, {}});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->refused, 4);
    EXPECT_NE(session.state()->refusal.find("no_such_scene"), std::string::npos);
    EXPECT_EQ(session.state()->failure, "");
    EXPECT_EQ(bits(session), before);
    const long meshes = session.state()->mesh_version;
    Vec3<double> centre = session.state()->document->find({1})->pose.p;
    centre.y += 0.01;
    session.send(SetMaterial{ObjectId{1}, material_spec("snow")});
    session.send(SetGravity{{0, 0, 0}});
    session.send(SetHands{{}, {{}, "knife"}, {}, {}});
    session.send(PlaceObject{ObjectId{1}, centre, {}});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->refused, 4);
    EXPECT_EQ(session.state()->refusal.empty(), false);
    EXPECT_GT(session.state()->mesh_version, meshes);
    EXPECT_EQ(session.state()->tools.at(1).held, "knife");
    session.inspect_solver([](const Simulator& s) {
        EXPECT_EQ(s.editable()->config().gravity.y, 0);
        EXPECT_EQ(s.editable()->config().materials[0].plasticity, Plasticity::clamp);
        EXPECT_NEAR(s.editable()->config().materials[0].mass,
                    400 * s.editable()->config().materials[0].volume, 1e-12);
    });
    session.advance_to(0.1);
    EXPECT_EQ(session.state()->failure, "");
}

TEST(LiveStepped, AnotherSceneTakesTheFirstOnesPlace)
{
    LiveSession session(nullptr, stepped(true));
    session.wait_for_commands();
    session.advance_to(1);
    EXPECT_FALSE(session.state()->scene);
    EXPECT_FALSE(session.inspect_solver([](const Simulator&) {}));
    session.send(Reset{});
    session.send(Open{"scenes/materials.json", {"surface.nodes=32"}, 16});
    session.wait_for_commands();
    ASSERT_TRUE(session.state()->scene);
    EXPECT_EQ(session.state()->scene->scene.name, "materials");
    session.advance_to(1 + 1.5 / 90);
    EXPECT_EQ(session.state()->frame.number, 1);
    EXPECT_EQ(session.state()->meshes->size(), 8u);
}

// In real time a session has made frames before its first, which nobody sees.
TEST(LiveReal, HasTheClayOfItsSceneThoughFramesWereRehearsed)
{
    std::atomic<double> clock = 0;
    LiveOptions real = stepped(true);
    real.stepped = false, real.manual_start = true;
    real.clock = [&] { return clock.load(); };
    for (const std::string file : {"scenes/squeeze.json", "scenes/ground.json"}) {
        const auto scene = load_live_scene(file, small);
        LiveSession session(scene, real), other(scene, stepped(true));
        session.rehearse();
        session.wait_for_commands(), other.wait_for_commands();
        EXPECT_EQ(session.state()->failure, "");
        EXPECT_EQ(session.state()->frame.number, 0);
        EXPECT_EQ(bits(session), bits(other)) << file;
        session.send(Pause{true}), session.start();
        session.send(Advance{3});
        session.wait_for_commands();
        while (session.state()->frame.number < 3) std::this_thread::yield();
        other.advance_to(3.0 / scene->scene.frame_rate);
        EXPECT_EQ(bits(session), bits(other)) << file;
    }
}

// The hand is thrown at 100 m/s; the tool moves as fast as a hand can.
TEST_F(Live, ToolsFollowNoFasterThanHandsMove)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.wait_for_commands();
    HandFrame frame;
    for (int side : {left, right}) {
        frame.hand[side] = open_hand(Side(side));
        frame.hand[side].tracked = true;
        frame.hand[side].valid.fill(true);
    }
    for (int i = 1; i <= 80; ++i) {
        // Pushed before its time comes, or the frame could begin without it: the first was due at
        // 0.
        frame.time = 0.01 * i;
        session.push(frame);
        clock = frame.time;
        once(session, [&](const LiveState& s) { return s.frame.number > i; });
    }
    for (int i = 81; i <= 120; ++i) {
        frame.time = 0.01 * i;
        for (Joint<float>& j : frame.hand[right].joints) j.p.x += 0.045f;
        session.push(frame);
        clock = frame.time;
        once(session, [&](const LiveState& s) { return s.frame.number > i; });
    }
    EXPECT_TRUE(session.state()->tools.at(1).active);
    session.inspect_solver([&](const Simulator&) {
        double most = 0;
        for (std::size_t f = 60; f < slow->motions.size(); ++f) {
            const Motion& m = slow->motions[f];
            for (std::size_t j = 0; j < m.to.size(); ++j)
                most = std::max(most, length(m.to[j].p - m.from[j].p));
            for (std::size_t j = 0; j < m.to.size(); ++j)
                EXPECT_LT(length(m.from[j].p - slow->motions[f - 1].to[j].p), 1e-12);
        }
        EXPECT_NEAR(most, 3 * 0.01, 1e-6);
    });
}

TEST_F(Live, PausedItDoesSingleFrames)
{
    options.paused = true;
    LiveSession session(scene, options);
    clock = 1;
    session.wait_for_commands();
    EXPECT_EQ(session.state()->frame.number, 0);
    session.send(Advance{3});
    once(session, [](const LiveState& s) { return s.frame.number == 3; });
    clock = 2;
    session.wait_for_commands();
    EXPECT_EQ(session.state()->frame.number, 3);
    session.send(Pause{false});
    once(session, [](const LiveState& s) { return s.frame.number > 5; });
}

TEST_F(Live, WhatEndsTheSimulationIsSaidAndAResetBeginsAnew)
{
    const char* said[] = {"the device is gone", "out of memory", "had to be reset"};
    for (int kind = 0; kind < 3; ++kind) {
        prepare = [kind](Slow& s) {
            (kind == 0 ? s.fails_at : kind == 1 ? s.memory_ends_at : s.breaks_at) = 3;
        };
        LiveSession session(scene, options);
        const auto state = once(session, [](const LiveState& s) { return !s.failure.empty(); });
        EXPECT_NE(state->failure.find(said[kind]), std::string::npos) << state->failure;
        EXPECT_EQ(state->frame.number, kind == 2 ? 3 : 2);
        prepare = {};
        session.send(Reset{});
        once(session, [](const LiveState& s) { return s.failure.empty() && s.frame.number > 4; });
    }
    options.make_solver = [](const auto&) -> std::unique_ptr<EditableSimulator> {
        throw std::bad_alloc();
    };
    LiveSession session(scene, options);
    session.wait_for_commands();
    EXPECT_NE(session.state()->failure.find("out of memory"), std::string::npos);
}

// The frame under way would take for ever on its clock.
TEST_F(Live, AResetAndTheEndDoNotWaitForAFrame)
{
    options.budget = 1e9;
    prepare = [&](Slow& s) { s.count = 2000000000; };
    LiveSession session(scene, options);
    session.send(Reset{});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->history, 2);
}

}  // namespace
}  // namespace knead
