// `knead vr` from end to end, without a screen: the real loader, the replay runtime, software GL.
// To renew the goldens, look at what KNEAD_GOLDEN_OUT=DIR makes, and copy it to tests/vr/golden.
#include <gtest/gtest.h>

#ifdef KNEAD_XR_PROGRAM
#include <algorithm>
#include <cstdlib>

#include "tests/vr/vr_run.h"

namespace knead {
namespace {

TEST_F(KneadVr, plays_the_squeeze_and_shows_it_to_both_eyes)
{
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 100;
    ASSERT_EQ(vr(script, {"--frames", "300", "--record", path("r.hands"), "--out", path("out")}),
              exit_ok);
    expect_whole_squeeze(3);
    EXPECT_NEAR(report["display"]["rate_hz"], 90, 0.01);
    EXPECT_GT(report["length_s"], 0);
    for (const char* file : {"headset.json", "mesh.glb", "hands.hands"})
        EXPECT_TRUE(fs::exists(path("out") + "/" + file)) << file;
}

TEST_F(KneadVr, draws_what_its_goldens_show)
{
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 75;
    ASSERT_EQ(vr(script, {"--frames", "80"}), exit_ok);
    expect_sound();
    if (const char* out = std::getenv("KNEAD_GOLDEN_OUT"))
        for (const char* name : goldens)
            fs::copy_file(path("dump") + "/" + name, fs::path(out) / name,
                          fs::copy_options::overwrite_existing);
    expect_goldens();
}

TEST_F(KneadVr, says_before_what_a_frame_takes_on_the_cells_that_are_asked_for)
{
    ASSERT_EQ(vr(squeeze(), {"--frames", "3"}), exit_ok);
    const Json& settings = report["settings"];
    EXPECT_NE(std::find(settings.begin(), settings.end(), "domain.cells=16"), settings.end());
    const int coarse = report["simulation"]["particles"];
    scene[2] = "32";
    ASSERT_EQ(vr(squeeze(), {"--frames", "3"}), exit_ok);
    EXPECT_NEAR(double(report["simulation"]["particles"]) / coarse, 8, 0.5);
    EXPECT_NE(messages({}).find(" a frame on this machine"), std::string::npos);
    EXPECT_EQ(messages({"--quiet"}).find("on this machine"), std::string::npos);
}

TEST_F(KneadVr, says_where_the_room_behind_the_clay_is_not_shown)
{
    const std::vector<std::string> arguments{"--see-through"};
    EXPECT_NE(messages(arguments).find("--see-through"), std::string::npos);
    EXPECT_EQ(messages({}).find("--see-through"), std::string::npos);
    Json script = squeeze();
    script["passthrough"] = true;
    EXPECT_EQ(messages(arguments, script).find("--see-through"), std::string::npos);
}

// At 6 frames a second the recorded hands touch; at 3 none does, and that is said.
TEST_F(KneadVr, says_where_tracking_is_too_slow_to_shape)
{
    const auto said = [&](double rate) {
        Json script = squeeze();
        script["rate"] = rate;
        return messages({"--frames", "12", "--hands-only", "--record",
                         path(std::to_string(int(rate)) + ".hands")},
                        script);
    };
    EXPECT_NE(said(3).find("tracking is too slow to shape: 3.0 Hz"), std::string::npos);
    EXPECT_EQ(said(6).find("too slow"), std::string::npos);
}

struct Strike {
    const char *kind, *side;
    int frame, count, renewals;
};
class KneadVrFault : public KneadVr, public testing::WithParamInterface<Strike> {};

// Whatever strikes: all frames are played, the hands are recorded, and they bring the clay to the
// same state again.
TEST_P(KneadVrFault, loses_no_work)
{
    const Strike& strike = GetParam();
    Json script = squeeze();
    script["render_every"] = 40;
    Json fault = {{"kind", strike.kind}, {"frame", strike.frame}, {"count", strike.count}};
    if (*strike.side) fault["side"] = strike.side;
    script["faults"] = {fault};
    ASSERT_EQ(vr(script, {"--frames", "120", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["renewals"], strike.renewals);
    EXPECT_EQ(report["simulation"]["frames"], 119);
    EXPECT_EQ(report["simulation"]["trouble"], "");
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
}

INSTANTIATE_TEST_SUITE_P(
    Strikes, KneadVrFault,
    testing::Values(Strike{"lose_session", "", 60, 1, 1}, Strike{"lose_instance", "", 60, 4, 1},
                    Strike{"take_off", "", 60, 20, 0}, Strike{"unworn", "", 60, 10, 0},
                    Strike{"lose_hand", "left", 60, 10, 0}, Strike{"invalid_joints", "", 60, 10, 0},
                    Strike{"invalid_fingers", "right", 60, 10, 0},
                    Strike{"leap", "right", 60, 10, 0}),
    [](const auto& given) { return std::string(given.param.kind); });

TEST_F(KneadVr, gives_up_on_a_runtime_that_stays_away_and_keeps_the_work)
{
    Json script = squeeze();
    script["render_every"] = 1000;
    script["faults"] = {{{"kind", "lose_instance"}, {"frame", 60}, {"count", 1000000}}};
    EXPECT_EQ(vr(script, {"--frames", "120", "--patience", "0.2", "--out", path("out")}),
              exit_resource);
    EXPECT_NE(report["reason"].get<std::string>().find("did not come back"), std::string::npos);
    for (const char* file : {"headset.json", "mesh.glb", "hands.hands"})
        EXPECT_TRUE(fs::exists(path("out") + "/" + file)) << file;
}

TEST_F(KneadVr, is_left_by_a_finger_on_quit_and_paused_by_one_on_pause)
{
    panel = true;
    Json script = squeeze();
    script["render_every"] = 20;
    script["hands"] = path("poke.hands");
    write_recording(path("poke.hands"), poking(Control::quit));
    EXPECT_EQ(vr(script, {"--frames", "500"}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["reason"], "");
    EXPECT_GT(report["simulation"]["frames"], 115) << "a second on it";
    EXPECT_LT(report["simulation"]["frames"], 130);
    EXPECT_GT(report["drawn"], 0);

    // Time stands still once it is paused: the runtime has to end it.
    write_recording(path("poke.hands"), poking(Control::pause));
    script["faults"] = {{{"kind", "exit"}, {"frame", 200}}};
    EXPECT_EQ(vr(script, {"--frames", "500"}), exit_ok);
    expect_sound();
    EXPECT_GT(report["simulation"]["frames"], 20);
    EXPECT_LT(report["simulation"]["frames"], 60);
}

TEST_F(KneadVr, without_a_runtime_ends_at_once_with_a_message)
{
    std::vector<std::string> words{"env", "XR_RUNTIME_JSON=/nowhere.json", KNEAD_XR_PROGRAM, "vr"};
    words.insert(words.end(), scene.begin(), scene.end());
    std::string said;
    EXPECT_EQ(output_of(words, said, 60), exit_resource);
}

TEST_F(KneadVr, refuses_options_without_sense)
{
    for (const std::vector<std::string>& bad :
         std::vector<std::vector<std::string>>{{"--place", "1,2"},
                                               {"--place", "1,2,x"},
                                               {"--place", "99,0,0"},
                                               {"--binding", "vulkan"},
                                               {"--record", "hands.txt"}}) {
        std::vector<std::string> words{KNEAD_XR_PROGRAM, "vr", "scenes/squeeze.json"};
        words.insert(words.end(), bad.begin(), bad.end());
        std::string said;
        EXPECT_EQ(output_of(words, said, 60), exit_usage) << bad[1];
    }
}

}  // namespace
}  // namespace knead
#endif
