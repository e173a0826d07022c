// What `knead vr` shows of other scenes than the squeeze, and what no lens shows.
#include <random>

#include "host/assets/procedural_object.h"
#include "host/document/command_table.h"
#include "host/document/command_text.h"
#include "host/hands/filter.h"
#include "host/hands/posture.h"
#include "host/live/live_session.h"
#include "tests/vr/vr_run.h"

#ifdef KNEAD_XR_PROGRAM
namespace knead {
namespace {

using VrScenes = KneadVr;

// The replay runtime hides a triangle at each corner; its eyes see 45 degrees to all sides or less,
// so that at least the pixels at the very corners are hidden.
void expect_hidden_corners(const Json& eye)
{
    const Pixels picture = pixels_of(eye["file"]);
    const auto tangent = [&](std::size_t i) { return std::tan(eye["fov"][i].get<double>()); };
    const double left = tangent(0), right = tangent(1), up = tangent(2), down = tangent(3);
    int hidden = 0, lit = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const double u = left + (right - left) * (x + 0.5) / picture.width;
            const double v = up + (down - up) * (y + 0.5) / picture.height;
            const double beyond = std::abs(u) + std::abs(v) - 1.75;  // 0: the triangle's long side
            const bool inside = beyond > 0 && std::abs(u) < 1 && std::abs(v) < 1;
            const png_byte* p = picture.at(x, y);
            const int sum = p[0] + p[1] + p[2];
            if (inside && beyond > 0.02) {
                ++hidden;
                ASSERT_EQ(sum, 0) << x << " " << y << " of " << eye["file"];
            } else if (beyond < -0.02) {
                ++lit;
                ASSERT_GT(sum, 0) << x << " " << y << " of " << eye["file"];
            }
        }
    EXPECT_GT(hidden, 50);
    EXPECT_GT(lit, hidden);
}

TEST_F(VrScenes, what_no_lens_shows_is_not_drawn)
{
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 20;
    ASSERT_EQ(vr(script, {"--frames", "21"}), exit_ok);
    expect_sound();
    int eyes = 0;
    for (const Json& line : log) {
        if (!line.contains("eyes") || !line["eyes"][0].contains("file")) continue;
        for (const Json& eye : line["eyes"]) ++eyes, expect_hidden_corners(eye);
    }
    EXPECT_GE(eyes, 2);
}

// Splats of a pot that is thrown onto the floor are split as they are drawn out; clay, hands and
// splats are one picture.
TEST_F(VrScenes, a_pot_of_splats_is_shaped_as_by_a_run)
{
    write_splats(path("pot.ply"), glazed_pot(4000));
    std::ofstream(path("scene.json")) << R"({"schema": "knead.scene/1",
        "domain": {"edge": 0.6, "cells": 24}, "surface": {"nodes": 24},
        "objects": [{"shape": "splats", "file": "pot.ply", "size": 0.2,
                     "centre": [0.3, 0.2, 0.3], "velocity": [0, -5, 0],
                     "material": "soft-clay"}],
        "splats": {"every": 3, "split": {"limit": 1.2, "budget": 50}},
        "hands": {"recording": "squeeze", "at": [0.3, 0.15, 0.3]}})";
    scene = {path("scene.json"), "--device", "cpu", "--deterministic", "--threads", "1"};
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 25;
    ASSERT_EQ(vr(script, {"--frames", "55", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["simulation"]["trouble"], "");
    EXPECT_GT(report["simulation"]["splats"],
              load_live_scene(path("scene.json"))->scene.setup.gaussians.size())
        << "some were split";
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
    EXPECT_FALSE(fs::exists(path("r.hands.commands"))) << "nothing was done beside the hands";
    int eyes = 0;
    for (const Json& line : log)
        if (line.contains("eyes") && line["eyes"][0].contains("file"))
            for (const Json& eye : line["eyes"]) ++eyes, expect_hidden_corners(eye);
    EXPECT_GE(eyes, 4);
}

// Hands a fifth larger, of a tracker that shakes: their size is found as they move, for what
// touches clay in the headset and in a run alike.
TEST_F(VrScenes, a_users_large_hands_are_a_runs_too)
{
    scene = {"scenes/squeeze.json",
             "--cells",
             "16",
             "--set",
             "surface.nodes=32",
             "--device",
             "cpu",
             "--threads",
             "1",
             "--deterministic"};
    Recording usual = read_recording("scenes/squeeze.hands"), large = usual;
    std::mt19937 source(3);
    std::normal_distribution<float> shaking(0, 5e-4f);
    for (HandFrame& frame : large.frames)
        for (Hand& hand : frame.hand) {
            const Vec3<float> at = hand.joints[wrist].p;
            for (auto& joint : hand.joints)
                joint.p = at + 1.2f * (joint.p - at) +
                          Vec3<float>{shaking(source), shaking(source), shaking(source)};
            for (float& r : hand.radius) r *= 1.2f;
        }
    write_recording(path("large.hands"), large);
    Json script = squeeze();
    script["hands"] = path("large.hands");
    script["render_every"] = 50;
    ASSERT_EQ(vr(script, {"--frames", "130", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    const HandSource hands(read_recording(path("r.hands")), {});
    EXPECT_NEAR(hands.stretch(1.2, right).along, 1.2, 0.01);
    EXPECT_NE(hands.stretch(1.2, right).along, hands.stretch(0.5, right).along);
    const std::string state = report["simulation"]["state_hash"];
    EXPECT_EQ(state, replayed(path("r.hands")));
    EXPECT_NE(state, replayed("scenes/squeeze.hands"));
}

// However long that takes: splats have all of the pixels that eyes have.
TEST_F(VrScenes, splats_are_whole_where_eyes_are_asked_to_be)
{
    scene = {"scenes/pot.json", "--set", "domain.cells=16", "--set", "surface.nodes=16",
             "--device",        "cpu",   "--threads",       "1"};
    ASSERT_EQ(vr(squeeze(), {"--frames", "8", "--eye-scale", "1", "--no-sound"}), exit_ok);
    expect_sound();
    ASSERT_TRUE(report["display"].contains("splat_scale"));
    EXPECT_EQ(report["display"]["splat_scale"]["min"], 1);
    EXPECT_EQ(report["display"]["eye_scale"]["min"], 1);
}

// A floor of splats that stands still becomes clay where the recorded rod pokes it.
TEST_F(VrScenes, a_standing_floor_becomes_clay_at_the_hands)
{
    scene = {"scenes/ground.json", "--set", "domain.cells=32", "--set",     "surface.nodes=32",
             "--device",           "cpu",   "--deterministic", "--threads", "1"};
    Json script = squeeze();
    script["render_every"] = 45;
    script["hands"] = "scenes/ground.hands";
    ASSERT_EQ(vr(script, {"--frames", "91", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["simulation"]["trouble"], "");
    EXPECT_GT(report["simulation"]["particles"], 100) << "clay came to where the rod is";
    EXPECT_GE(report["simulation"]["splats"], 20000);
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
    EXPECT_GT(report["drawn"], 0);
}

// What a finger does to the panel is kept beside the hands, and played with them; a reset begins
// the recording anew.
TEST_F(VrScenes, what_the_panel_did_is_played_by_a_run_to_the_same_state)
{
    panel = true;
    Json script = squeeze();
    script["render_every"] = 1000;
    script["hands"] = path("poke.hands");
    const Recording poke = poking([](PanelDriver& finger, PanelSession& shown) {
        finger.slide({Control::gravity, 0}, 0.5f);
        finger.press({Control::reset, 0});
        finger.choose({Control::preset, 0}, shown.choice(Control::preset, "dough"));
        finger.choose({Control::right_tool, 0}, shown.choice(Control::right_tool, "knife"));
        finger.slide({Control::quantity, PanelSession::quantity("young")}, -0.1f);
        finger.slide({Control::gravity, 0}, -0.1f);
    });
    if (poke.frames.empty()) GTEST_SKIP() << no_panel;
    write_recording(path("poke.hands"), poke);
    const std::string frames = std::to_string(poke.frames.size() - 5);
    ASSERT_EQ(vr(script, {"--frames", frames, "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["simulation"]["trouble"], "");
    EXPECT_GE(report["hands"]["actions"], 5);
    const CommandLog kept = read_command_log(path("r.hands.commands"), "");
    EXPECT_EQ(kept.scene, "scenes/squeeze.json");
    // A drag of a slider is several commands of a kind.
    std::vector<std::string> done;
    for (const LoggedCommand& one : kept.commands)
        if (const std::string name = row_of(one.command).name; done.empty() || done.back() != name)
            done.push_back(name);
    const std::vector<std::string> wanted{"mark", "set_material", "set_hands", "set_material",
                                          "set_gravity"};
    EXPECT_EQ(done, wanted);
    EXPECT_EQ(kept.commands.at(0).frame, 0);
    EXPECT_EQ(std::get<Mark>(kept.commands.at(0).command).text, "reset");
    EXPECT_EQ(report["hands"]["actions"], kept.commands.size());
    const std::string state = report["simulation"]["state_hash"];
    EXPECT_EQ(replayed(path("r.hands")), state);
    fs::rename(path("r.hands.commands"), path("aside"));
    EXPECT_NE(replayed(path("r.hands")), state) << "the hands alone";
    // Beside another recording they are refused.
    fs::rename(path("aside"), path("poke.hands.commands"));
    std::string said;
    std::vector<std::string> words{KNEAD_XR_PROGRAM, "run"};
    words.insert(words.end(), scene.begin(), scene.end());
    words.insert(words.end(), {"--hands", path("poke.hands")});
    EXPECT_EQ(output_of(words, said, 60), exit_input);
}

// A right hand whose palm is at `place` [m], closed by `share`.
Hand closed_hand(Vec3<double> place, double share)
{
    const Pose pose = posed(right, {{1, 0, 0, 0}, {0, 0, 0}}, gripped(share));
    const Vec3<double> shift = place - pose[palm].p;
    Hand hand;
    for (std::size_t j = 0; j < joint_count; ++j)
        hand.joints[j] = {cast<float>(pose[j].q), cast<float>(pose[j].p + shift)};
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}

// A fist lifts the ball and lets it fall: two commands, of which a run makes the same state.
TEST_F(VrScenes, a_fist_carries_clay_as_a_run_does)
{
    panel = true;
    Recording recording = poking(Control::carry);
    const auto add = [&](int frames, double from, double to, double share) {
        for (int k = 0; k < frames; ++k) {
            HandFrame frame;
            frame.time = double(recording.frames.size()) / 90.0;
            frame.hand[right] = closed_hand({0, 0.09 + from + (to - from) * k / frames, 0}, share);
            for (auto& joint : frame.hand[left].joints) joint = {{0, 0, 0, 0}, {0, 0, 0}};
            recording.frames.push_back(frame);
        }
    };
    add(30, 0, 0, 0), add(30, 0, 0, 1), add(60, 0, 0.06, 1), add(30, 0.06, 0.06, 0);
    write_recording(path("fist.hands"), recording);
    Json script = squeeze();
    script["render_every"] = 1000;
    script["hands"] = path("fist.hands");
    ASSERT_EQ(vr(script, {"--frames", "205", "--record", path("r.hands")}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["simulation"]["trouble"], "");
    const CommandLog kept = read_command_log(path("r.hands.commands"), "");
    std::vector<std::string> done;
    for (const LoggedCommand& one : kept.commands) done.push_back(row_of(one.command).name);
    ASSERT_EQ(done, (std::vector<std::string>{"set_hands", "carry", "carry"}));
    const Carry &begin = std::get<Carry>(kept.commands[1].command),
                &end = std::get<Carry>(kept.commands[2].command);
    EXPECT_TRUE(begin.begins);
    EXPECT_FALSE(end.begins);
    EXPECT_EQ(begin.side, right);
    const std::string state = report["simulation"]["state_hash"];
    EXPECT_EQ(replayed(path("r.hands")), state);
    fs::remove(path("r.hands.commands"));
    EXPECT_NE(replayed(path("r.hands")), state) << "the hands alone";
}

// Where the origin is on the floor, the clay is put before the head; the panel's button changes
// from one origin to the other, and no call is wrong.
TEST_F(VrScenes, are_put_before_a_head_that_stands_or_sits)
{
    panel = true;
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 20;
    script["hands"] = path("poke.hands");
    write_recording(path("poke.hands"), poking(Control::standing));
    ASSERT_EQ(vr(script, {"--frames", "62"}), exit_ok);
    expect_sound();
    const auto balls = [&] {
        std::vector<Red> seen;
        for (const Json& line : log)
            if (line.contains("eyes") && line["eyes"][0].contains("file"))
                seen.push_back(red_of(pixels_of(line["eyes"][0]["file"])));
        return seen;
    };
    const std::vector<Red> seated = balls();
    ASSERT_GE(seated.size(), 2u);
    // The usual place, 0,0,0, is then that of the eyes: the ball is about them.
    EXPECT_GT(seated.front().count, 300);
    EXPECT_NE(seated.back().count, seated.front().count);

    panel = false;
    script["render_every"] = script["dump_every"] = 20;
    script["hands"] = "scenes/squeeze.hands";
    place = "0,-0.2,-0.36";
    ASSERT_EQ(vr(script, {"--frames", "21", "--standing"}), exit_ok);
    expect_sound();
    const std::vector<Red> standing = balls();
    ASSERT_GE(standing.size(), 1u);
    EXPECT_GT(standing.back().count, 300) << "in view";
}

// Hands alone: the clay stands still, and the recording shapes it later.
TEST_F(VrScenes, hands_alone_are_recorded_without_a_simulation)
{
    Json script = squeeze();
    script["render_every"] = 1000;
    ASSERT_EQ(vr(script, {"--frames", "120", "--hands-only", "--record", path("r.hands")}),
              exit_ok);
    expect_sound();
    EXPECT_EQ(report["simulation"]["frames"], 0);
    EXPECT_EQ(report["hands"]["frames"], 120);
    EXPECT_FALSE(report["display"].contains("motion_to_dent_ms")) << "nothing is dented";
    report["simulation"]["frames"] = 119;
    const std::string alone = replayed(path("r.hands"));
    ASSERT_EQ(vr(script, {"--frames", "120", "--record", path("again.hands")}), exit_ok);
    EXPECT_EQ(report["simulation"]["state_hash"], alone);
}

}  // namespace
}  // namespace knead
#endif
