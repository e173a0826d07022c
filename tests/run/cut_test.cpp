// Frames that would not end, and what is left of one that was cut short.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/bench/ball.h"
#include "host/cli/progress.h"
#include "host/run/report.h"
#include "host/scene/foresight.h"
#include "host/session/backend.h"
#include "tests/folder.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

double now()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Powers of two: sums of substeps are exact.
constexpr double step = 0x1p-13, frame = 16 * step;

std::vector<std::unique_ptr<Simulator>> both(const Setup& setup)
{
    std::vector<std::unique_ptr<Simulator>> all;
    all.push_back(cpu_solver(setup));
    all.push_back(make_solver(setup, {DeviceKind::cpu_double}));
    return all;
}

Setup falling()
{
    Setup s = ball(16);
    s.step.fixed = step, s.threads = 1;
    return s;
}

TEST(CutFrame, IsTheShorterFrame)
{
    auto cut = both(falling()), shorter = both(falling());
    for (std::size_t i = 0; i < cut.size(); ++i) {
        int polls = 0;
        cut[i]->set_stop_check([&](const FrameProgress& part) {
            EXPECT_EQ(part.substeps, ++polls);
            EXPECT_EQ(part.reached, part.substeps * step);
            EXPECT_EQ(part.duration, frame);
            return part.substeps == 3;
        });
        const Motion still = no_motion();
        const FrameStats stats = cut[i]->advance(still, frame);
        const FrameStats whole = shorter[i]->advance(still, 3 * step);
        EXPECT_TRUE(stats.cut && !whole.cut);
        EXPECT_EQ(stats.substeps, 3);
        EXPECT_EQ(stats.reached, 3 * step);
        EXPECT_TRUE(same_bits(cut[i]->particles(), shorter[i]->particles())) << cut[i]->name();
        // The next one is whole, and asks nobody any more.
        cut[i]->set_stop_check({});
        EXPECT_EQ(cut[i]->advance(still, frame).substeps, 16);
        EXPECT_EQ(polls, 3);
    }
}

// Where it stood when it was looked in on, and the one that was submitted behind it does nothing.
TEST(CutFrame, OfAGpuIsTheShorterFrame)
{
    if (!gpu_present()) GTEST_SKIP() << "no GPU here";
    knead::Setup setup = falling();
    setup.gravity = {}, setup.deterministic = true;
    const auto cut = gpu_solver(setup, 0), shorter = gpu_solver(setup, 0);
    for (const bool behind : {false, true}) {
        int polls = 0;
        const auto watched = [&](const FrameProgress& part) {
            EXPECT_GT(part.substeps, 0);
            EXPECT_EQ(part.duration, 0x1p20 * frame);  // minutes
            return ++polls == 2;
        };
        cut->set_stop_check(watched);
        cut->submit(no_motion(), 0x1p20 * frame);
        if (behind) cut->submit(no_motion(), 0x1p20 * frame);
        const FrameStats stats = cut->collect();
        EXPECT_TRUE(stats.cut);
        EXPECT_EQ(polls, 2);
        EXPECT_GT(stats.substeps, 0);
        EXPECT_EQ(stats.reached, stats.substeps * step);
        if (behind) {
            const FrameStats none = cut->collect();
            EXPECT_TRUE(none.cut);
            EXPECT_EQ(none.substeps, 0);
            EXPECT_EQ(none.reached, 0);
        }
        cut->set_stop_check({});
        EXPECT_EQ(shorter->advance(no_motion(), stats.reached).substeps, stats.substeps);
        EXPECT_TRUE(same_bits(cut->particles(), shorter->particles()));
        // The next one is whole.
        EXPECT_EQ(cut->advance(no_motion(), frame).substeps, 16);
        EXPECT_EQ(shorter->advance(no_motion(), frame).substeps, 16);
        EXPECT_TRUE(same_bits(cut->particles(), shorter->particles()));
    }
}

TEST(CutFrame, ALoopThatIsGoneIsNotAsked)
{
    const auto solver = cpu_solver(falling());
    SessionLoopOptions options;
    options.duration = frame, options.hand_rate = 90, options.frames = 1;
    options.interrupted = [] { return true; };
    {
        SessionLoop loop(
            *solver, [](double, double) { return no_motion(); }, options);
        EXPECT_FALSE(loop.step());
    }
    EXPECT_FALSE(solver->advance(no_motion(), frame).cut);
}

class CutRun : public InFolder {
  protected:
    Scene scene(const std::vector<std::string>& settings, const char* more = "") const
    {
        const std::string text =
            std::string(R"({"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16},
                "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1}])") +
            more + "}";
        write_whole(path("scene.json"), text);
        Scene s = read_scene(path("scene.json"), settings);
        s.setup.threads = 1;
        build(s, std::size_t(1) << 32);
        return s;
    }
};

const char* const endless = "step.fixed=1e-30";

TEST_F(CutRun, TheTimeLimitActsWithinAFrame)
{
    std::vector<DeviceKind> kinds{DeviceKind::cpu, DeviceKind::cpu_double};
    if (gpu_present()) kinds.push_back(DeviceKind::cuda);
    for (const DeviceKind kind : kinds) {
        const Scene s = scene({endless, "step.most_substeps=2000000000"});
        const auto solver = make_solver(s.setup, {kind});
        BatchRunOptions options;
        options.frames = 5, options.time_limit = 0.2, options.last_mesh = true;
        const double begin = now();
        const RunRecord record = run_frames(s, *solver, nullptr, options, {});
        EXPECT_LT(now() - begin, 5);  // a frame would take 10^28 substeps
        EXPECT_EQ(record.end, End::time_limit);
        ASSERT_EQ(record.rows.size(), 1u);
        EXPECT_TRUE(record.rows[0].stats.cut && record.rows[0].audited && record.rows[0].meshed);
        EXPECT_LT(record.rows[0].simulated, 1e-20);
        const Json k = report(s, record, {})["knead"];
        EXPECT_EQ(k["cut"]["frame"], 1);
        EXPECT_EQ(k["cut"]["substeps"], record.rows[0].stats.substeps);
        EXPECT_NE(summary(report(s, record, {})).find("cut  "), std::string::npos);
    }
}

TEST_F(CutRun, SaysWhereTheHandsWereThen)
{
    const Scene s = scene({"frame_rate=64", "step.fixed=0.0009765625"});  // 16 a frame
    const auto solver = cpu_solver(s.setup);
    BatchRunOptions options;
    options.frames = 5;
    int parts = 0;
    RunObserver watch;
    watch.on_progress = [&](int number, const FrameProgress& part) {
        EXPECT_EQ(number, 1 + parts++ / 15);  // none after a frame's last substep
        EXPECT_DOUBLE_EQ(part.duration, 1.0 / 64);
    };
    watch.stop = [&] { return parts == 15 + 4; };
    const RunRecord record = run_frames(s, *solver, nullptr, options, watch);
    EXPECT_EQ(record.end, End::interrupted);
    ASSERT_EQ(record.rows.size(), 2u);
    EXPECT_EQ(record.rows[1].stats.substeps, 5);
    EXPECT_DOUBLE_EQ(record.rows[1].simulated, (1 + 5.0 / 16) / 64);
    EXPECT_DOUBLE_EQ(record.rows[1].hand_time, (1 + 5.0 / 16) / 64);
}

TEST_F(CutRun, WhatAsksForTooManySubstepsIsRefused)
{
    const auto refused = [&](const std::vector<std::string>& settings) -> std::string {
        try {
            check_substeps(scene(settings));
        } catch (const InputError& e) {
            return e.what();
        }
        return "accepted";
    };
    EXPECT_NE(refused({endless}).find("/step/fixed"), std::string::npos);
    EXPECT_NE(refused({"step.largest=1e-9"}).find("/step/largest"), std::string::npos);
    EXPECT_NE(
        refused({"clock=paper", "paper.substeps=10000", "step.fixed=1e-9"}).find("step/fixed"),
        std::string::npos);
    const std::string liquid = "objects.0.material.preset=viscous-liquid";
    EXPECT_NE(
        refused({liquid, "objects.0.material.viscosity=1e9"}).find("/objects/0/material/viscosity"),
        std::string::npos);
    EXPECT_NE(refused({"objects.0.material.young=1e12", "objects.0.material.density=1"})
                  .find("/objects/0/material/young"),
              std::string::npos);
    EXPECT_EQ(refused({"step.largest=1e-6"}), "accepted");
    EXPECT_EQ(refused({"step.largest=1e-9", "step.most_substeps=100000000"}), "accepted");
}

TEST_F(CutRun, WhatIsForeseenIsWhatTheFirstFrameTakes)
{
    const std::string liquid = "objects.0.material.preset=viscous-liquid";
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
        {{}, "objects.0.material.young"},
        {{"step.largest=1e-4"}, "step.largest"},
        {{"step.fixed=2e-4"}, "step.fixed"},
        {{"clock=paper"}, "paper.dt"},
        {{liquid}, "objects.0.material.bulk"},
        {{liquid, "objects.0.material.viscosity=1e4"}, "objects.0.material.viscosity"},
        {{"objects.0.velocity=[60,0,0]", "frame_rate=1000", "gravity=[0,0,0]"},
         "objects.0.velocity"},
        {{"objects.0.material.young=1", "frame_rate=1000"}, "frame_rate"}};
    for (const auto& [settings, key] : cases) {
        const Scene s = scene(settings);
        const Foresight f = foresee(s);
        EXPECT_EQ(f.key, key);
        const auto solver = cpu_solver(s.setup);
        const FrameStats stats = solver->advance(no_motion(), frame_duration(s));
        // A number that is rounded up is one more where the clay gets the least bit faster.
        EXPECT_NEAR(stats.substeps, f.substeps, std::max(1.0, 0.1 * f.substeps)) << key;
        EXPECT_NEAR(stats.dt_max, f.dt, 0.1 * f.dt) << key;
    }
}

TEST_F(CutRun, AFrameThatTurnsOutTooLongEndsTheRun)
{
    const Scene s = scene({"step.most_substeps=30", "step.fixed=1e-4"});
    const auto solver = cpu_solver(s.setup);
    BatchRunOptions options;
    options.frames = 5;
    const RunRecord record = run_frames(s, *solver, nullptr, options, {});
    EXPECT_EQ(record.end, End::substeps);
    EXPECT_EQ(record.rows.at(0).stats.substeps, 30);
    EXPECT_NE(record.failure.find("step.most_substeps"), std::string::npos);
}

TEST(Progress, TellsHowFarAFrameIs)
{
    EXPECT_NE(progress_line(50, 100, 5, 0.07).find("50/100 + 7 %"), std::string::npos);
    EXPECT_EQ(progress_line(50, 100, 5).find('%'), std::string::npos);
}

}  // namespace
}  // namespace knead
