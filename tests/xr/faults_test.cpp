// What becomes of a headset session when its runtime misbehaves: the probe, a program of the five
// verbs, is run under the replay runtime, which strikes as a script says and counts wrong calls.
#include <gtest/gtest.h>

#ifdef KNEAD_XR_PROBE
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "host/base/child.h"
#include "host/base/errors.h"
#include "tests/folder.h"
#include "xr/openxr.h"

namespace knead {
namespace {

using Json = nlohmann::json;

// What the probe told, and what the runtime has to say of it.
struct Probed {
    int code = -1;
    std::vector<Json> lines;   // one a frame, of those that were waited for
    std::vector<Json> others;  // messages, renewals, ends
    std::vector<Json> log;     // of the runtime
    Json last;                 // counts

    bool said(const std::string& key) const
    {
        for (const Json& line : others)
            if (line.contains(key)) return true;
        return false;
    }
};

std::vector<Json> lines_of(std::istream& in)
{
    std::vector<Json> all;
    for (std::string line; std::getline(in, line);) all.push_back(Json::parse(line));
    return all;
}

class HeadsetFault : public InFolder {
  protected:
    // Runs the probe until it has drawn `frames`, under a script with these faults.
    Probed probe(const Json& faults, int frames = 40, Json script = Json::object())
    {
        script["faults"] = faults;
        script["log"] = path("log");
        script["hands"] = "scenes/squeeze.hands";
        std::ofstream(path("script.json")) << script.dump();
        Probed probed;
        std::string said;
        probed.code = output_of({"env", "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                                 "KNEAD_REPLAY_SCRIPT=" + path("script.json"), KNEAD_XR_PROBE,
                                 std::to_string(frames), "--egl", "--patience", "5"},
                                said, 60);
        std::istringstream entered(said);
        for (Json& line : lines_of(entered)) {
            if (line.contains("drawn"))
                probed.last = line;
            else if (line.contains("time"))
                probed.lines.push_back(line);
            else
                probed.others.push_back(line);
        }
        std::ifstream log(path("log"));
        probed.log = lines_of(log);
        return probed;
    }
    // Ended as it should, with all frames drawn, and no wrong call.
    static void expect_sound(const Probed& probed, int frames = 40)
    {
        EXPECT_EQ(probed.code, 0);
        EXPECT_EQ(probed.last["drawn"], frames);
        ASSERT_FALSE(probed.log.empty());
        EXPECT_EQ(probed.log.back()["wrong"], 0) << probed.log.back();
        double before = -1;
        for (const Json& line : probed.lines) {
            EXPECT_GT(line["time"], before) << "time rises, whatever happens";
            before = line["time"];
        }
    }
};

TEST_F(HeadsetFault, none_is_a_session_that_begins_draws_and_leaves_without_a_wrong_call)
{
    const Probed probed = probe(Json::array());
    expect_sound(probed);
    EXPECT_EQ(probed.last["stray"], 0);
    EXPECT_FALSE(probed.said("renewed"));
    EXPECT_EQ(probed.others.back()["over"], "");
    EXPECT_TRUE(probed.others.front()["depth"]);
    EXPECT_EQ(probed.others.front()["hidden"], 12);
    EXPECT_TRUE(probed.lines.back()["left"]["tracked"]);
    EXPECT_EQ(probed.lines.back()["left"]["from"], 1) << "cameras see it";
}

TEST_F(HeadsetFault, a_lost_session_is_followed_by_a_new_one_that_goes_on_in_time)
{
    for (const char* kind : {"lose_session", "session_loss", "lose_headset", "lose_instance"}) {
        const Probed probed = probe(Json::array({{{"kind", kind}, {"frame", 15}, {"count", 5}}}));
        SCOPED_TRACE(kind);
        expect_sound(probed);
        EXPECT_TRUE(probed.said("renewed"));
        EXPECT_EQ(probed.others.back()["over"], "");
    }
}

TEST_F(HeadsetFault, a_runtime_that_never_comes_back_ends_the_session_with_its_reason)
{
    const Probed probed =
        probe(Json::array({{{"kind", "lose_instance"}, {"frame", 15}, {"count", 1000000}}}), 40,
              {{"log", ""}});
    EXPECT_EQ(probed.code, 0);
    ASSERT_TRUE(probed.said("over"));
    EXPECT_NE(probed.others.back()["over"].get<std::string>().find("did not come back"),
              std::string::npos);
    EXPECT_LT(probed.last["drawn"], 40);
}

TEST_F(HeadsetFault, a_headset_taken_off_pauses_the_frames_and_one_put_on_goes_on)
{
    const Probed probed =
        probe(Json::array({{{"kind", "take_off"}, {"frame", 15}, {"count", 30}}}));
    expect_sound(probed);
    EXPECT_FALSE(probed.said("renewed")) << "it is the same session";
    int begun = 0;
    for (const Json& line : probed.log) begun += line.value("state", 0) == XR_SESSION_STATE_READY;
    EXPECT_EQ(begun, 2);

    const Probed unworn = probe(Json::array({{{"kind", "unworn"}, {"frame", 15}, {"count", 10}}}));
    expect_sound(unworn);
    int off = 0;
    for (const Json& line : unworn.lines) off += !line["worn"].get<bool>();
    EXPECT_EQ(off, 10);
}

TEST_F(HeadsetFault, frames_that_nobody_sees_are_waited_for_and_not_drawn)
{
    const Probed probed =
        probe(Json::array({{{"kind", "no_render"}, {"frame", 15}, {"count", 9}}}));
    expect_sound(probed);
    int unseen = 0;
    for (const Json& line : probed.lines) unseen += !line["draw"].get<bool>();
    EXPECT_EQ(unseen, 9 + 1) << "and the first, before it was visible";
}

TEST_F(HeadsetFault, lost_and_invalid_hands_are_not_tracked_and_half_a_hand_says_which_half)
{
    for (const char* kind : {"lose_hand", "invalid_joints"}) {
        const Probed probed =
            probe(Json::array({{{"kind", kind}, {"frame", 15}, {"count", 6}, {"side", "left"}}}));
        SCOPED_TRACE(kind);
        expect_sound(probed);
        int lost = 0;
        for (const Json& line : probed.lines) {
            if (!line["draw"]) continue;
            lost += !line["left"]["tracked"].get<bool>();
            EXPECT_TRUE(line["right"]["tracked"]);
        }
        EXPECT_EQ(lost, 6);
    }
    const Probed half =
        probe(Json::array({{{"kind", "invalid_fingers"}, {"frame", 15}, {"count", 6}}}));
    expect_sound(half);
    int partial = 0;
    for (const Json& line : half.lines)
        partial += line["left"]["tracked"] == true && line["left"]["valid"] == 2;
    EXPECT_EQ(partial, 6);
}

TEST_F(HeadsetFault, constant_radii_are_replaced_by_those_of_a_hand)
{
    const Probed probed =
        probe(Json::array({{{"kind", "constant_radii"}, {"frame", 0}, {"count", 1000}}}));
    expect_sound(probed);
    const Json& radii = probed.lines.back()["left"]["radii"];
    EXPECT_GT(radii[0].get<double>(), 2 * radii[1].get<double>());
}

TEST_F(HeadsetFault, a_changed_rate_and_a_moved_origin_are_told)
{
    const Probed probed = probe(Json::array({{{"kind", "refresh"}, {"frame", 15}, {"value", 72}},
                                             {{"kind", "recentre"}, {"frame", 20}}}));
    expect_sound(probed);
    EXPECT_EQ(probed.lines.front()["rate"], 90);
    EXPECT_EQ(probed.lines.back()["rate"], 72);
    EXPECT_NEAR(probed.lines.back()["period"], 1.0 / 72, 1e-8);
    EXPECT_TRUE(probed.said("recentred"));
}

TEST_F(HeadsetFault, gl_errors_and_stolen_contexts_of_the_runtime_do_no_harm)
{
    const Probed errors = probe(Json::array({{{"kind", "gl_error"}, {"frame", 15}, {"count", 3}}}));
    expect_sound(errors);
    EXPECT_EQ(errors.last["stray"], 3);
    EXPECT_EQ(errors.last["errors"], 0);
    const Probed stolen = probe(Json::array(
        {{{"kind", "steal_context"}, {"frame", 3}}, {{"kind", "lose_session"}, {"frame", 9}}}));
    expect_sound(stolen);
    EXPECT_EQ(stolen.last["errors"], 0);
}

TEST_F(HeadsetFault, the_runtimes_own_end_is_followed)
{
    const Probed probed = probe(Json::array({{{"kind", "exit"}, {"frame", 15}}}), 1000);
    EXPECT_EQ(probed.code, 0);
    EXPECT_EQ(probed.others.back()["over"], "");
    EXPECT_EQ(probed.log.back()["wrong"], 0);
    EXPECT_LT(probed.last["drawn"], 20);
}

TEST_F(HeadsetFault, a_controller_poses_a_hand_that_no_camera_sees_and_shakes_in_it)
{
    const Json held = {
        {"side", "right"}, {"from", 0}, {"to", 10}, {"at", {0.2, 0, 0.1}}, {"trigger", 0.5}};
    const Probed probed =
        probe(Json::array(), 40, {{"controllers", {held}}, {"without", {"XR_EXT_hand_tracking"}}});
    expect_sound(probed);
    const Json& hand = probed.lines.back()["right"];
    EXPECT_EQ(hand["from"], 3) << "posed";
    EXPECT_TRUE(hand["tracked"]);
    EXPECT_NEAR(hand["pinch"], 0.5, 1e-6);
    EXPECT_FALSE(probed.lines.back()["left"]["tracked"]);
    int shaken = 0;
    for (const Json& line : probed.log) shaken += line.contains("haptic");
    EXPECT_EQ(shaken, 1);
}

TEST_F(HeadsetFault, all_that_is_not_needed_may_be_missing)
{
    const Json most = {"XR_EXT_hand_tracking",
                       "XR_EXT_hand_interaction",
                       "XR_EXT_hand_tracking_data_source",
                       "XR_KHR_composition_layer_depth",
                       "XR_KHR_visibility_mask",
                       "XR_FB_display_refresh_rate",
                       "XR_EXT_user_presence",
                       "XR_KHR_convert_timespec_time"};
    const Probed probed = probe(Json::array(), 10, {{"without", most}});
    expect_sound(probed, 10);
    EXPECT_FALSE(probed.others.front()["depth"]);
    EXPECT_EQ(probed.others.front()["missing"], most);
}

TEST_F(HeadsetFault, what_is_needed_is_named_where_it_is_missing)
{
    for (const char* needed : {"XR_KHR_opengl_enable", "XR_MNDX_egl_enable"}) {
        const Probed probed = probe(Json::array(), 10, {{"without", {needed}}});
        EXPECT_EQ(probed.code, exit_resource) << needed;
    }
}

// The reason goes to standard error; here only that it ends as it should.
TEST(Headset, without_a_runtime_ends_with_the_code_for_missing_resources)
{
    std::string said;
    EXPECT_EQ(
        output_of({"env", "XR_RUNTIME_JSON=/nowhere/runtime.json", KNEAD_XR_PROBE, "1"}, said, 60),
        exit_resource);
}

}  // namespace
}  // namespace knead
#endif
