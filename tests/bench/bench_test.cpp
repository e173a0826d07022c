// Benchmarks: what is driven, what is computed of it, and what is said.
#include "host/bench/bench.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/hands/gesture.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "tests/bench/has_matplotlib.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

// The squeeze with a softer ball on a coarse lattice: a frame of it takes milliseconds.
const char* const coarse = R"({
    "schema": "knead.scene/1", "name": "coarse",
    "domain": {"edge": 1.0, "cells": 64},
    "objects": [{"shape": "sphere", "centre": [0.5, 0.3, 0.5], "diameter": 0.5, "per_cell": 2,
                 "material": {"preset": "clay", "elasticity": "neo_hookean", "young": 1e4}}],
    "hands": {"recording": "squeeze", "zoom": 2.5, "at": [0.5, 0.3, 0.5]},
    "surface": {"nodes": 32}
})";

class BenchFolder : public InFolder {
  protected:
    void SetUp() override
    {
        InFolder::SetUp();
        write_whole(path("scene.json"), coarse);
    }
    BenchOptions quick() const
    {
        BenchOptions o;
        o.device = "cpu", o.scene = (folder / "scene.json").string(), o.quick = o.quiet = true;
        o.out = (folder / "out").string(), o.case_limit = 0.01;
        return o;
    }
    std::string text(const std::string& name) const
    {
        std::ifstream in(folder / "out" / name);
        std::stringstream all;
        all << in.rdbuf();
        return all.str();
    }
    // Exit code; what was said on either stream is kept.
    int code(const BenchOptions& o)
    {
        testing::internal::CaptureStderr();
        testing::internal::CaptureStdout();
        const int result = run_and_report([&] { return bench_verb(o); });
        complained = testing::internal::GetCapturedStderr();
        said = testing::internal::GetCapturedStdout();
        return result;
    }
    std::string said, complained;
};

TEST_F(BenchFolder, StagesOfASqueezeAreMeasuredAndWritten)
{
    BenchOptions o = quick();
    o.suites = {"stages"};
    ASSERT_EQ(code(o), exit_ok) << complained;
    const Json all = Json::parse(text("bench.json"));
    EXPECT_EQ(all["schema"], "knead.bench/1");
    EXPECT_GT(all["context"]["copy_bytes_per_second"], 1e8);
    EXPECT_EQ(all["context"]["commit"], knead_commit());
    ASSERT_EQ(all["rows"].size(), 1u);
    const Json& row = all["rows"][0];
    EXPECT_GE(row["frames"], 2);
    EXPECT_GT(row["frames_in_contact"], 0);  // it begins where both hands touch
    EXPECT_GT(row["stages_ms"]["p2g"], 0);
    double stages = 0;
    for (const auto& [name, time] : row["stages_ms"].items()) stages += time.get<double>();
    EXPECT_LT(stages, 1.05 * row["frame_ms"]["max"].get<double>());
    const double substep = row["substep_us"]["median"], count = row["particles"];
    EXPECT_NEAR(row["items_per_second"].get<double>() / (1e6 * count / substep), 1, 1e-9);
    EXPECT_TRUE(row["instructions_per_particle"].is_null());  // never invented
    EXPECT_NE(said.find("squeeze"), said.npos);
    if (has_matplotlib())
        EXPECT_NE(text("stages.svg").find("</svg>"), std::string::npos);
    else
        EXPECT_NE(said.find("; by hand: python3 profiling/plot.py " + path("out/bench.json")),
                  said.npos)
            << said;
    const std::string csv = text("bench.csv");
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
    EXPECT_EQ(code(o), exit_output);  // nothing is replaced unasked
    o.overwrite = o.count = true;
    ASSERT_EQ(code(o), exit_ok) << complained;
    const Json counted = Json::parse(text("bench.json"));
    EXPECT_TRUE(counted["rows"][0]["instructions_per_particle"].is_null());
    EXPECT_NE(counted["left_out"].dump().find("instructions and bytes: "), std::string::npos);
}

TEST_F(BenchFolder, WrongWordsAreRefusedBeforeAnythingIsMeasured)
{
    BenchOptions o = quick();
    o.suites = {"stagse"};
    EXPECT_EQ(code(o), exit_usage);
    EXPECT_NE(complained.find("\"stages\""), complained.npos) << complained;
    o.suites = {"stages"}, o.device = "cpu:double";
    EXPECT_EQ(code(o), exit_usage);
    o.device = "gpu:x";
    EXPECT_EQ(code(o), exit_usage);
    EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(BenchFolder, WithoutItsFilesOfFiguresItGoesOnAndSaysSo)
{
    BenchOptions o = quick();
    o.suites = {"targets", "stages"}, o.data = path("nowhere"), o.quiet = false;
    ASSERT_EQ(code(o), exit_ok) << complained;
    for (const std::string& text : {said, complained}) {
        EXPECT_NE(text.find("targets: no file " + path("nowhere/targets.json")), text.npos) << text;
        EXPECT_NE(text.find("drawings: no script " + path("nowhere/plot.py")), text.npos) << text;
        EXPECT_NE(text.find("by hand: python3 "), text.npos) << text;
    }
    const Json all = Json::parse(text("bench.json"));
    EXPECT_EQ(all["rows"].size(), 1u);
    EXPECT_TRUE(all["targets"].empty());
    EXPECT_NE(all["left_out"].dump().find("nowhere/targets.json"), std::string::npos);
}

TEST_F(BenchFolder, AWrongFileOfFiguresIsRefusedBeforeAnythingIsMeasured)
{
    BenchOptions o = quick();
    o.data = path("data");
    fs::create_directory(folder / "data");
    write_whole(path("data/targets.json"), R"({"schema": "knead.targets/1", "set_for": "x",
        "targets": {"memory": {"name": "m", "must": "little", "aim": 1}}})");
    EXPECT_EQ(code(o), exit_input);
    EXPECT_EQ(complained, "knead: " + path("data/targets.json") +
                              ": /targets/memory/must: expected a number at least 0, found the "
                              "text \"little\"\n");
    EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(BenchFolder, ASuiteThatFailsLeavesTheOthersTheirResults)
{
    BenchOptions o = quick();
    o.suites = {"stages", "scale"}, o.quiet = false;
    o.max_memory = 25;  // too little for the squeeze, enough for the first ball of "scale"
    const int result = code(o);
    EXPECT_EQ(result, exit_resource);
    EXPECT_EQ(complained.find("wrote"), complained.npos) << complained;
    const Json all = Json::parse(text("bench.json"));
    ASSERT_GE(all["rows"].size(), 1u) << complained;
    EXPECT_EQ(all["rows"][0]["suite"], "scale");
    EXPECT_NE(all["left_out"].dump().find("stages: "), std::string::npos);
    EXPECT_NE(all["left_out"].dump().find("GiB are free"), std::string::npos);
}

TEST_F(BenchFolder, WhatWasMeasuredIsKeptFromRowToRow)
{
    BenchOptions o = quick();
    Bench bench(o);
    bench.keep_in((folder / "part.json").string());
    BenchRow row;
    row.suite = "stages", row.name = "first", row.frames = 1;
    for (std::size_t rows = 1; rows <= 2; ++rows, row.name = "second") {
        bench.add(row);
        const Json all = Json::parse(std::ifstream(folder / "part.json"));
        EXPECT_EQ(all["schema"], "knead.bench/1");
        ASSERT_EQ(all["rows"].size(), rows);
        EXPECT_EQ(all["rows"][rows - 1]["name"], row.name);
        EXPECT_NE(all["left_out"].dump().find("the rest: "), std::string::npos);
    }
    EXPECT_TRUE(bench.result.left_out.empty()) << "the run itself goes on";
    bench.result.targets.emplace_back().name = "real time";
    bench.keep();
    EXPECT_EQ(Json::parse(std::ifstream(folder / "part.json"))["targets"].size(), 1u);
    bench.keep_in((folder / "nowhere" / "part.json").string());
    EXPECT_NO_THROW(bench.add(row)) << "what cannot be kept is measured all the same";
    EXPECT_EQ(bench.result.rows.size(), 3u);
    o.suites = {"stages"};
    ASSERT_EQ(code(o), exit_ok) << complained;
    EXPECT_FALSE(fs::exists(folder / "out" / "bench.part.json")) << "bench.json has it all";
}

TEST_F(BenchFolder, HandsTouchWhereTheirShapesReachIntoTheClay)
{
    const Bench bench(quick());
    Scene scene = bench.scene({});
    const HandSource hands(hands_of(scene), scene.hands);
    const int contact = first_contact(scene, hands);
    ASSERT_GT(contact, 10);
    const std::unique_ptr<Simulator> solver = cpu_solver(scene.setup);
    long before = 0, after = 0;
    drive(scene, *solver, &hands, std::max(0, contact - 2), [&](const FrameResult& f) {
        // In the first frame hands that have not come by themselves are found in the clay, which
        // they meet again some frames later.
        if (f.number > 1) (f.number == 2 ? before : after) += f.stats[Count::projected];
        return f.number < 12;
    });
    EXPECT_GT(after, 0);
    EXPECT_LT(before, after);
    // Clay elsewhere, and much more of it, does not hide the ball.
    Particle<double> far{};
    far.x = {0.95, 0.05, 0.05}, far.object = 1;
    Scene both = scene;
    both.setup.particles.insert(both.setup.particles.begin(), 50 * scene.setup.particles.size(),
                                far);
    EXPECT_EQ(first_contact(both, hands), contact);
    scene.hands.at = {0.5, 5, 0.5};
    EXPECT_EQ(first_contact(scene, HandSource(hands_of(scene), scene.hands)), -1);
}

TEST_F(BenchFolder, FramesHandedOverAheadAreTimedAfterTheWarmUp)
{
    const Bench bench(quick());
    const Scene scene = bench.scene({"clock=paper", "paper.substeps=1"});
    const HandSource hands(hands_of(scene), scene.hands);
    const QueuedFrames some = queued(scene, bench.device, &hands, 0, 3, true);
    EXPECT_EQ(some.frames, 3);
    EXPECT_GT(some.frame, 0);
    EXPECT_EQ(some.waits, 0);
    const int end = frames_wanted(scene, &hands, 0);
    EXPECT_EQ(queued(scene, bench.device, &hands, end - 5, 3, true).frames, 0);  // warm-up alone
    EXPECT_EQ(queued(scene, bench.device, &hands, end - 6, 3, true).frames, 2);
}

TEST(Benchmark, LeastBytesAreTheStateInAndOutAndTheNodesOnce)
{
    EXPECT_EQ(min_bytes(1000, 0), 2 * 96);
    EXPECT_EQ(min_bytes(512, 1), 2 * 96 + 2 * 64 * 16 / 512.0);
}

TEST(Benchmark, WhatIsCountedIsSharedAmongTheParticlesAndSetAgainstTheDevicesRates)
{
    BenchRow row;
    row.particles = 1000, row.moved = 0.5, row.substep.median = 1e-6;  // 5e8 a second
    DeviceInfo facts;
    facts.multiprocessors = 10, facts.copy = 1e11;
    // Two stages of a frame of ten substeps, of which half of the particles moved in each.
    const std::vector<StageWork> stages{{"grid", {1e4, 2e5, 3e5, 2e4, 1e-5}},
                                        {"g2p", {9e4, 3e5, 7e5, 1.8e5, 9e-5}}};
    const Counted each = counted_each(stages, 5000, row, facts);
    ASSERT_EQ(each.stages.size(), 2u);
    EXPECT_DOUBLE_EQ(each.stages[0].work.instructions, 2);
    EXPECT_DOUBLE_EQ(each.sum.instructions, 20);
    EXPECT_DOUBLE_EQ(each.sum.memory_bytes, 100);
    EXPECT_DOUBLE_EQ(each.sum.cache_bytes, 200);
    EXPECT_NEAR(each.sum.clock(), 2e9, 1);
    EXPECT_NEAR(each.issue_share, 20 * 5e8 / (4 * 10 * 2e9), 1e-9);
    EXPECT_NEAR(each.copy_share, 100 * 5e8 / 1e11, 1e-9);
    row.substep = {}, row.frame.median = 1e-5, row.moved = 1;  // a surface: 1e8 a second
    EXPECT_NEAR(counted_each(stages, 1000, row, facts).copy_share, 500 * 1e8 / 1e11, 1e-9);
    for (double nothing : {0.0, -1.0, std::nan("")}) {
        EXPECT_TRUE(counted_each(stages, nothing, row, facts).stages.empty());
        EXPECT_EQ(counted_each(stages, nothing, row, facts).issue_share, 0);
    }
    EXPECT_EQ(counted_each({}, 1000, row, facts).issue_share, 0);
    EXPECT_EQ(counted_each(stages, 1000, row, {}).issue_share, 0);
}

TEST(Benchmark, WhatIsCountedIsInTheTable)
{
    BenchResult result;
    result.rows.resize(1);
    result.rows[0].counted.sum = {12.25, 345, 678, 1, 1};
    result.rows[0].counted.issue_share = 0.25;
    const std::string csv = bench_csv(result);
    const std::size_t end = csv.find('\n');
    const auto fields = [](const std::string& line) {
        return std::count(line.begin(), line.end(), ',');
    };
    EXPECT_EQ(fields(csv.substr(0, end)), fields(csv.substr(end + 1)));
    EXPECT_NE(csv.find(",12.25,0.25,345,0,678,"), csv.npos) << csv;
}

TEST(Benchmark, ATargetIsMetInItsOwnDirection)
{
    const auto is = [](bool min, double measured) {
        return met({"", "", min ? 8.0 : 20.0, min ? 12.0 : 10.0, min, measured, ""});
    };
    EXPECT_EQ(is(false, 9), Met::aim);
    EXPECT_EQ(is(false, 10), Met::aim);
    EXPECT_EQ(is(false, 15), Met::must);
    EXPECT_EQ(is(false, 20.1), Met::missed);
    EXPECT_EQ(is(true, 13), Met::aim);
    EXPECT_EQ(is(true, 8), Met::must);
    EXPECT_EQ(is(true, 7.9), Met::missed);
    EXPECT_EQ(is(true, -1), Met::open);
    EXPECT_EQ(is(false, std::nan("")), Met::missed);
}

TEST(Benchmark, APeersLastLineWithATimeIsRead)
{
    PeerRow row;
    ProbePlaces places{};
    const std::string good =
        R"({"substep_us": 12.5, "centre": [1, 2, 3], "extent": [0.1, 0.2, 0.3]})";
    ASSERT_TRUE(understood("[Taichi] version\n{}\n" + good + "\nbye\n", row, places));
    EXPECT_DOUBLE_EQ(row.substep, 12.5e-6);
    EXPECT_EQ(places, (ProbePlaces{1, 2, 3, 0.1, 0.2, 0.3}));
    for (const char* bad :
         {"", "\n\n", "nothing", "[1, 2]", "{\"substep_us\": \"fast\"}", "{\"substep_us\": 0}",
          R"({"substep_us": 1, "centre": [1, 2], "extent": [1, 1, 1]})",
          R"({"substep_us": 1, "centre": [1, 2, "x"], "extent": [1, 1, 1]})",
          R"({"substep_us": 1, "centre": [1, 2, 3]})", "{\"substep_us\": 1"})
        EXPECT_FALSE(understood(bad, row, places)) << bad;
}

TEST(Machine, SaysTheBuildsCommitAndAsksNoDriverThatIsNotThere)
{
    EXPECT_FALSE(knead_commit().empty());
    EXPECT_EQ(machine_facts(false)["commit"], knead_commit());
    EXPECT_FALSE(machine_facts(false).contains("gpu"));
    EXPECT_FALSE(gpu_state("").has_value());
    EXPECT_FALSE(gpu_state("0000:zz:00.0").has_value());
}

}  // namespace
}  // namespace knead
