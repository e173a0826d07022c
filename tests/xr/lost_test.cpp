// A runtime that goes away or does not answer, from end to end: no crash, no lost results, no
// session that cannot be left; and what is said to people whose runtime is not there.
#include <gtest/gtest.h>

#ifdef KNEAD_XR_PROGRAM
#include "tests/vr/vr_run.h"

namespace knead {
namespace {

class KneadVrLost : public KneadVr {
  protected:
    static constexpr int terminated = exit_terminate;

    // `knead vr` until a line of the runtime's log has `sign`; then it is sent SIGTERM. `took` is
    // how long it went on [s].
    int terminated_at(const std::string& sign, Json script, const std::vector<std::string>& more)
    {
        script["log"] = path("log");
        std::ofstream(path("log"));
        std::ofstream(path("script.json")) << script.dump();
        std::vector<std::string> words{
            "sh",
            "-c",
            "\"$@\" >\"$0/report\" 2>\"$0/said\" & p=$!; n=0; "
            "until grep -q '" +
                sign +
                "' \"$0/log\" || [ $n -gt 1200 ]; do sleep 0.05; n=$((n + 1)); done; sleep 0.5; "
                "date +%s.%N >\"$0/from\"; kill -TERM $p; (sleep 30; kill -KILL $p) >/dev/null "
                "2>&1 & "
                "k=$!; wait $p; code=$?; date +%s.%N >\"$0/to\"; kill $k; exit $code",
            path("."),
            "env",
            "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
            "KNEAD_REPLAY_SCRIPT=" + path("script.json"),
            "OMP_WAIT_POLICY=passive",
            KNEAD_XR_PROGRAM,
            "vr"};
        words.insert(words.end(), scene.begin(), scene.end());
        for (const char* word :
             {"--binding", "egl", "--place", "0,0,0", "--json", "--quiet", "--no-panel"})
            words.push_back(word);
        words.insert(words.end(), more.begin(), more.end());
        std::string said;
        const int code = output_of(words, said, 120);
        double from = 0, to = 0;
        std::ifstream(path("from")) >> from;
        std::ifstream(path("to")) >> to;
        took = to - from;
        std::ifstream in(path("report"));
        report = Json::parse(in, nullptr, false);
        return code;
    }
    void expect_results() const
    {
        for (const char* file : {"headset.json", "mesh.glb", "hands.hands"})
            EXPECT_TRUE(fs::exists(path("out") + "/" + file)) << file;
        EXPECT_TRUE(fs::exists(path("r.hands")));
        ASSERT_TRUE(report.is_object());
        EXPECT_GT(report["simulation"]["frames"], 10);
        EXPECT_GT(report["simulation"]["particles"], 0);
    }
    // What `knead doctor` says of OpenXR under a script, with a variable more.
    Json doctor(const Json& script, const std::string& variable = "KNEAD_NONE=")
    {
        std::ofstream(path("script.json")) << script.dump();
        std::string said;
        EXPECT_EQ(output_of({"env", "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                             "KNEAD_REPLAY_SCRIPT=" + path("script.json"), variable,
                             KNEAD_XR_PROGRAM, "doctor", "--json"},
                            said, 60),
                  exit_ok);
        for (const Json& one : Json::parse(said))
            if (one["what"] == "OpenXR") return one;
        return {};
    }
    // What `knead vr` says on stderr before it gives up.
    std::string refusal(const Json& script)
    {
        std::ofstream(path("script.json")) << script.dump();
        std::vector<std::string> words{"sh",
                                       "-c",
                                       "\"$@\" 2>&1 >/dev/null",
                                       "sh",
                                       "env",
                                       "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                                       "KNEAD_REPLAY_SCRIPT=" + path("script.json"),
                                       KNEAD_XR_PROGRAM,
                                       "vr"};
        words.insert(words.end(), scene.begin(), scene.end());
        std::string said;
        EXPECT_EQ(output_of(words, said, 60), exit_resource);
        return said;
    }

    double took = 0;
    const std::vector<std::string> files{"--record", path("r.hands"), "--out", path("out")};
};

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more)
{
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

// The replay runtime unmaps the memory of its textures with them, as a runtime does whose textures
// are another process's: a drawing command under way faults then. Eyes are large enough for
// drawing to be under way when the runtime goes.
TEST_F(KneadVrLost, ends_its_drawing_before_the_textures_of_a_lost_runtime_go)
{
    Json script = squeeze();
    script["width"] = script["height"] = 1024;
    script["faults"] = Json::array();
    for (int k = 0; k < 6; ++k)
        script["faults"].push_back({{"kind", k % 2 == 0 ? "lose_instance" : "lose_session"},
                                    {"frame", 6 + 3 * k},
                                    {"count", 1}});
    ASSERT_EQ(vr(script, {"--frames", "20"}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["renewals"], 6);
    if (report["headset"]["renderer"].get<std::string>().find("llvmpipe") != std::string::npos) {
        EXPECT_EQ(log.back()["imported"], 7 * 12) << "of seven sessions, four swapchains each";
    }
}

// Each frame of the display that took long would otherwise make the next one take longer.
TEST_F(KneadVrLost, simulates_a_quarter_of_a_second_a_frame_of_the_display_at_most)
{
    Json script = squeeze();
    script["rate"] = 1;
    ASSERT_EQ(vr(script, {"--frames", "6", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_NEAR(report["simulation"]["simulated_s"], 5 * 0.25, 0.02);
    EXPECT_NEAR(report["simulation"]["behind_s"], 5 * 0.75, 1e-6);
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
}

TEST_F(KneadVrLost, is_interrupted_between_the_substeps_of_a_long_frame)
{
    scene[2] = "64";
    Json script = squeeze();
    script["rate"] = 1;
    const int code = terminated_at("\"frame\":1[,}]", script, with({"--deterministic"}, files));
    EXPECT_EQ(code, terminated);
    EXPECT_LT(took, 4) << "a quarter of a second of this clay takes longer";
    for (const char* file : {"headset.json", "mesh.glb", "hands.hands"})
        EXPECT_TRUE(fs::exists(path("out") + "/" + file)) << file;
}

class KneadVrHang : public KneadVrLost, public testing::WithParamInterface<const char*> {};

TEST_P(KneadVrHang, is_left_with_all_results_at_the_first_interrupt)
{
    Json script = squeeze();
    script["render_every"] = 4;
    script["faults"] = {{{"kind", "hang"}, {"frame", 24}, {"call", GetParam()}}};
    EXPECT_EQ(terminated_at("hang", script, files), terminated);
    EXPECT_LT(took, 6) << "a second, on a machine that does nothing else; a hang would last for 10";
    expect_results();
    EXPECT_EQ(report["reason"], "");
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
}

INSTANTIATE_TEST_SUITE_P(Calls, KneadVrHang,
                         testing::Values("xrWaitFrame", "xrBeginFrame", "xrEndFrame", "xrPollEvent",
                                         "xrLocateViews", "xrSyncActions",
                                         "xrAcquireSwapchainImage"),
                         [](const auto& given) { return std::string(given.param); });

// As often in a session as a runtime that hangs: at its beginning and at its end.
TEST_F(KneadVrLost, is_left_while_the_runtime_starts_or_ends)
{
    Json script = squeeze();
    script["faults"] = {{{"kind", "hang"}, {"frame", 0}, {"call", "xrCreateInstance"}}};
    EXPECT_EQ(terminated_at("hang", script, files), terminated);
    EXPECT_LT(took, 6);
    EXPECT_TRUE(fs::exists(path("out") + "/headset.json"));
    EXPECT_EQ(report["simulation"]["frames"], 0);

    script["faults"] = {{{"kind", "hang"}, {"frame", 24}, {"call", "xrDestroyInstance"}}};
    EXPECT_EQ(vr(script, with({"--frames", "24", "--overwrite"}, files)), exit_ok);
    expect_results();
}

TEST_F(KneadVrLost, gives_up_a_runtime_that_does_not_answer_and_keeps_the_work)
{
    Json script = squeeze();
    script["render_every"] = 4;
    script["faults"] = {{{"kind", "hang"}, {"frame", 24}, {"call", "xrWaitFrame"}}};
    EXPECT_EQ(vr(script, with({"--patience", "1"}, files)), exit_resource);
    EXPECT_NE(report["reason"].get<std::string>().find("has not answered"), std::string::npos);
    expect_results();

    // One that is started again, and hangs.
    script["faults"] = {{{"kind", "lose_instance"}, {"frame", 24}},
                        {{"kind", "hang"}, {"frame", 24}, {"call", "xrCreateInstance"}}};
    EXPECT_EQ(vr(script, with({"--patience", "1", "--overwrite"}, files)), exit_resource);
    expect_results();
}

TEST_F(KneadVrLost, goes_on_with_a_runtime_that_answers_again)
{
    Json script = squeeze();
    script["render_every"] = 40;
    script["faults"] = {{{"kind", "hang"}, {"frame", 40}, {"value", 1.5}}};
    ASSERT_EQ(vr(script, {"--frames", "80", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["renewals"], 0);
    EXPECT_EQ(report["simulation"]["frames"], 79);
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
}

TEST_F(KneadVrLost, does_not_draw_where_no_image_comes_free)
{
    Json script = squeeze();
    script["faults"] = {{{"kind", "busy_images"}, {"frame", 10}, {"count", 3}}};
    ASSERT_EQ(vr(script, {"--frames", "30"}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["renewals"], 0);
    EXPECT_EQ(report["simulation"]["frames"], 29);
    EXPECT_LE(report["drawn"], 30 - 3);
    EXPECT_GE(report["drawn"], 30 - 5);
}

// At once, and then less and less often, to once a second; in silence but for a line.
TEST_F(KneadVrLost, looks_for_a_runtime_that_is_away_once_a_second)
{
    Json script = squeeze();
    script["render_every"] = 1000;
    script["log"] = path("log");
    script["faults"] = {{{"kind", "lose_instance"}, {"frame", 30}, {"count", 1000000}}};
    std::ofstream(path("script.json")) << script.dump();
    std::vector<std::string> words{"sh",
                                   "-c",
                                   "\"$@\" 2>&1 >/dev/null",
                                   "sh",
                                   "env",
                                   "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                                   "KNEAD_REPLAY_SCRIPT=" + path("script.json"),
                                   KNEAD_XR_PROGRAM,
                                   "vr"};
    words.insert(words.end(), scene.begin(), scene.end());
    words.insert(words.end(), {"--patience", "3.5"});
    std::string said;
    EXPECT_EQ(output_of(words, said, 60), exit_resource);
    int tries = 0;
    std::ifstream lines(path("log"));
    for (std::string line; std::getline(lines, line);)
        tries += Json::parse(line).contains("absent");
    EXPECT_GE(tries, 2 * 5) << "of which the loader makes two calls each";
    EXPECT_LE(tries, 2 * 12);
    EXPECT_LE(std::count(said.begin(), said.end(), '\n'), 5) << said;
    EXPECT_NE(said.find("the runtime was lost"), std::string::npos) << said;
}

TEST_F(KneadVrLost, and_doctor_say_the_same_of_what_is_to_be_started)
{
    const Json there = doctor(Json::object());
    EXPECT_TRUE(there["there"]);
    EXPECT_EQ(there["headset"], "Scripted headset");
    EXPECT_EQ(there["missing"], Json::array());
    EXPECT_EQ(there["text"].get<std::string>().find("; not "), std::string::npos) << there;
    const Json fewer = doctor({{"without", Json::array({"XR_EXT_user_presence"})}});
    EXPECT_NE(fewer["text"].get<std::string>().find("; not XR_EXT_user_presence"),
              std::string::npos)
        << fewer;

    const Json layer = doctor(Json::object(), "XR_ENABLE_API_LAYERS=XR_APILAYER_none");
    EXPECT_FALSE(layer["there"]);
    EXPECT_NE(layer["text"].get<std::string>().find("install the layers named in"),
              std::string::npos)
        << layer;
    EXPECT_EQ(layer["text"].get<std::string>().find("): start "), std::string::npos) << layer;

    const Json stopped = doctor({{"service", false}});
    EXPECT_FALSE(stopped["there"]);
    const std::string text = stopped["text"];
    const std::string advice = text.substr(0, text.find(" (the runtime is named by"));
    EXPECT_NE(advice.find("): start "), std::string::npos) << text;
    EXPECT_NE(refusal({{"service", false}}).find(advice), std::string::npos);

    const Json none = doctor({{"headset", false}});
    EXPECT_FALSE(none["there"]);
    EXPECT_NE(none["text"].get<std::string>().find("switch it on"), std::string::npos);

    const Json silent =
        doctor({{"faults", {{{"kind", "hang"}, {"frame", 0}, {"call", "xrCreateInstance"}}}}});
    EXPECT_FALSE(silent["there"]);
    EXPECT_NE(silent["text"].get<std::string>().find("has not answered"), std::string::npos);
}

}  // namespace
}  // namespace knead
#endif
