// The suites of knead bench, each on a soft ball of few particles: which cases there are, and what
// holds of them whatever they take.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/bench/bench.h"
#include "host/cli/verbs.h"
#include "tests/folder.h"

namespace knead {
namespace {

const char* const soft = R"({
    "schema": "knead.scene/1", "name": "soft",
    "domain": {"edge": 1.0, "cells": 64},
    "objects": [{"shape": "sphere", "centre": [0.5, 0.3, 0.5], "diameter": 0.5, "per_cell": 2,
                 "material": {"preset": "clay", "young": 2e3, "yield": 1e2}}],
    "hands": {"recording": "squeeze", "zoom": 2.5, "at": [0.5, 0.3, 0.5]},
    "surface": {"nodes": 32}
})";

class Suites : public InFolder {
  protected:
    // The results of one suite.
    Json measured(const std::string& suite, BenchOptions o = {})
    {
        write_whole(path("soft.json"), soft);
        o.suites = {suite}, o.device = "cpu", o.scene = path("soft.json"), o.out = path("out");
        o.quick = true, o.case_limit = 0.01;
        testing::internal::CaptureStderr();
        testing::internal::CaptureStdout();
        const int code = run_and_report([&] { return bench_verb(o); });
        said = testing::internal::GetCapturedStdout();
        const std::string complained = testing::internal::GetCapturedStderr();
        EXPECT_EQ(code, exit_ok) << complained;
        return read_json(path("out/bench.json"));
    }
    std::string said;
};

// Rows by the suite's part that they belong to.
std::map<std::string, std::vector<Json>> parts(const Json& all)
{
    std::map<std::string, std::vector<Json>> found;
    for (const Json& row : all["rows"]) found[row["suite"]].push_back(row);
    return found;
}

TEST_F(Suites, PaperVariesOneQuantityAtATime)
{
    const auto rows = parts(measured("paper"));
    ASSERT_EQ(rows.size(), 3u);
    std::size_t before = 0;
    for (const Json& row : rows.at("paper: grid")) {
        EXPECT_GT(row["particles"], before);
        before = row["particles"];
    }
    for (const Json& row : rows.at("paper: substeps"))
        EXPECT_EQ(row["substeps_per_frame"], row["at"]) << row.dump();
    const std::vector<Json>& each = rows.at("paper: particles per cell");
    EXPECT_NEAR(each.back()["particles"].get<double>() / each.front()["particles"].get<double>(),
                12.0 / 4, 0.02);
}

TEST_F(Suites, ScaleGrowsToTheMostParticlesThatAreAskedFor)
{
    BenchOptions o;
    o.max_particles = 3.5e4;
    const auto rows = parts(measured("scale", o)).at("scale");
    ASSERT_EQ(rows.size(), 2u);
    const double first = rows[0]["particles"], second = rows[1]["particles"];
    EXPECT_NEAR(second / first, std::pow(40.0 / 28, 3), 0.1);  // of the lattices' cells
    EXPECT_EQ(rows[1]["at"].get<double>(), second);
}

TEST_F(Suites, ScaleStopsWhereTheMemoryEndsAndSaysSo)
{
    BenchOptions o;
    o.max_memory = 1;
    const Json all = measured("scale", o);
    EXPECT_TRUE(all["rows"].empty());
    std::vector<std::string> sizes;
    for (const std::string why : all["left_out"])
        if (why.starts_with("scale: ")) sizes.push_back(why);
    ASSERT_EQ(sizes.size(), 1u) << all["left_out"].dump();  // no larger one is tried
    EXPECT_EQ(sizes[0].find("scale: 28^3 nodes: "), 0u) << sizes[0];
    EXPECT_NE(sizes[0].find("GiB of the host"), std::string::npos) << sizes[0];
}

TEST_F(Suites, TenDeterministicRunsEndInOneHash)
{
    const auto rows = parts(measured("deterministic"));
    ASSERT_EQ(rows.at("deterministic").size(), 2u);
    EXPECT_NE(rows.at("deterministic")[1]["note"].get<std::string>().find("one hash in ten runs"),
              std::string::npos);
}

TEST_F(Suites, ASurfaceTakesLongerOnMoreNodesAndNamesItsParts)
{
    const auto rows = parts(measured("surface"));
    ASSERT_EQ(rows.at("surface").size(), 2u);
    for (const Json& row : rows.at("surface"))
        for (const char* part : {"density", "march", "smooth"})
            EXPECT_GT(row["stages_ms"][part], 0) << row.dump();
    EXPECT_EQ(rows.at("surface")[0]["state_hash"],
              rows.at("surface")[1]["state_hash"]);  // of the same clay
}

TEST_F(Suites, SplatsAreDrawnComparedAndCarriedByClay)
{
    const auto rows = parts(measured("splats"));
    ASSERT_EQ(rows.size(), 4u);
    const std::vector<Json>& drawn = rows.at("splats");
    ASSERT_EQ(drawn.size(), 4u);
    for (const Json& row : drawn) {
        EXPECT_GT(row["frame_ms"]["median"], 0) << row.dump();
        EXPECT_EQ(row["particles"], 6000);
        EXPECT_EQ(row["eye_pixels"], (Json{258, 276}));
        EXPECT_TRUE(row["instances"].is_null());  // of a GPU: never invented
        EXPECT_TRUE(row["substep_us"]["median"] == 0 && row["items_per_second"].is_null());
    }
    EXPECT_EQ(drawn[0]["splats_moved"], 6000);
    EXPECT_EQ(drawn[2]["splats_moved"], 0);
    EXPECT_NE(drawn[0]["state_hash"], drawn[1]["state_hash"]);  // from far and from near
    EXPECT_NE(drawn[0]["state_hash"], drawn[2]["state_hash"]);  // twisted or not
    EXPECT_NE(drawn[0]["state_hash"], drawn[3]["state_hash"]);  // all of it fine or not
    EXPECT_NE(drawn[3]["note"].get<std::string>().find("% of the pixels"), std::string::npos);
    const std::vector<Json>& exact = rows.at("splats: picture");
    ASSERT_EQ(exact.size(), 2u);
    EXPECT_GE(exact[0]["psnr_dB"], 60);  // the aim: rounding to float and to keys of depth
    EXPECT_LT(exact[0]["psnr_dB"], 200);
    EXPECT_GE(exact[1]["psnr_dB"], 30);
    const std::vector<Json>& substeps = rows.at("splats: substep");
    ASSERT_EQ(substeps.size(), 2u);
    EXPECT_EQ(substeps[0]["state_hash"], substeps[1]["state_hash"]);  // Gaussians push nothing
    EXPECT_GT(substeps[1]["bytes"], substeps[0]["bytes"]);
    for (const Json& row : rows.at("splats: frame")) {
        EXPECT_EQ(row["splats_moved"], 3000) << row.dump();
        const Json& stages = row["stages_ms"];
        EXPECT_GT(stages["substeps and surface"], 0);
        EXPECT_NEAR(
            row["frame_ms"]["median"].get<double>(),
            stages["substeps and surface"].get<double>() + stages["both eyes"].get<double>(), 1e-9);
    }
    EXPECT_EQ(rows.at("splats: frame")[0]["substeps_per_frame"], 5);
    EXPECT_NE(said.find("2 x 258 x 276, 6000 splats moved"), said.npos) << said;
}

TEST_F(Suites, TargetsAreMeasuredOrSaidToBeOpen)
{
    const Json all = measured("targets");
    ASSERT_GT(all["targets"].size(), 10u);
    int open = 0, measured = 0;
    for (const Json& target : all["targets"]) {
        open += target["met"] == "open";
        measured += !target["measured"].is_null();
    }
    EXPECT_GT(open, 0);  // the sizes that --quick leaves out, and the GPU's
    EXPECT_GT(measured, 10);
    EXPECT_NE(said.find("137 k particles"), said.npos);
    // The clay near the hands is a twentieth, and less than all moves where the rest may sleep.
    const auto rows = parts(all);
    ASSERT_EQ(rows.at("localized").size(), 4u);
    EXPECT_NEAR(rows.at("localized")[0]["particles"].get<double>() /
                    rows.at("localized")[3]["particles"].get<double>(),
                0.05, 0.005);
    EXPECT_LT(rows.at("localized")[2]["moved_share"], 0.5);
    EXPECT_EQ(rows.at("localized")[3]["moved_share"], 1.0);
}

}  // namespace
}  // namespace knead
