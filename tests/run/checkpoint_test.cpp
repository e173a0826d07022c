// Checkpoints: a run that goes on from one ends in the bits of one that was never ended, and a file
// that is not whole is refused. It is a session, too.
#include "host/run/checkpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/live/live_session.h"
#include "host/run/report.h"
#include "host/session/backend.h"
#include "tests/folder.h"
#include "tests/run/checkpoint_6.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

// Falls, is squeezed, rests: all that a state is made of.
const char* const scene_text = R"({
    "schema": "knead.scene/1", "name": "torn", "rest": {"mode": "sleep", "frames": 2},
    "domain": {"edge": 0.32, "cells": 16},
    "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
                 "material": {"preset": "clay", "young": 1e5}}],
    "hands": {"recording": "squeeze"}
})";

LiveOptions live_options()
{
    LiveOptions o;
    o.make_solver = [](const Setup& setup) { return make_solver(setup, {DeviceKind::cpu, 0}); };
    o.stepped = true;
    return o;
}

class CheckpointFile : public InFolder {
  protected:
    void SetUp() override { write_whole(path("scene.json"), scene_text); }

    RunOptions options(const std::string& out) const
    {
        RunOptions o;
        o.scene = path("scene.json"), o.device = "cpu", o.frames = 12, o.threads = 1;
        o.quiet = true, o.particles = true, o.mesh = "ply", o.out = path(out);
        return o;
    }
    RunOptions resumed(const std::string& out) const
    {
        RunOptions o;
        o.resume = path(out), o.quiet = true, o.threads = 1;
        return o;
    }
    // Runs with ever longer time limits, and from the shortest again where one was too long, until
    // one ended as `wanted` says.
    void stop_early(RunOptions o, const std::function<bool()>& wanted) const
    {
        o.overwrite = true, o.time_limit = 0.002;
        for (int tries = 0; tries < 400; ++tries) {
            ASSERT_EQ(run_verb(o), exit_ok);
            if (wanted()) return;
            const bool ended = read_json(o.out + "/report.json")["knead"]["end"] == "complete";
            o.time_limit = ended ? 0.002 : 1.15 * o.time_limit;
        }
        FAIL() << "no run ended where it was to end";
    }
    // A run stopped by its time limit in its first frames, with a checkpoint.
    void tear(const std::string& out) const
    {
        RunOptions o = options(out);
        o.checkpoint = 1e-9;
        stop_early(o, [&] { return fs::exists(path(out + "/" + checkpoint_name)); });
    }
    std::string bytes(const std::string& name) const
    {
        return read_text(path(name), std::size_t(1) << 30);
    }
    std::string refused(const std::string& name) const
    {
        try {
            read_checkpoint(path(name));
        } catch (const InputError& e) {
            return e.what();
        }
        return "accepted";
    }
    static Json described_by_info(const std::string& file)
    {
        InfoOptions o;
        o.file = file, o.json = true;
        testing::internal::CaptureStdout();
        std::string why;
        try {
            info_verb(o);
        } catch (const std::exception& e) {
            why = e.what();
        }
        const std::string printed = testing::internal::GetCapturedStdout();
        EXPECT_EQ(why, "");
        return parse_json(printed, "info");
    }
    std::string end(const std::string& out) const
    {
        return read_json(path(out + "/report.json"))["knead"]["end"];
    }
};

TEST_F(CheckpointFile, ARunThatGoesOnEndsInTheBitsOfOneThatWasNotEnded)
{
    ASSERT_EQ(run_verb(options("whole")), exit_ok);
    tear("torn");
    ASSERT_EQ(end("torn"), "time limit");
    ASSERT_EQ(run_verb(resumed("torn")), exit_ok);
    EXPECT_EQ(end("torn"), "complete");
    EXPECT_EQ(bytes("torn/particles.ply"), bytes("whole/particles.ply"));
    EXPECT_EQ(bytes("torn/mesh.ply"), bytes("whole/mesh.ply"));
    const Json a = read_json(path("whole/report.json"))["knead"],
               b = read_json(path("torn/report.json"))["knead"];
    for (const char* key : {"state_hash", "time", "guards", "penetration", "mass", "volume",
                            "momentum", "energy", "frames", "rest", "yielded_share", "hands"})
        EXPECT_EQ(a[key], b[key]) << key;
    EXPECT_FALSE(fs::exists(path("torn/" + std::string(checkpoint_name))));
}

TEST_F(CheckpointFile, ARunOfAnOlderKneadEndsInTheSameBits)
{
    ASSERT_EQ(run_verb(options("whole")), exit_ok);
    tear("torn");
    const std::string file = path("torn/" + std::string(checkpoint_name));
    const Checkpoint c = read_checkpoint(file);
    write_whole(file, checkpoint_6(c));
    ASSERT_EQ(bytes("torn/checkpoint.knead").substr(0, 16), "knead.checkpoint");
    EXPECT_EQ(described_by_info(file)["frames"], c.record.rows.size());

    // A checkpoint of a run that goes on from it is of this version.
    RunOptions further = resumed("torn");
    further.checkpoint = 1e-9, further.time_limit = 1e-9;
    ASSERT_EQ(run_verb(further), exit_ok);
    if (end("torn") == "time limit") {
        EXPECT_TRUE(is_session(file));
    }
    if (fs::exists(file)) {
        ASSERT_EQ(run_verb(resumed("torn")), exit_ok);
    }
    EXPECT_EQ(end("torn"), "complete");
    EXPECT_EQ(bytes("torn/particles.ply"), bytes("whole/particles.ply"));
    EXPECT_EQ(bytes("torn/mesh.ply"), bytes("whole/mesh.ply"));
}

TEST_F(CheckpointFile, IsASessionThatViewGoesOnWith)
{
    tear("torn");
    const std::string file = path("torn/" + std::string(checkpoint_name));
    const std::string before = bytes("torn/checkpoint.knead");
    const Checkpoint c = read_checkpoint(file);
    const Json info = described_by_info(file);
    EXPECT_EQ(info["kind"], "checkpoint");
    EXPECT_EQ(info["scene"], path("scene.json"));
    EXPECT_EQ(info["frames"], c.record.rows.size());
    EXPECT_EQ(info["frames_wanted"], 12);

    const std::string logs = folder / "state";
    setenv("XDG_STATE_HOME", logs.c_str(), 1);
    LiveOptions live = live_options();
    live.protects = true, live.session = file;
    const std::string saved = path("saved.knead");
    std::string beginning, squeezed;
    {
        LiveSession session(nullptr, live);
        session.wait_until_open();
        session.wait_for_commands();
        beginning = session.digest().hash;
        EXPECT_EQ(session.digest().particles, long(c.stored.state.contents.particles.size()));
        EXPECT_EQ(session.state()->saved_as, "") << "a run goes on with that file";
        EXPECT_FALSE(session.state()->unsaved);
        // The past begins with the checkpoint, not with the scene.
        session.send(SetGravity{{0, -3, 0}});
        session.advance_to(0.2);
        session.send(Undo{});
        session.wait_for_commands();
        EXPECT_EQ(session.state()->refusal, "");
        EXPECT_EQ(session.digest().hash, beginning);
        session.send(Redo{});
        session.wait_for_commands();
        squeezed = session.digest().hash;
        EXPECT_NE(squeezed, beginning);
        session.send(Save{saved, {}});
        for (int i = 0; i < 1000 && session.state()->saved_as.empty(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        EXPECT_EQ(session.state()->saved_as, saved);
    }
    EXPECT_EQ(bytes("torn/checkpoint.knead"), before);
    EXPECT_FALSE(is_checkpoint(saved));
    EXPECT_EQ(described_by_info(saved)["kind"], "session");
    verify_session(SessionFile(saved));
    live.session = saved;
    {
        LiveSession session(nullptr, live);
        session.wait_until_open();
        session.wait_for_commands();
        EXPECT_EQ(session.digest().hash, squeezed);
        session.send(Undo{});
        session.wait_for_commands();
        EXPECT_EQ(session.digest().hash, beginning);
    }

    // A run cannot go on with what is no checkpoint any more.
    fs::rename(saved, file);
    try {
        run_verb(resumed("torn"));
        ADD_FAILURE() << "accepted";
    } catch (const InputError& e) {
        EXPECT_STREQ(e.what(), (file + ": expected a checkpoint of a run, found another session; "
                                       "`knead view` opens it")
                                   .c_str());
    }
    unsetenv("XDG_STATE_HOME");
}

TEST_F(CheckpointFile, AnOlderOneIsNotOpenedAsASession)
{
    tear("torn");
    const std::string file = path("torn/" + std::string(checkpoint_name));
    write_whole(file, checkpoint_6(read_checkpoint(file)));
    LiveSession session(load_live_scene(path("scene.json")), live_options());
    session.send(Open{file, {}, {}});
    session.wait_for_commands();
    EXPECT_NE(session.state()->refusal.find("is a checkpoint of an older knead, and no session"),
              std::string::npos)
        << session.state()->refusal;
    EXPECT_EQ(session.state()->scene->scene.path, path("scene.json"));
}

TEST_F(CheckpointFile, AFrameThatWasCutShortIsBegunAgain)
{
    ASSERT_EQ(run_verb(options("whole")), exit_ok);
    RunOptions o = options("cut");
    o.checkpoint = 1e6;
    Json report;
    stop_early(o, [&] {  // within a frame after the first
        report = read_json(path("cut/report.json"));
        return report["knead"].contains("cut") && report["knead"]["frames"] != 1;
    });
    const Checkpoint c = read_checkpoint(path("cut/" + std::string(checkpoint_name)));
    EXPECT_EQ(c.record.rows.size() + 1, report["knead"]["frames"].get<std::size_t>());
    EXPECT_FALSE(c.record.rows.back().stats.cut);
    ASSERT_EQ(run_verb(resumed("cut")), exit_ok);
    EXPECT_EQ(bytes("cut/particles.ply"), bytes("whole/particles.ply"));
    EXPECT_EQ(read_json(path("cut/report.json"))["knead"]["penetration"],
              read_json(path("whole/report.json"))["knead"]["penetration"]);
}

TEST_F(CheckpointFile, HoldsWhatWasWritten)
{
    tear("torn");
    const std::string file = path("torn/" + std::string(checkpoint_name));
    const Checkpoint c = read_checkpoint(file);
    EXPECT_FALSE(c.record.rows.empty());
    EXPECT_EQ(c.record.frames_wanted, 12);
    write_checkpoint(path("again"), c);
    const Checkpoint again = read_checkpoint(path("again"));
    EXPECT_EQ(again.command, c.command);
    EXPECT_EQ(to_bytes(again.stored), to_bytes(c.stored));
    EXPECT_EQ(record_facts(path("again")), record_facts(file));
}

TEST_F(CheckpointFile, HoldsGaussiansThatFollowTheClay)
{
    tear("torn");
    Checkpoint c = read_checkpoint(path("torn/" + std::string(checkpoint_name)));
    Gaussian<double> g = gaussian_at(Vec3<double>{0.125, 0.25, 0.5}, 0);
    g.F = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, g.sides = below;
    c.stored.state.contents.gaussians = {g, gaussian_at(Vec3<double>{0.5, 0.5, 0.5}, 0)};
    c.record.rows.back().stats[Count::stranded] = 7, c.record.rows.back().splats_split = 5;
    SplatCloud cloud;
    cloud.degree = 1, cloud.antialiased = true;
    for (int i = 0; i < 2; ++i) {
        cloud.centre.push_back({1, 2, float(i)}), cloud.rotation.push_back({0, 1, 0, 0});
        cloud.scale.push_back({0.5f, 0.25f, 0}), cloud.opacity.push_back(0.75f);
        for (int k = 0; k < 4; ++k) cloud.sh.push_back({float(k), -1, float(i)});
    }
    c.stored.splats = carried(cloud), c.stored.splats.extent[1] = 3;
    c.stored.local.cloud = cloud, c.stored.local.active = {1, 0},
    c.stored.local.normal = {{0, 1, 0}, {0, 0, 0}};
    c.stored.state.sliding = {{7, 0.5f, 0.01f, 3}, {9, 2, 0.05f, -0.25f}};
    c.stored.local.slot_of = {0, -1}, c.stored.local.clay = {{-5, -1}, {7, 2}},
    c.stored.local.objects = 3;
    write_checkpoint(path("with"), c);
    const Checkpoint read = read_checkpoint(path("with"));
    EXPECT_TRUE(same_bits(read.stored.local.cloud.sh, cloud.sh));
    EXPECT_EQ(read.stored.local.active, c.stored.local.active);
    EXPECT_TRUE(same_bits(read.stored.local.normal, c.stored.local.normal));
    EXPECT_EQ(read.stored.local.slot_of, c.stored.local.slot_of);
    EXPECT_EQ(read.stored.local.clay, c.stored.local.clay);
    EXPECT_EQ(read.stored.local.objects, 3);
    EXPECT_TRUE(same_bits(read.stored.state.contents.gaussians, c.stored.state.contents.gaussians));
    EXPECT_TRUE(same_bits(read.stored.state.contents.particles, c.stored.state.contents.particles));
    EXPECT_EQ(read.stored.state.quiet, c.stored.state.quiet);
    EXPECT_TRUE(same_bits(read.stored.state.sliding, c.stored.state.sliding));
    EXPECT_EQ(read.record.rows.back().stats[Count::stranded], 7);
    EXPECT_EQ(read.record.rows.back().splats_split, 5);
    EXPECT_TRUE(read.stored.splats.cloud.antialiased);
    EXPECT_TRUE(same_bits(read.stored.splats.cloud.sh, cloud.sh));
    EXPECT_TRUE(same_bits(read.stored.splats.cloud.rotation, cloud.rotation));
    EXPECT_EQ(read.stored.splats.extent, c.stored.splats.extent);
    c.stored.splats.cloud.scale[1].y = NAN;
    write_checkpoint(path("with"), c);
    EXPECT_NE(refused("with").find("splats"), std::string::npos) << refused("with");
    c.stored.splats = carried(picked(cloud, {0}));
    write_checkpoint(path("with"), c);
    EXPECT_NE(refused("with").find("1 splats"), std::string::npos) << refused("with");
}

TEST_F(CheckpointFile, WhatIsNotWholeIsRefusedAndStays)
{
    tear("torn");
    const std::string name = "torn/" + std::string(checkpoint_name), whole = bytes(name);
    const auto refused_of = [&](const std::string& text) {
        write_whole(path("bad"), text);
        return refused("bad");
    };
    EXPECT_NE(refused("absent").find("no such file"), std::string::npos);
    EXPECT_NE(refused_of("").find("something else"), std::string::npos);
    EXPECT_NE(refused_of(std::string(10000, 'x')).find("something else"), std::string::npos);
    const std::string older = checkpoint_6(read_checkpoint(path(name)));
    EXPECT_EQ(refused_of(older), "accepted");
    EXPECT_NE(refused_of(older + "x").find("the length given in the header"), std::string::npos);
    for (const std::string& all : {whole, older}) {
        EXPECT_NE(refused_of(all + "x"), "accepted");
        for (std::size_t size : {16, 30, 47, 48, 1000})
            EXPECT_NE(refused_of(all.substr(0, size)), "accepted") << size;
        EXPECT_NE(refused_of(all.substr(0, all.size() - 1)), "accepted");
        for (std::size_t at = 0; at < all.size(); at += 1 + all.size() / 97) {
            std::string other = all;
            other[at] = char(other[at] ^ 4);
            EXPECT_NE(refused_of(other), "accepted") << at;
        }
    }
    std::string newer = whole;
    newer[16] = char(newer[16] + 1);
    EXPECT_NE(refused_of(newer).find("of a newer knead"), std::string::npos);
    std::string other = older;
    other[16] = 5;
    EXPECT_NE(refused_of(other).find("expected version 6, found 5"), std::string::npos);

    // The program says so, and leaves all as it is.
    std::ofstream(path(name), std::ios::binary) << whole.substr(0, whole.size() / 2);
    const std::string report = bytes("torn/report.json");
    EXPECT_THROW(run_verb(resumed("torn")), InputError);
    EXPECT_EQ(bytes("torn/report.json"), report);
    EXPECT_EQ(bytes(name).size(), whole.size() / 2);
}

TEST_F(CheckpointFile, GoesOnOnlyWithItsOwnScene)
{
    tear("torn");
    std::ofstream(path("scene.json")) << scene_text << "\n";
    EXPECT_THROW(run_verb(resumed("torn")), InputError);
    fs::remove(path("scene.json"));
    EXPECT_THROW(run_verb(resumed("torn")), InputError);
    EXPECT_EQ(end("torn"), "time limit");
}

TEST_F(CheckpointFile, WhatMakesNoSenseToTheSolverIsRefused)
{
    tear("torn");
    const std::string file = path("torn/" + std::string(checkpoint_name));
    const Checkpoint good = read_checkpoint(file);
    const auto refused_with = [&](const std::function<void(Checkpoint&)>& spoil) {
        Checkpoint c = good;
        spoil(c);
        write_checkpoint(file, c);
        EXPECT_THROW(run_verb(resumed("torn")), InputError);
        EXPECT_EQ(end("torn"), "time limit");
    };
    refused_with([](Checkpoint& c) { c.stored.state.order[0] = c.stored.state.order[1]; });
    refused_with([](Checkpoint& c) { c.stored.state.order[0] = -7; });
    refused_with([](Checkpoint& c) { c.stored.state.contents.particles[3].x.y = 1e9; });
    refused_with([](Checkpoint& c) { c.stored.state.contents.particles[3].object = 99; });
    refused_with([](Checkpoint& c) { c.stored.state.contents.particles[3].v.x = std::nan(""); });
    refused_with([](Checkpoint& c) {
        c.stored.state.contents.particles.pop_back(), c.stored.state.order.pop_back();
    });
    const auto with = [](Gaussian<double> g) {
        return [g](Checkpoint& c) { c.stored.state.contents.gaussians = {g}; };
    };
    const Vec3<double> inside = good.stored.state.contents.particles[3].x;
    refused_with(with(gaussian_at(inside, 99)));
    refused_with(with(gaussian_at(Vec3<double>{0.16, 1e9, 0.16}, 0)));
    refused_with(with(gaussian_at(Vec3<double>{0.16, std::nan(""), 0.16}, 0)));
    refused_with(with({inside, {}, 0, 77}));
    refused_with([](Checkpoint& c) { c.record.rows.clear(); });
    refused_with([](Checkpoint& c) { c.record.rows.back().frame = 77; });
    refused_with([](Checkpoint& c) { c.command.erase("mesh"); });
    refused_with([](Checkpoint& c) { c.command["frames"] = "many"; });
    refused_with([](Checkpoint& c) {  // arrays in arrays
        for (int i = 0; i < 1000; ++i) c.command = Json::array({c.command});
    });
}

TEST_F(CheckpointFile, AFolderWithOneIsNotTakenForAnotherRun)
{
    tear("torn");
    EXPECT_THROW(run_verb(options("torn")), OutputError);
    RunOptions o = options("torn");
    o.overwrite = true, o.frames = 1;
    std::ofstream(path("torn/checkpoint.partial-999999999-0.knead")) << "half";
    std::ofstream(path("torn/mine.partial-999999999-0.txt")) << "of somebody else";
    ASSERT_EQ(run_verb(o), exit_ok);
    EXPECT_FALSE(fs::exists(path("torn/" + std::string(checkpoint_name))));
    EXPECT_FALSE(fs::exists(path("torn/checkpoint.partial-999999999-0.knead")));
    EXPECT_TRUE(fs::exists(path("torn/mine.partial-999999999-0.txt")));
}

}  // namespace
}  // namespace knead
