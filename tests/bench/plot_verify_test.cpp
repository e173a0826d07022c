// profiling/plot_verify.py: what it draws of a verify.json, where Python has matplotlib.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/bench/figures.h"
#include "tests/bench/has_matplotlib.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class PlotVerify : public InFolder {
  protected:
    void SetUp() override
    {
        if (!has_matplotlib()) GTEST_SKIP() << "python3 has no matplotlib here";
    }
    std::string draw_all(const Json& rows, const Json& checks)
    {
        const Json all = {{"schema", "knead.verify/1"},
                          {"context", Json::object()},
                          {"rows", rows},
                          {"checks", checks}};
        write_whole(path("verify.json"), all.dump());
        said.clear();
        return draw("profiling", "plot_verify.py", {path("verify.json")}, said);
    }
    bool is_picture(const std::string& name) const
    {
        return fs::exists(folder / name) && read_text(path(name), 1 << 24).substr(1, 3) == "PNG";
    }
    std::string said;
};

Json point(const char* scene, double cells, Json error, double seconds, bool usual)
{
    return {{"table", std::string("error against run time: ") + scene},
            {"name", "a setting"},
            {"outcome", usual ? "front" : "beaten by another"},
            {"numbers",
             {{"error_mm", error},
              {"seconds", seconds},
              {"cells", cells},
              {"per_cell", 8},
              {"courant", 0.8},
              {"double", 0},
              {"default", usual ? 1 : 0}}}};
}

TEST_F(PlotVerify, DrawsWhatThereIs)
{
    const Json ended = {
        {"table", "stability map"},
        {"name", "a case whose name is much longer than what a cell can hold of it"},
        {"outcome", "FAILED: ended by signal 11"},
        {"numbers", Json::object()}};
    const Json margin = {{"name", "margin of the substep: clay"},
                         {"measured", 1.25},
                         {"bound", 1.5},
                         {"verdict", "FAILED"}};
    const Json ball = {
        {"table", "surface of a ball of 0.5 m on 64 cells/m"},
        {"name", "2 nodes a cell, taubin 5"},
        {"outcome", "front"},
        {"numbers", {{"error_mm", 5}, {"rough_mm", 0.4}, {"seconds", 1e-4}, {"default", 1}}}};
    EXPECT_EQ(
        draw_all(Json::array({point("squeeze", 16, 4, 0.1, true), point("squeeze", 32, 1, 1, true),
                              point("squeeze", 32, nullptr, 1, false), ball, ended}),
                 Json::array({margin})),
        "");
    for (const char* name :
         {"workprecision.png", "convergence.png", "surface.png", "stability.png", "margins.png"}) {
        EXPECT_TRUE(is_picture(name)) << name;
        EXPECT_NE(said.find(path(name)), said.npos);
    }
}

TEST_F(PlotVerify, LeavesOutWhatWasNotMeasuredAndRefusesWhatIsNoVerification)
{
    EXPECT_EQ(draw_all(Json::array(), Json::array()), "");
    EXPECT_EQ(said, "");
    EXPECT_EQ(draw_all(Json::array({point("squeeze", 16, 4, 0.1, true)}), Json::array()), "");
    EXPECT_TRUE(is_picture("workprecision.png"));
    EXPECT_FALSE(fs::exists(folder / "margins.png"));
    EXPECT_NE(draw_all(1, 2).find("the script ended with 2"), std::string::npos);
}

}  // namespace
}  // namespace knead
