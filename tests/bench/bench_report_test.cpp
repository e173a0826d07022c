// What knead bench says of rows that a GPU counted, of peers and of targets.
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/bench/bench.h"

namespace knead {
namespace {

using Json = nlohmann::json;

BenchOptions quiet()
{
    BenchOptions o;
    o.device = "cpu", o.scene = "scenes/squeeze.json", o.quick = o.quiet = true;
    return o;
}

class BenchReport : public testing::Test {
  protected:
    bool says(const std::string& text) const
    {
        return bench_text(bench).find(text) != std::string::npos;
    }
    Bench bench{quiet()};
};

// Five instructions' worth of one stage, and another that was timed alone.
BenchRow counted_row()
{
    BenchRow row;
    row.suite = "stages", row.name = "a \"row\"", row.particles = 1000;
    row.frame.median = 2e-3, row.frame.p95 = 3e-3;
    row.substep.median = 1e-4, row.substeps = 20, row.bytes = 64000, row.min_bytes = 250;
    row.surface = 4e-3, row.copy_share = 0.25;
    row.stages = {{"p2g", 1.5e-3}, {"grid", 0.25e-3}};
    row.counted.stages = {{"p2g", {12.5, 96, 160, 3e6, 2e-3}}};
    row.counted.sum = row.counted.stages[0].work;
    row.counted.issue_share = 0.5, row.counted.copy_share = 0.375;
    row.note = "as noted";
    return row;
}

TEST_F(BenchReport, WhatWasCountedStandsBesideTheTimes)
{
    bench.result.rows = {counted_row()};
    EXPECT_TRUE(says("\nstages\n"));
    EXPECT_TRUE(says("100.00 us x 20     0.01 G/s  25.0 % of copy    64 B  + 4.00 ms surface\n"));
    EXPECT_TRUE(
        says("counted a particle: 12.5 instructions (50.0 % of issue), 96 B of memory "
             "(37.5 % of copy; at least 250 B), 160 B of level 2\n"));
    EXPECT_TRUE(says("p2g              1.500 ms    12.50 instructions    96.0 B of memory"));
    EXPECT_TRUE(says("grid             0.250 ms\n"));  // not counted: times alone
    EXPECT_TRUE(says("    as noted\n"));
    EXPECT_FALSE(says("guards:"));
    const Json row = bench_json(bench)["rows"][0];
    EXPECT_EQ(row["instructions_per_particle"], 12.5);
    EXPECT_EQ(row["counted_clock_MHz"], 1500.0);
    EXPECT_EQ(row["stages_counted"]["p2g"]["level_2_bytes"], 160.0);
    EXPECT_FALSE(row["stages_counted"].contains("grid"));
    EXPECT_TRUE(row["splats_seen"].is_null() && row["eye_pixels"].is_null());
    EXPECT_NE(bench_csv(bench.result).find(R"(stages,"a ""row""",)"), std::string::npos);
}

TEST_F(BenchReport, GuardsOfARowAreNamed)
{
    BenchRow row = counted_row();
    row.crowded = 3;
    bench.result.rows = {row};
    EXPECT_TRUE(says("    guards:"));
    EXPECT_TRUE(says(" crowded 3"));
    EXPECT_EQ(bench_json(bench)["rows"][0]["guards"]["crowded"], 3);
}

TEST_F(BenchReport, APictureOfAGpuSaysWhatItDrew)
{
    BenchRow row;
    row.suite = "splats", row.name = "splats: near", row.particles = 6000;
    row.frame.median = 5e-3, row.frame.p95 = 6e-3;
    row.drawn = {258, 276, 4000, 3500, 9000, 12, 61.25};
    bench.result.rows = {row};
    EXPECT_TRUE(
        says("5.000 ms (p95 6.000)  2 x 258 x 276, 4000 splats moved, 3500 seen, "
             "9000 instances, 12 dropped, PSNR 61.2 dB\n"));
    EXPECT_EQ(bench_json(bench)["rows"][0]["instances_dropped"], 12);
    bench.result.rows[0].drawn.visible = 0;
    bench.result.rows[0].drawn.psnr = 0;
    EXPECT_TRUE(says("4000 splats moved\n"));
    EXPECT_TRUE(bench_json(bench)["rows"][0]["instances_dropped"].is_null());
}

TEST_F(BenchReport, APeerIsComparedOrSaysWhyNot)
{
    PeerRow ran, failed;
    ran.name = "ran", ran.substep = 300e-6, ran.ours = 100e-6, ran.apart = 2e-3;
    failed.name = "failed", failed.problem = "not installed";
    bench.result.peers = {ran, failed};
    EXPECT_TRUE(says("300.00 us   ours   100.00 us      3.0 x   the clay 2 mm apart\n"));
    EXPECT_TRUE(says("failed                       not installed\n"));
    const Json peers = bench_json(bench)["peers"];
    EXPECT_NEAR(peers[0]["times_as_long"].get<double>(), 3, 1e-12);
    EXPECT_EQ(peers[1], (Json{{"name", "failed"}, {"problem", "not installed"}}));
}

// At most `must`, better at most `aim`; where more is better, at least.
TEST_F(BenchReport, TargetsAreMetMissedOrOpenByTheirBounds)
{
    Target t;
    t.name = "a time", t.unit = "us", t.must = 10, t.aim = 5;
    const auto at = [&](double measured) {
        t.measured = measured;
        return std::string(met_name(met(t)));
    };
    EXPECT_EQ(at(-1), "open");
    EXPECT_EQ(at(5), "aim");
    EXPECT_EQ(at(10), "must");
    EXPECT_EQ(at(10.1), "MISSED");
    bench.result.targets = {t};
    EXPECT_TRUE(says("<= 10     <= 5           10.1 us  MISSED"));
    t.min = true, t.must = 5, t.aim = 10;
    EXPECT_EQ(at(10), "aim");
    EXPECT_EQ(at(5), "must");
    EXPECT_EQ(at(4.9), "MISSED");
    t.must = t.aim = 0;
    EXPECT_EQ(at(4.9), "open");  // nothing is asked of it
}

}  // namespace
}  // namespace knead
