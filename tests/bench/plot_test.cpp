// profiling/plot.py: what it draws of a bench.json, where Python has matplotlib.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/child.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "tests/bench/has_matplotlib.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class PlotScript : public InFolder {
  protected:
    void SetUp() override
    {
        if (!has_matplotlib()) GTEST_SKIP() << "python3 has no matplotlib here";
    }
    // The exit code; what it said on stdout is kept.
    int draw(const std::string& json, std::vector<std::string> more = {})
    {
        std::vector<std::string> words{"python3", "profiling/plot.py", json, "--out",
                                       folder.string()};
        words.insert(words.end(), more.begin(), more.end());
        said.clear();
        return output_of(words, said);
    }
    int drawn(const Json& rows)
    {
        const Json all = {{"schema", "knead.bench/1"}, {"context", Json::object()}, {"rows", rows}};
        write_whole(path("bench.json"), all.dump());
        return draw(path("bench.json"));
    }
    std::string text(const std::string& name) const { return read_text(path(name), 1 << 24); }
    bool shows(const std::string& name, const std::string& what) const
    {
        return text(name).find(">" + what + "<") != std::string::npos;
    }
    std::string said;
};

TEST_F(PlotScript, DrawsEverySuiteOfTheKeptResults)
{
    const std::string kept = "profiling/results/nvidia-h200/bench.json";
    ASSERT_EQ(draw(kept), 0);
    const Json context = Json::parse(read_text(kept, 1 << 24))["context"];
    const std::string label = "NVIDIA H200 · commit " +
                              context["commit"].get<std::string>().substr(0, 12) + " · " +
                              context["date"].get<std::string>().substr(0, 10);
    const std::pair<const char*, std::vector<std::string>> all[] = {
        {"paper-grid.svg",
         {"A frame of the squeeze by nodes per axis", "substeps and surface",
          "the paper, RTX 4090, with rendering", "ms a frame", "128"}},
        {"paper-substeps.svg", {"A frame of the squeeze by substeps a frame", "30"}},
        {"paper-particles.svg", {"particles per cell", "12"}},
        {"scale.svg", {"Particle-substeps per second of the squeeze", "NVIDIA H200", "10 M"}},
        {"splats.svg", {"660k far"}},
        {"stages.svg", {"sort", "g2p", "0.137 M particles, 64³"}},
        {"localized.svg", {"the rest held still", "whole"}},
        {"surface.svg", {"Making the surface", "5 % of the clay moving"}}};
    for (const auto& [name, texts] : all) {
        ASSERT_TRUE(fs::exists(folder / name)) << name;
        EXPECT_TRUE(shows(name, label)) << name;
        for (const std::string& what : texts)
            EXPECT_TRUE(shows(name, what)) << name << ": " << what;
        EXPECT_NE(said.find(path(name)), said.npos);
    }
    EXPECT_EQ(files(), std::size(all));
    const std::string first = text("scale.svg");
    ASSERT_EQ(draw(kept), 0);
    EXPECT_EQ(text("scale.svg"), first);  // equal results, equal files
}

TEST_F(PlotScript, LeavesOutWhatHasNoPlaceAndSaysWhereNothingWasMeasured)
{
    const auto row = [](const char* suite, double at, const Json& time) {
        return Json{{"suite", suite},
                    {"at", at},
                    {"frame_ms", {{"median", time}}},
                    {"items_per_second", time}};
    };
    ASSERT_EQ(
        drawn({row("paper: grid", 1, 10), row("paper: grid", 2, 0), row("paper: grid", 3, nullptr),
               row("paper: grid", 4, 1000), row("scale", 1, nullptr), row("stages", 1, nullptr),
               row("new < & suite", 1, 1)}),
        0);
    EXPECT_TRUE(shows("scale.svg", "nothing was measured"));
    EXPECT_TRUE(shows("stages.svg", "nothing was measured"));
    EXPECT_FALSE(shows("paper-grid.svg", "nothing was measured"));
    EXPECT_EQ(text("paper-grid.svg").find("nan"), std::string::npos);
    EXPECT_EQ(files(), 4);  // with bench.json
    ASSERT_EQ(drawn({{{"suite", "stages"},
                      {"name", "a < b & c"},
                      {"nodes", {64, 64, 64}},
                      {"particles", 1000},
                      {"stages_ms", {{"g2p", 2}, {"new", 3}, {"sort", 1}, {"fetch", 9}}}}}),
              0);
    EXPECT_TRUE(shows("stages.svg", "6 ms"));
    EXPECT_FALSE(shows("stages.svg", "fetch"));
    ASSERT_EQ(drawn({{{"suite", "splats"},
                      {"name", "splats: 660k far, still"},
                      {"stages_ms", {{"blend", 0.5}, {"project", 0.25}}}},
                     {{"suite", "splats: frame"}, {"name", "a frame"}, {"at", 1}}}),
              0);
    EXPECT_TRUE(shows("splats.svg", "660k far, still"));
    EXPECT_TRUE(shows("splats.svg", "0.75 ms"));
    EXPECT_FALSE(shows("splats.svg", "a frame"));
}

TEST_F(PlotScript, DrawsWithoutOthersFiguresAndRefusesWhatIsNoBenchmark)
{
    EXPECT_EQ(draw("profiling/results/nvidia-h200/bench.json", {"--peers", path("none.json")}), 0);
    EXPECT_FALSE(shows("paper-grid.svg", "the paper, RTX 4090, with rendering"));
    EXPECT_TRUE(shows("paper-grid.svg", "substeps and surface"));
    write_whole(path("bad.json"), "{\"schema\": \"knead.report/1\"}");
    EXPECT_EQ(draw(path("bad.json")), 2);
    write_whole(path("bad.json"), "{");
    EXPECT_EQ(draw(path("bad.json")), 2);
    EXPECT_EQ(draw(path("none.json")), 2);
    EXPECT_EQ(draw("profiling/results/nvidia-h200/bench.json", {"--out", path("no/folder")}), 5);
}

}  // namespace
}  // namespace knead
