// The files of figures: what ships with the program, and what is wrong with others.
#include "host/bench/figures.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "tests/folder.h"

namespace knead {
namespace {

TEST(Figures, TheTreesOwnAreReadWhole)
{
    const Figures all = read_figures(figures_folder(""));
    ASSERT_TRUE(all.targets.has_value()) << all.no_targets;
    EXPECT_EQ(all.targets->set_for, "one H200");
    for (const char* key :
         {"substep 137 k", "paper frame",     "host waits",        "real time",
          "hand scale",    "frame 1.1 M",     "rate 1.1 M",        "rate 8.8 M",
          "memory",        "public 137 k",    "public 1.1 M",      "public 8.8 M",
          "localized",     "splats 660k far", "splats near",       "splats 5m-fine",
          "splats cpu",    "splats exact",    "splats eyes",       "gaussians",
          "splat frame",   "splat real time", "splat frame ratio", "taichi"})
        EXPECT_EQ(all.targets->targets.count(key), 1u) << key;
    EXPECT_EQ(all.targets->targets.size(), 24u);
    const Target& rate = all.targets->targets.at("rate 8.8 M");
    EXPECT_TRUE(rate.min);
    EXPECT_EQ(rate.must, 10);
    EXPECT_EQ(rate.aim, 15);
    EXPECT_LT(rate.measured, 0);
    ASSERT_TRUE(all.peers.has_value()) << all.no_peers;
    EXPECT_DOUBLE_EQ(all.peers->public_best.at("1.1 M"), 780e-6);
    EXPECT_DOUBLE_EQ(all.peers->clock, 2.52e9);
    EXPECT_DOUBLE_EQ(all.peers->splat_frame, 25.1e-3);
    EXPECT_DOUBLE_EQ(all.peers->copy, 0.9 * 1008e9);
}

// The names by which kept results are compared.
TEST(Figures, TargetsHaveTheNamesOfTheKeptResults)
{
    const Json kept = read_json("profiling/results/nvidia-h200/bench.json");
    const Figures all = read_figures("profiling");
    std::size_t same = 0;
    for (const auto& [key, target] : all.targets->targets)
        for (const Json& t : kept["targets"])
            same += t["name"] == target.name && t["unit"] == target.unit &&
                    t["must"] == target.must && t["aim"] == target.aim &&
                    t["at_least"] == target.min;
    EXPECT_EQ(same, all.targets->targets.size());
}

TEST(Figures, AFolderWithoutThemIsNoFault)
{
    const Folder folder;
    const Figures none = read_figures(folder / "no");
    EXPECT_FALSE(none.peers.has_value() || none.targets.has_value());
    EXPECT_EQ(none.no_peers, "no file " + folder / "no/peers.json" + " (--data says where)");
    EXPECT_EQ(none.no_targets, "no file " + folder / "no/targets.json" + " (--data says where)");
    EXPECT_EQ(figures_folder("anywhere"), "anywhere");
}

TEST(Figures, WhatIsWrongIsNamedWithFileAndPlace)
{
    const auto said = [](const std::string& name, const std::string& text) {
        const Folder folder;
        write_whole(folder / name, text);
        try {
            read_figures(folder.path().string());
        } catch (const InputError& e) {
            const std::string what = e.what(), file = folder / name;
            EXPECT_EQ(what.rfind(file + ": ", 0), 0u) << what;
            return what.substr(std::min(what.size(), file.size() + 2));
        }
        return std::string("nothing");
    };
    const auto targets = [&](const std::string& list) {
        return said("targets.json",
                    R"({"schema": "knead.targets/1", "set_for": "x", "targets": )" + list + "}");
    };
    EXPECT_EQ(targets("{}"), "nothing");
    EXPECT_EQ(targets("[]").rfind("/targets: expected an object, found an array", 0), 0u);
    EXPECT_EQ(targets(R"({"a": {"must": 1, "aim": 1}})").rfind("/targets/a/name: ", 0), 0u);
    EXPECT_EQ(targets(R"({"a": {"name": "a", "aim": 1}})").rfind("/targets/a/must: ", 0), 0u);
    EXPECT_EQ(targets(R"({"a": {"name": "a", "must": 1, "aim": 2}})"),
              "/targets/a/aim: expected a bound that is not weaker than must, found 2");
    EXPECT_EQ(targets(R"({"a": {"name": "a", "must": 1, "aim": 1, "at_leats": true}})")
                  .rfind("/targets/a/at_leats: unknown key", 0),
              0u);
    EXPECT_EQ(said("targets.json", "{\"schema\": \"knead.targets/2\"}"),
              "/schema: expected \"knead.targets/1\", found \"knead.targets/2\"");
    EXPECT_EQ(said("targets.json", "{").rfind("line 1, column 2", 0), 0u);
    const auto changed = [&](const std::string& pointer, const Json& value) {
        Json good = read_json("profiling/peers.json");
        good[Json::json_pointer(pointer)] = value;
        return said("peers.json", good.dump());
    };
    EXPECT_EQ(changed("/paper/label", "x"), "nothing");
    EXPECT_EQ(changed("/public_best/substep_us/1.1 M", 0),
              "/public_best/substep_us/1.1 M: expected a number above 0 us, found 0");
    EXPECT_EQ(changed("/card/share_of_copy", 2),
              "/card/share_of_copy: expected a number above 0 and at most 1, found 2");
    EXPECT_EQ(changed("/splat_frame/ms", -1),
              "/splat_frame/ms: expected a number above 0 ms, found -1");
    EXPECT_EQ(changed("/card", 2).rfind("/card: expected an object, found 2", 0), 0u);
}

}  // namespace
}  // namespace knead
