// What a headset's frames took, as the report and the panel say it.
#include "host/vr/headset_figures.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace knead {
namespace {

TEST(FrameFigures, count_what_came_too_late_and_keep_the_newest)
{
    FrameFigures figures;
    EXPECT_EQ(figures.margin(), 1);
    FrameParts quick, slow;
    quick.period = slow.period = 0.011;
    quick.draw = 0.004, quick.wait = 0.5, quick.latency = 0.011;
    slow.draw = 0.02;
    for (int k = 0; k < 500; ++k) figures.add(quick);
    EXPECT_NEAR(figures.margin(), 1 - 4.0 / 11, 1e-9) << "waiting is no work";
    EXPECT_TRUE(figures.is_comfortable());
    EXPECT_EQ(figures.missed(), 0);
    for (int k = 0; k < 200; ++k) figures.add(slow);
    EXPECT_FALSE(figures.is_comfortable());
    EXPECT_EQ(figures.missed(), 200);
    EXPECT_EQ(figures.recent().size(), FrameFigures::kept);
    EXPECT_EQ(figures.recent().back().draw, slow.draw);
    const auto report = figures.figures();
    EXPECT_NEAR(report["work_ms"]["median"], 4, 1e-3);
    EXPECT_NEAR(report["work_ms"]["max"], 20, 1e-3);
    EXPECT_NEAR(report["motion_to_dent_frames"]["median"], 1, 1e-5);
    EXPECT_FALSE(report.contains("splat_scale")) << "no splats";
}

TEST(FrameFigures, list_the_late_frames_and_what_took_their_time)
{
    FrameFigures figures;
    FrameParts good;
    good.period = good.interval = 0.01, good.draw = 0.004;
    FrameParts slow = good, far = good, skipped = good;
    slow.draw = 0.015, far.locate = 0.03, far.interval = 0.02, skipped.interval = 0.05;
    for (const FrameParts& frame : {good, slow, good, far, skipped, good}) figures.add(frame);
    const auto report = figures.figures();
    EXPECT_EQ(report["longer_than_a_period"], 2);
    EXPECT_EQ(report["longer_than_two_periods"], 2);
    EXPECT_EQ(report["left_out"], 1 + 4);
    ASSERT_EQ(report["late_frames"].size(), 3u);
    EXPECT_EQ(report["late_frames"][0]["frame"], 1);
    EXPECT_EQ(report["late_frames"][1]["frame"], 3);
    EXPECT_NEAR(report["late_frames"][1]["locate_ms"], 30, 1e-6);
    EXPECT_NEAR(report["late_frames"][1]["work_ms"], 34, 1e-6);
    EXPECT_EQ(report["late_frames"][2]["frame"], 4);
    EXPECT_NEAR(report["late_frames"][2]["interval_ms"], 50, 1e-6);
    EXPECT_FALSE(report.contains("motion_to_dent_ms")) << "there was no simulation";
    EXPECT_EQ(figures.summary().find("dent"), std::string::npos);
    for (int k = 0; k < 1000; ++k) figures.add(slow);
    EXPECT_EQ(figures.figures()["late_frames"].size(), FrameFigures::most_listed);
}

TEST(FrameFigures, tell_how_coarse_splats_were)
{
    FrameFigures figures;
    EXPECT_EQ(figures.summary().find("splats"), std::string::npos);
    FrameParts frame;
    frame.period = 0.011, frame.scale = 0.8f;
    figures.add(frame);  // none were in sight
    frame.splats = 0.002, frame.splat_scale = 0.5f;
    for (int k = 0; k < 9; ++k) figures.add(frame);
    frame.splat_scale = 0.25f;
    figures.add(frame);
    const auto report = figures.figures();
    EXPECT_NEAR(report["eye_scale"]["median"], 0.8, 1e-6);
    EXPECT_NEAR(report["splat_scale"]["median"], 0.5, 1e-6);
    EXPECT_NEAR(report["splat_scale"]["min"], 0.25, 1e-6);
    EXPECT_NEAR(report["splats_ms"]["max"], 2, 1e-5);
    EXPECT_NE(figures.summary().find("relative resolution 50 %, 25 % at least"), std::string::npos)
        << figures.summary();
}

}  // namespace
}  // namespace knead
