// A report as a person reads it: a line stands only where there is something to say, and a report
// that lacks what every one has is refused by name.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/run/report.h"
#include "tests/reason.h"

namespace knead {
namespace {

using Json = nlohmann::json;

Json least_report()
{
    return Json::parse(R"({
        "context": {"scene": "pot", "device": "cpu"},
        "runs": [{"name": "frame"}, {"name": "frame/stage/p2g", "real_time": 1.5, "p95": 2.5}],
        "knead": {"end": "done", "time": {"limited_by": {"flow": 3, "sound": 0}},
                  "mass": {"exact": true, "last_kg": 0.25}, "volume": {"drift": 0.01},
                  "rest": {"mode": "none"}, "guards": {"strained": 0}, "state_hash": "abc",
                  "left_out": [], "outputs": ["out.ply"], "frame": {"median_ms": 4}}})");
}

bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

TEST(Summary, SaysWhatEveryReportHas)
{
    const Json report = least_report();
    check_report(report, "r.json");
    const std::string text = summary(report);
    EXPECT_EQ(text.find("pot: done, 0 of 0 frames"), 0u) << text;
    for (const char* part :
         {"4.000 ms median", "(250.0 frames/s)", "  p2g              1.500 ms median",
          "limited by flow 3\n", "0.25 kg, unchanged\n", "drift +1.000 %\n", "guards        none\n",
          "state hash    abc\n", "wrote         out.ply\n"})
        EXPECT_TRUE(has(text, part)) << part << " in\n" << text;
    for (const char* part : {"cut  ", "trouble", "moved  ", "between tools", "splats", "hands  ",
                             "softened", "left out", "of the mesh"})
        EXPECT_FALSE(has(text, part)) << part << " in\n" << text;
}

TEST(Summary, SaysMoreWhereThereIsMore)
{
    Json report = least_report();
    Json& k = report["knead"];
    k["cut"] = {{"frame", 7}, {"reached_s", 0.5}, {"substeps", 90}};
    k["frame_s"] = 0.75;
    k["trouble"] = "a disk is full", k["mass"]["exact"] = false;
    k["volume"]["mesh_drift"] = -0.02;
    k["rest"] = {{"mode", "sleep"}, {"moved_share", 0.125}, {"woken_blocks", 11}};
    k["penetration"] = {{"between_most", 5}, {"between_max_mm", 0.5}};
    k["splats"] = {{"count", 30}, {"inside", 20}, {"projected", 2}};
    k["guards"]["strained"] = 4;
    k["hands"] = {{"frames_active", 9}, {"filter_lag_ms", 12.5}};
    k["softened"] = Json::array({{{"text", "ball by 10"}}});
    k["left_out"] = {"a picture"};
    check_report(report, "r.json");
    const std::string text = summary(report);
    for (const char* part :
         {"cut           frame 7 ends at 0.5 of 0.75 s, after 90 substeps\n",
          "trouble       a disk is full\n", "0.25 kg, CHANGED\n", "; of the mesh -2.000 %\n",
          "moved         12.50 % of all particle-substeps, 11 blocks woken\n",
          "between tools 5 particles at most, max 0.5 mm\n",
          "splats        30, 20 of them interior; 2 projections out of tools\n",
          "guards        strained 4\n", "active in 9 frames, filter lag 12.5 ms\n",
          "softened      ball by 10\n", "left out      a picture\n"})
        EXPECT_TRUE(has(text, part)) << part << " in\n" << text;
    k["local"] = Json::object();  // clay comes and goes: its mass is no law
    EXPECT_TRUE(has(summary(report), "0.25 kg, of what is clay just now\n"));
}

TEST(Summary, AReportThatLacksSomethingIsRefusedByName)
{
    const auto refused = [](const char* pointer, const Json& value) {
        Json report = least_report();
        report[Json::json_pointer(pointer)] = value;
        return reason<InputError>([&] { check_report(report, "r.json"); });
    };
    EXPECT_EQ(refused("/knead/end", "done"), "");
    EXPECT_TRUE(has(refused("/knead/end", 3), "r.json: /knead/end: expected string"));
    EXPECT_TRUE(has(refused("/runs/1/name", 3), "/runs/1/name: expected string"));
    EXPECT_TRUE(has(refused("/knead/outputs/0", 3), "/knead/outputs/0: expected string"));
    EXPECT_TRUE(has(refused("/knead/trouble", 3), "/knead/trouble: expected string"));
    EXPECT_TRUE(has(refused("/knead/softened", 3), "/knead/softened: expected array"));
    const Json softened = Json::array({Json::object()});
    EXPECT_TRUE(has(refused("/knead/softened", softened),
                    "/knead/softened/0/text: expected string "
                    "as in every report, found nothing"));
}

}  // namespace
}  // namespace knead
