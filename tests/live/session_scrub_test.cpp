// Steps and stored states give the bits of a run that was not interrupted: each step from the last
// to the first and back, each frame of shipped scenes twice, a run without a history, and what is
// published after undo.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "host/assets/procedural_object.h"
#include "host/base/machine.h"
#include "host/files/splat_file.h"
#include "host/live/live_session.h"
#include "host/scene/presets.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "tests/folder.h"
#include "tests/live/state_difference.h"
#include "tests/sanitized.h"
#include "tests/session/clay_rows.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

LiveOptions stepped_options()
{
    LiveOptions options;
    options.make_solver = [](const Setup& setup) { return cpu_solver(setup); };
    options.stepped = options.logs = true;
    return options;
}

// A folder of working logs, as long as a test runs.
class SessionSteps : public InFolder {
  protected:
    SessionSteps()
    {
        if (const char* before = std::getenv("XDG_STATE_HOME")) state_home = before;
        setenv("XDG_STATE_HOME", folder.c_str(), 1);
    }
    ~SessionSteps() override
    {
        if (state_home.empty())
            unsetenv("XDG_STATE_HOME");
        else
            setenv("XDG_STATE_HOME", state_home.c_str(), 1);
    }

  private:
    std::string state_home;
};

std::uint64_t rows_hash(LiveSession& session)
{
    std::uint64_t found = 0;
    session.inspect_solver(
        [&](const Simulator& s) { found = hash(s.editable()->rows(*s.editable()->snapshot())); });
    return found;
}

void apply(LiveSession& session, const Command& command)
{
    const int refused = session.state()->refused;
    session.send(command);
    session.wait_for_commands();
    ASSERT_EQ(session.state()->refused, refused) << session.state()->refusal;
}

// --- scrubbing

TEST_F(SessionSteps, FromTheLastToTheFirstAndBackHaveTheClayOfTheLinearRun)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=16", "surface.nodes=16", "step.courant=0.9"});
    const double rate = scene->scene.frame_rate;
    LiveSession session(scene, stepped_options());
    const int before = 70, frames = 60;  // hands reach the clay after some frames
    std::vector<std::uint64_t> hashes{rows_hash(session)};
    for (int frame = 1; frame <= before + frames; ++frame) {
        session.advance_to(frame / rate);
        hashes.push_back(rows_hash(session));
        if (frame >= before && frame % 3 == 0)
            apply(session, SetGravity{{0, -9.81 + 0.001 * frame, 0}});
    }
    apply(session, GoTo{0});
    // By the step: frames before it was captured.
    std::vector<std::pair<StepId, std::size_t>> steps{{0, 0}};
    std::size_t frame = 0;
    std::uint64_t current = 0;
    for (const SessionEvent& event : session.session_log().events) {
        frame += std::holds_alternative<FrameEvent>(event);
        const auto* captured = std::get_if<StepCaptured>(&event);
        if (!captured) continue;
        EXPECT_EQ(captured->id, ++current);
        steps.emplace_back(captured->id, frame);
    }
    EXPECT_EQ(frame, std::size_t(before + frames));
    ASSERT_GE(steps.size(), std::size_t(frames / 3));
    EXPECT_NE(hashes[std::size_t(before)], hashes[std::size_t(before + frames)]);
    const auto visit = [&](const std::pair<StepId, std::size_t>& step) {
        apply(session, GoTo{int(step.first)});
        EXPECT_EQ(rows_hash(session), hashes[step.second]) << "step " << step.first;
    };
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) visit(*step);
    for (const auto& step : steps) visit(step);
    for (std::size_t i = steps.size() - 1; i > 0; --i) {
        apply(session, Undo{});
        EXPECT_EQ(rows_hash(session), hashes[steps[i - 1].second]) << "undo of " << i;
    }
    for (std::size_t i = 1; i < steps.size(); ++i) {
        apply(session, Redo{});
        EXPECT_EQ(rows_hash(session), hashes[steps[i].second]) << "redo of " << i;
    }
}

// --- frames of scenes, twice

struct ShippedScene {
    const char *name, *hands;
    std::vector<std::string> settings;
    int frames;
};
// Those of scenes/golden.csv, of few cells; between them they have all tools, materials and rests.
const std::vector<ShippedScene>& shipped_scenes()
{
    static const std::vector<ShippedScene> all{
        {"cut", "cut.hands", {"domain.cells=16"}, 120},
        {"demo", "squeeze.hands", {"domain.cells=16"}, 90},
        {"flatten", "", {"domain.cells=16"}, 70},
        {"imprint", "imprint.hands", {"domain.cells=24"}, 75},
        {"knead", "knead.hands", {"domain.cells=24"}, 55},
        {"materials", "", {"domain.cells=24"}, 20},
        {"pinch", "", {"domain.cells=16"}, 75},
        {"poke", "", {"domain.cells=24", "rest.mode=sleep", "rest.speed=0.3"}, 60},
        {"roll", "roll.hands", {"domain.cells=16", "rest.mode=localized"}, 80},
        {"squeeze", "squeeze.hands", {"domain.cells=16"}, 100},
    };
    return all;
}

class TwiceTheSameFrame : public testing::TestWithParam<std::size_t> {};

// Each frame with KNEAD_LONG=1, else some of them. The state goes back by a snapshot, and by its
// numbers into another simulator.
TEST_P(TwiceTheSameFrame, HasTheSameBits)
{
    const ShippedScene& of = shipped_scenes()[GetParam()];
    SCOPED_TRACE(of.name);
    Scene scene = read_scene(std::string("scenes/") + of.name + ".json", of.settings);
    if (of.hands[0]) scene.hands.recording = std::string("scenes/") + of.hands;
    build(scene, available_memory());
    const std::unique_ptr<EditableSimulator> one = cpu_solver(scene.setup),
                                             other = cpu_solver(scene.setup);
    std::unique_ptr<HandSource> hands;
    if (scene.has_hands) hands = std::make_unique<HandSource>(hands_of(scene), scene.hands);
    const MotionSource motion = recorded_motion(hands.get(), scene.hands);
    const double duration = frame_duration(scene);
    const int every = std::getenv("KNEAD_LONG") ? 1 : sanitized ? 40 : 7;
    long touched = 0, twice = 0;
    for (int frame = 1; frame <= of.frames; ++frame) {
        SCOPED_TRACE(testing::Message() << "frame " << frame);
        const Motion m = motion((frame - 1) / scene.frame_rate, frame / scene.frame_rate);
        if (frame % every != 0) {
            touched += one->advance(m, duration).touched != 0;
            continue;
        }
        const std::shared_ptr<const Snapshot> before = one->snapshot();
        const SavedState stored = one->saved(*before);
        const FrameStats stats = one->advance(m, duration);
        const SavedState after = one->save();
        touched += stats.touched != 0, ++twice;

        other->load(stored);
        Difference numbers;
        numbers.stats(stats, other->advance(m, duration));
        numbers.states(after, other->save());
        ASSERT_EQ(numbers.first, "") << "of a stored state";
        one->restore(*before);
        Difference of_store;
        of_store.states(stored, one->save());
        ASSERT_EQ(of_store.first, "") << "before the frame";
        Difference restored;
        restored.stats(stats, one->advance(m, duration));
        restored.states(after, one->save());
        ASSERT_EQ(restored.first, "") << "of a snapshot";
    }
    EXPECT_GT(twice, 0);
    if (hands && !sanitized) {
        EXPECT_GT(touched, 0) << "hands press";
    }
}

INSTANTIATE_TEST_SUITE_P(ShippedScenes, TwiceTheSameFrame,
                         testing::Range(std::size_t(0), std::size_t(10)),
                         [](const auto& one) { return shipped_scenes()[one.param].name; });

// --- without a history

TEST_F(SessionSteps, AndTheLogLeaveTheBitsOfARunWithoutThem)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=16", "surface.nodes=16", "step.courant=0.9"});
    const double rate = scene->scene.frame_rate;
    LiveOptions options = stepped_options();
    options.protects = true, options.recorded = false;
    options.history = std::size_t(1) << 20;
    LiveSession session(scene, options);
    // Hands squeeze, are lost and come back; between frames commands begin steps.
    const std::vector<HandFrame>& recording = scene->recording->frames;
    MaterialSpec softer = scene->scene.objects[0].stated;
    softer.young *= 0.5;
    const int frames = 200;
    long touched = 0;
    for (int frame = 1; frame <= frames; ++frame) {
        HandFrame hands = recording[std::min(std::size_t(frame * 60 / 90), recording.size() - 1)];
        hands.time = frame / rate;
        for (Hand& hand : hands.hand) hand.tracked = hand.tracked && (frame < 120 || frame > 140);
        session.push(hands);
        session.advance_to(frame / rate);
        touched += session.state()->frame.stats.touched != 0;
        if (frame == 100) apply(session, SetGravity{{0, -5, 0}});
        if (frame == 150) apply(session, SetMaterial{ObjectId{1}, softer});
    }
    std::vector<Particle<double>> particles;
    session.inspect_solver([&](const Simulator& s) { particles = s.particles(); });
    EXPECT_GT(touched, 20);
    EXPECT_GE(session.state()->steps->size(), 5u);
    EXPECT_EQ(session.state()->log.dropped, 0);

    const std::unique_ptr<EditableSimulator> alone = cpu_solver(scene->scene.setup);
    int frame = 0;
    for (const SessionEvent& event : session.session_log().events) {
        const FrameEvent* one = std::get_if<FrameEvent>(&event);
        if (!one) continue;
        alone->advance(one->motion, one->duration);
        ++frame;
        if (frame == 100) alone->set_gravity({0, -5, 0});
        if (frame == 150) {
            Material<double> material = made(softer);
            material.category = alone->config().materials[0].category;
            alone->set_material(0, material);
        }
    }
    EXPECT_EQ(frame, frames);
    EXPECT_TRUE(same_bits(alone->particles(), particles));
}

// --- what is published

void expect_same_views(const LiveState& a, const LiveState& b)
{
    EXPECT_EQ(a.failure + b.failure, "");
    ASSERT_TRUE(a.meshes && b.meshes);
    EXPECT_FALSE(a.meshes->empty());
    EXPECT_TRUE(same_bits(*a.meshes, *b.meshes)) << "surface";
    ASSERT_TRUE(a.gaussians && b.gaussians);
    EXPECT_TRUE(same_bits(*a.gaussians, *b.gaussians)) << "Gaussians";
    ASSERT_TRUE(a.splats && b.splats);
    EXPECT_GE(a.splats->count(), a.gaussians->size());
    EXPECT_TRUE(same_bits(a.splats->centre, b.splats->centre)) << "splats";
    EXPECT_TRUE(same_bits(a.splats->rotation, b.splats->rotation));
    EXPECT_TRUE(same_bits(a.splats->scale, b.splats->scale));
    EXPECT_TRUE(same_bits(a.splats->sh, b.splats->sh));
    EXPECT_EQ(a.splats->opacity, b.splats->opacity);
    EXPECT_TRUE(equal(*a.document, *b.document)) << "document";
}

TEST_F(SessionSteps, ArePublishedWithSurfaceSplatsAndDocumentOfOneVersion)
{
    write_splats(path("pot.ply"), glazed_pot(1500));
    std::ofstream(path("scene.json")) << R"({"schema": "knead.scene/1", "frame_rate": 30,
        "domain": {"edge": 0.6, "cells": 16}, "surface": {"nodes": 20},
        "objects": [{"shape": "splats", "file": "pot.ply", "size": 0.2, "name": "pot",
                     "centre": [0.3, 0.2, 0.3], "velocity": [0, -5, 0], "material": "soft-clay",
                     "category": 2},
                    {"name": "ball", "centre": [0.14, 0.12, 0.14], "diameter": 0.1}],
        "splats": {"every": 3, "split": {"limit": 1.2, "budget": 50},
                   "refill": {"see_through": 0.05, "budget": 20}},
        "hands": {"recording": "squeeze", "zoom": 0.5}})";
    LiveOptions options = stepped_options();
    options.protects = true;
    LiveSession session(load_live_scene(path("scene.json")), options);
    session.wait_for_commands();
    const std::size_t splats = session.state()->splats->count();
    int files_made = 0, compared = 0;
    const auto waited = [&](const std::function<bool(const LiveState&)>& is) {
        for (int i = 0; i < 20000 && !is(*session.state()); ++i) {
            session.inspect_solver([](const Simulator&) {});
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return is(*session.state());
    };
    const auto opened = [&](const std::string& file) {
        LiveOptions by = stepped_options();
        by.session = file;
        LiveSession other(nullptr, by);
        other.wait_until_open(), other.wait_for_commands();
        expect_same_views(*session.state(), *other.state());
        ++compared;
    };
    // As a session that is opened at this state.
    const auto compare = [&](const char* after) {
        SCOPED_TRACE(after);
        const auto state = session.state();
        const std::string file = path(std::to_string(++files_made) + ".knead");
        apply(session, Save{file, {}});
        ASSERT_TRUE(waited([&](const LiveState& s) { return s.saved_as == file; }));
        // Saving has changed no view.
        EXPECT_EQ(session.state()->mesh_version, state->mesh_version);
        EXPECT_EQ(session.state()->splat_version, state->splat_version);
        opened(file);
    };
    const auto advance = [&](int frames) {
        session.advance_to(session.state()->time + (frames + 0.1) / 30);
    };
    advance(10);
    EXPECT_GT(session.state()->splats->count(), splats) << "some were split";
    SceneObject box;
    box.name = "box", box.source.shape = ShapeKind::box, box.source.size = {0.08, 0.08, 0.08};
    box.pose.p = {0.45, 0.4, 0.45}, box.material = material_spec("dough");
    apply(session, AddObject{box});
    compare("add");
    advance(3);
    compare("frames");
    apply(session, SetCategory{ObjectRef("box"), 1});
    advance(4);
    apply(session, SetMaterial{ObjectRef("ball"), material_spec("snow")});
    advance(3);
    apply(session, RemoveObjects{{ObjectRef("pot")}});
    compare("remove");
    EXPECT_EQ(session.state()->gaussians->size(), 0u);
    const StepId last = session.state()->steps->back().id;
    for (StepId left = last; left > 0; --left) {
        apply(session, Undo{});
        compare("undo");
    }
    EXPECT_EQ(session.state()->gaussians->size(), splats);
    EXPECT_EQ(session.state()->splats->count(), splats);
    for (StepId left = last; left > 0; --left) {
        apply(session, Redo{});
        compare("redo");
    }
    apply(session, GoTo{1});
    compare("go_to");
    advance(2);
    compare("frames after go_to");
    apply(session, Open{path("2.knead"), {}, {}});
    compare("open");
    // As a session that is recovered at this step.
    for (const int step : {0, 2, 1}) {
        SCOPED_TRACE(step);
        apply(session, GoTo{step});
        apply(session, Rename{ObjectId{2}, "ball " + std::to_string(step)});  // goes to the log
        const std::string copy = path("knead/copy" + std::to_string(step) + log_ending);
        ASSERT_TRUE(waited([](const LiveState& s) { return s.log.waiting == 0; }));
        fs::copy_file(session.state()->log.file, copy);
        opened(copy);
    }
    EXPECT_GT(compared, 12);
}

}  // namespace
}  // namespace knead
