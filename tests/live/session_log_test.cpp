// A live session in real time is computed again from its log to the bit: with frames that the clock
// cut, paged clay, splats that are split, carried clay, and commands in bursts.
#include "host/live/session_log.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "host/live/live_session.h"
#include "host/scene/presets.h"
#include "tests/sanitized.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

std::unique_ptr<Simulator> on_cpu(const Setup& setup) { return cpu_solver(setup); }

// A clock that goes on by `tick` [s] each time it is read: a frame of many substeps is cut.
LiveOptions ticking(std::shared_ptr<std::atomic<long>> reads, double tick)
{
    LiveOptions options;
    options.make_solver = on_cpu;
    options.logs = true;
    options.clock = [reads, tick] { return tick * double(++*reads); };
    return options;
}

void wait_for_frames(LiveSession& session, int more)
{
    const int until = session.state()->frame.number + more;
    for (int waited = 0; session.state()->frame.number < until && waited < 60000; ++waited) {
        if (!session.state()->failure.empty()) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_GE(session.state()->frame.number, until) << session.state()->failure;
}

void expect_replayed(LiveSession& session)
{
    session.send(Pause{true});
    session.wait_for_commands();
    std::vector<Particle<double>> live;
    session.inspect_solver([&](const Simulator& s) { live = s.particles(); });
    const SessionLog log = session.session_log();
    EXPECT_TRUE(same_bits(replayed(log, on_cpu), live));
    // The cuts matter: without one of them the clay is other clay.
    SessionLog other = log;
    for (SessionEvent& event : other.events)
        if (FrameEvent* frame = std::get_if<FrameEvent>(&event); frame && frame->cut_after > 0) {
            frame->cut_after = 0;
            EXPECT_FALSE(same_bits(replayed(other, on_cpu), live));
            return;
        }
}

int cuts_in(const SessionLog& log)
{
    int cuts = 0;
    for (const SessionEvent& event : log.events)
        if (const FrameEvent* frame = std::get_if<FrameEvent>(&event)) cuts += frame->cut_after > 0;
    return cuts;
}

TEST(SessionLog, OfCutFramesAndBurstsOfCommandsIsComputedAgainToTheBit)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=16", "surface.nodes=16", "step.courant=0.3"});
    const auto reads = std::make_shared<std::atomic<long>>(0);
    LiveOptions options = ticking(reads, 1e-3);
    options.recorded = false;
    LiveSession session(scene, options);
    const auto hands_at = [&](double height, double closed) {
        HandFrame frame;
        frame.time = session.now();
        for (const Side side : {left, right}) {
            frame.hand[side] = open_hand(side);
            frame.hand[side].tracked = true, frame.hand[side].valid.fill(true);
            for (Joint<float>& j : frame.hand[side].joints)
                j.p = j.p + Vec3<float>{float(side == left ? -closed : closed), float(height), 0};
        }
        session.push(frame);
    };
    for (int burst = 0; burst < 6; ++burst) {
        for (int k = 0; k < 20; ++k) hands_at(0.05 - 0.01 * burst, 0.1 - 0.001 * k);
        switch (burst) {
            case 0:
                for (int k = 0; k < 5; ++k) session.send(SetGravity{{0, -9.81 + k, 0}});
                break;
            case 1:
                session.send(SetMaterial{ObjectId{1}, material_spec("snow")});
                session.send(Carry{{ObjectId{1}}, right, true});
                break;
            case 2:
                session.send(Carry{{ObjectId{1}}, right, false});
                session.send(SetHands{{{}, "rod"}, {}, {}, {}});
                break;
            case 3: {
                SceneObject added;
                added.name = "added";
                added.pose.p = {0.25, 0.7, 0.3};
                added.material = material_spec("clay");
                added.source.size = {0.2, 0.2, 0.2};
                session.send(AddObject{added});
                break;
            }
            case 4:
                session.send(RemoveObjects{{ObjectRef("nobody")}});  // refused
                session.send(PlaceObject{ObjectRef("added"), Vec3<double>{0.3, 0.7, 0.3}, {}});
                break;
            default:
                session.send(SetGravity{{0, 0, 0}}, Origin::window, 7);
                session.send(SetGravity{{0, 1, 0}}, Origin::window, 7);
                break;
        }
        wait_for_frames(session, sanitized ? 2 : 6);
    }
    session.wait_for_commands();
    EXPECT_EQ(session.state()->refused, 1) << session.state()->refusal;
    EXPECT_EQ(session.state()->document->objects.size(), 2u);
    EXPECT_GT(cuts_in(session.session_log()), 3);
    expect_replayed(session);
}

// Copies, other sizes, merges and parts are made from the clay of their frame.
TEST(SessionLog, OfReshapedObjectsIsComputedAgainToTheBit)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=16", "surface.nodes=16", "step.courant=0.3"});
    const auto reads = std::make_shared<std::atomic<long>>(0);
    LiveOptions options = ticking(reads, 1e-3);
    options.recorded = false;
    LiveSession session(scene, options);
    const Command all[] = {
        SetGravity{{0.3, -1, 0}},
        ScaleObjects{{ObjectId{1}}, 0.7},
        CopyObjects{{ObjectId{1}}, {0, 0.4, 0}, {"copy"}, {}},
        SplitObject{ObjectId{1}, SplitPlane{{0.5, 0.3, 0.5}, {1, 0.1, 0}}, {}, {"l", "r"}, {}},
        ScaleObjects{{ObjectRef("copy")}, 0.8},
        MergeObjects{{ObjectRef("copy"), ObjectRef("l")}, "both"},
        Undo{},
        Undo{},
        Redo{},
        Redo{},
        MoveObjects{{ObjectRef("both"), ObjectRef("r")},
                    Vec3<double>{0.02, 0.01, 0},
                    Quat<double>{0.8, 0, 0.6, 0},
                    {}},
        SplitObject{ObjectRef("both"), {}, true, {}, {}},
        PlaceObject{ObjectRef("both"), Vec3<double>{0.5, 0.7, 0.5}, {}},
        SourceBegin{"rope",
                    SectionKind::star,
                    0.08,
                    {},
                    {},
                    {},
                    {0.2, 0.8, 0.2},
                    Vec3<double>{1, 0, 0},
                    {}},
        SourceMove{ObjectRef("rope"), {0.4, 0.8, 0.2}, {}},
        SourceMove{ObjectRef("rope"), {0.5, 0.8, 0.3}, Vec3<double>{1, 0, 1}},
        SourceEnd{ObjectRef("rope")},
        Undo{},
        Redo{}};
    for (const Command& command : all) {
        session.send(command);
        wait_for_frames(session, sanitized ? 1 : 3);
        session.wait_for_commands();
        EXPECT_EQ(session.state()->refused, 0) << session.state()->refusal;
    }
    expect_replayed(session);
}

TEST(SessionLog, OfPagedClayIsComputedAgainToTheBit)
{
    const auto scene =
        load_live_scene("scenes/ground.json", {"domain.cells=32", "surface.nodes=32"});
    const auto reads = std::make_shared<std::atomic<long>>(0);
    LiveSession session(scene, ticking(reads, 2e-4));
    wait_for_frames(session, sanitized ? 20 : 120);
    session.send(SetGravity{{1, -9, 0}});
    wait_for_frames(session, sanitized ? 10 : 60);
    expect_replayed(session);
}

// Undo returns to what the codec of the session has rounded.
TEST(SessionLog, OfRoundedStepsIsComputedAgainByTheirCodec)
{
    LiveOptions options;
    options.make_solver = on_cpu;
    options.stepped = options.logs = true;
    options.codec = Codec::quantised;
    LiveSession session(load_live_scene("scenes/squeeze.json", {"domain.cells=16"}), options);
    session.advance_to(0.05);
    session.send(SetGravity{{0, -9, 0}});
    session.advance_to(0.1);
    session.send(SetGravity{{0, -1, 0}});
    session.send(Undo{});
    session.wait_for_commands();
    ASSERT_EQ(session.state()->refused, 0) << session.state()->refusal;
    std::vector<Particle<double>> live;
    session.inspect_solver([&](const Simulator& s) { live = s.particles(); });
    const SessionLog log = session.session_log();
    for (const Codec codec : {Codec::quantised, Codec::automatic}) {
        ReplayOptions by;
        by.make_solver = on_cpu, by.stepped = true;
        by.codec = codec;
        SessionReplay replay(log.scene, by);
        for (const SessionEvent& event : log.events) replay.add(event);
        EXPECT_EQ(same_bits(replay.simulator().particles(), live), codec == Codec::quantised);
    }
}

}  // namespace
}  // namespace knead
