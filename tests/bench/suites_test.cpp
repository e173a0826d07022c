// The suites of knead bench, each on a soft ball of few particles: which cases there are, and what
// holds of them whatever they take.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

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
    Json measured(const std::string& suite)
    {
        write_whole(path("soft.json"), soft);
        BenchOptions o;
        o.suites = {suite}, o.device = "cpu", o.scene = path("soft.json"), o.out = path("out");
        o.quick = true, o.case_limit = 0.01;
        testing::internal::CaptureStderr();
        testing::internal::CaptureStdout();
        const int code = ended([&] { return bench_verb(o); });
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

TEST_F(Suites, TargetsAreMeasuredOrSaidToBeOpen)
{
    const Json all = measured("targets");
    ASSERT_GT(all["targets"].size(), 10u);
    int open = 0;
    for (const Json& target : all["targets"]) open += target["met"] == "open";
    EXPECT_GT(open, 0);  // the sizes that --quick leaves out, and the GPU's
    EXPECT_LT(open, int(all["targets"].size()) / 2);
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
