// `knead vr` from end to end, without a screen: the real loader, the replay runtime, software GL.
// To renew the goldens, look at what KNEAD_GOLDEN_OUT=DIR makes, and copy it to tests/xr/golden.
#include <gtest/gtest.h>

#ifdef KNEAD_XR_PROGRAM
#include <png.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/base/child.h"
#include "host/base/errors.h"
#include "host/hands/recording.h"
#include "host/session/headset_panel.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

using Json = nlohmann::json;

struct Pixels {
    int width = 0, height = 0;
    std::vector<png_byte> rgb;
    const png_byte* at(int x, int y) const { return &rgb[std::size_t(3 * (y * width + x))]; }
};

Pixels read_png(const std::string& path)
{
    png_image image;
    std::memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    Pixels pixels;
    if (!png_image_begin_read_from_file(&image, path.c_str())) {
        ADD_FAILURE() << path << ": " << image.message;
        return pixels;
    }
    image.format = PNG_FORMAT_RGB;
    pixels.width = int(image.width), pixels.height = int(image.height);
    pixels.rgb.resize(PNG_IMAGE_SIZE(image));
    EXPECT_TRUE(png_image_finish_read(&image, nullptr, pixels.rgb.data(), 0, nullptr));
    return pixels;
}

// The middle of the clay, which is the only thing that is that red [pixels]; and how many there
// are.
struct Red {
    double x = 0, y = 0;
    int count = 0;
};
Red red_of(const Pixels& picture)
{
    Red red;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const png_byte* p = picture.at(x, y);
            if (p[0] < 90 || p[0] < 2 * p[1] || p[0] < 2 * p[2]) continue;
            red.x += x + 0.5, red.y += y + 0.5, ++red.count;
        }
    red.x /= std::max(1, red.count), red.y /= std::max(1, red.count);
    return red;
}

class KneadVr : public InFolder {
  protected:
    const std::vector<std::string> scene{"scenes/squeeze.json",
                                         "--set",
                                         "domain.cells=16",
                                         "--set",
                                         "surface.nodes=32",
                                         "--device",
                                         "cpu",
                                         "--deterministic",
                                         "--threads",
                                         "1"};

    // Runs `knead vr` on the squeeze under a script; `report` is what it said.
    int vr(Json script, const std::vector<std::string>& more)
    {
        script["log"] = path("log");
        std::ofstream(path("script.json")) << script.dump();
        std::vector<std::string> words{"env",
                                       "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                                       "KNEAD_REPLAY_SCRIPT=" + path("script.json"),
                                       "OMP_WAIT_POLICY=passive",
                                       KNEAD_XR_PROGRAM,
                                       "vr"};
        words.insert(words.end(), scene.begin(), scene.end());
        for (const char* word : {"--binding", "egl", "--place", "0,0,0", "--json", "--quiet"})
            words.push_back(word);
        if (!panel) words.push_back("--no-panel");
        words.insert(words.end(), more.begin(), more.end());
        std::string said;
        const int code = output_of(words, said, 300);
        report = Json::parse(said, nullptr, false);
        log.clear();
        std::ifstream lines(path("log"));
        for (std::string line; std::getline(lines, line);) log.push_back(Json::parse(line));
        return code;
    }
    // The hash of the state to which `knead run` brings the recorded hands.
    std::string replayed(const std::string& hands)
    {
        std::vector<std::string> words{KNEAD_XR_PROGRAM, "run"};
        words.insert(words.end(), scene.begin(), scene.end());
        const std::string frames = std::to_string(report["simulation"]["frames"].get<int>());
        for (const std::string& word : {std::string("--hands"), hands, std::string("--frames"),
                                        frames, std::string("--json"), std::string("--quiet")})
            words.push_back(word);
        std::string said;
        EXPECT_EQ(output_of(words, said, 300), exit_ok);
        return Json::parse(said)["knead"]["state_hash"];
    }
    void expect_sound()
    {
        ASSERT_TRUE(report.is_object());
        EXPECT_EQ(report["gl_errors"], 0);
        ASSERT_FALSE(log.empty());
        EXPECT_EQ(log.back()["wrong"], 0) << "no call broke OpenXR's rules, and nothing leaked";
    }

    bool panel = false;
    Json report;
    std::vector<Json> log;
};

// A head that looks down at the clay, and the recorded squeeze.
Json squeeze()
{
    return {{"hands", "scenes/squeeze.hands"},
            {"width", 192},
            {"height", 192},
            {"head", {{{"time", 0}, {"at", {0, 0.2, 0.36}}, {"tilt", -29}}}}};
}

TEST_F(KneadVr, plays_the_squeeze_and_shows_it_to_both_eyes)
{
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 100;
    ASSERT_EQ(vr(script, {"--frames", "300", "--record", path("r.hands"), "--out", path("out")}),
              exit_ok);
    expect_sound();
    EXPECT_EQ(report["stray_gl_errors"], 0);
    EXPECT_EQ(report["simulation"]["frames"], 299);
    EXPECT_EQ(report["drawn"], 3);
    EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
    for (const char* file : {"headset.json", "mesh.glb", "hands.hands"})
        EXPECT_TRUE(fs::exists(path("out") + "/" + file)) << file;
    // What the hands do is seen in the very frame for which they were located.
    EXPECT_LE(report["display"]["motion_to_dent_frames"]["max"], 2);

    for (const Json& line : log) {
        if (!line.contains("eyes") || !line["eyes"][0].contains("file")) continue;
        const Json &left_eye = line["eyes"][0], &right_eye = line["eyes"][1];
        EXPECT_NEAR(left_eye["p"][0].get<double>(), -0.032, 1e-6);
        // Reversed depth: the near distance over the distance along the gaze.
        EXPECT_TRUE(left_eye["depth"]["near"].is_null()) << "infinite";
        EXPECT_NEAR(left_eye["depth"]["far"], 0.05, 1e-6);
        const Red l = red_of(read_png(left_eye["file"])), r = red_of(read_png(right_eye["file"]));
        ASSERT_GT(l.count, 300);
        EXPECT_NEAR(r.count, l.count, 0.1 * l.count);
        EXPECT_NEAR(l.y, r.y, 1) << "eyes are level";
        // Parallax: as far apart as two eyes see one thing at its distance, their own frusta taken
        // off. The ball's middle is at the origin, its seen side nearer.
        const auto tangent = [&](const Json& eye, double x) {
            const double low = std::tan(eye["fov"][0].get<double>());
            const double high = std::tan(eye["fov"][1].get<double>());
            return low + (high - low) * x / 192;
        };
        const double parallax = tangent(left_eye, l.x) - tangent(right_eye, r.x);
        const double distance = 0.064 / parallax;
        EXPECT_GT(distance, std::hypot(0.2, 0.36) - 0.1) << line["frame"];
        EXPECT_LT(distance, std::hypot(0.2, 0.36) + 0.02) << line["frame"];
    }
}

TEST_F(KneadVr, draws_what_its_goldens_show)
{
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 75;
    ASSERT_EQ(vr(script, {"--frames", "80"}), exit_ok);
    expect_sound();
    for (const char* name : {"frame_00075_left.png", "frame_00075_right.png"}) {
        const std::string made = path("dump") + "/" + name;
        if (const char* out = std::getenv("KNEAD_GOLDEN_OUT"))
            fs::copy_file(made, fs::path(out) / name, fs::copy_options::overwrite_existing);
        const Pixels seen = read_png(made);
        const Pixels golden = read_png(std::string("tests/xr/golden/") + name);
        ASSERT_EQ(seen.rgb.size(), golden.rgb.size());
        double sum = 0;
        int far_off = 0;
        for (std::size_t i = 0; i < seen.rgb.size(); ++i) {
            const int off = std::abs(int(seen.rgb[i]) - int(golden.rgb[i]));
            sum += off, far_off += off > 32;
        }
        EXPECT_LT(sum / double(seen.rgb.size()), 1.5) << name;
        EXPECT_LT(far_off, 0.01 * double(seen.rgb.size())) << name;
    }
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

// A right hand whose index finger goes through what is at `target` of the panel, and back.
Recording poking(PanelAct target)
{
    const HeadsetPanel panel;
    const PanelItem* item = nullptr;
    for (const PanelItem& one : panel.items())
        if (one.command.act == target && !item) item = &one;
    const Joint<float> at = HeadsetPanel::pose(Workplace{{0, 0, 0}, 0}, left);
    const float x = item->rect.x + 0.5f * item->rect.width - 0.5f * HeadsetPanel::width;
    const float y = 0.5f * HeadsetPanel::height - item->rect.y - 0.5f * item->rect.height;
    Recording recording{"poke", 90, 0, {}};
    for (int k = 0; k < 60; ++k) {
        const float z = 0.06f - 0.05f * std::min(float(k) / 30, 1.0f) - 0.012f * float(k / 30);
        const Vec3<float> tip{HeadsetPanel::pixel * x, HeadsetPanel::pixel * y, z};
        HandFrame frame;
        frame.time = k / 90.0;
        Hand& hand = frame.hand[right] = open_hand(right);
        const Vec3<float> shift = at.p + rotate(at.q, tip) - hand.joints[index_tip].p;
        for (auto& joint : hand.joints) joint.p = joint.p + shift;
        hand.tracked = true;
        hand.valid.fill(true);
        for (auto& joint : frame.hand[left].joints) joint = {{0, 0, 0, 0}, {0, 0, 0}};
        recording.frames.push_back(frame);
    }
    return recording;
}

TEST_F(KneadVr, is_left_by_a_finger_on_quit_and_paused_by_one_on_pause)
{
    panel = true;
    Json script = squeeze();
    script["render_every"] = 20;
    script["hands"] = path("poke.hands");
    write_recording(path("poke.hands"), poking(PanelAct::quit));
    EXPECT_EQ(vr(script, {"--frames", "500"}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["reason"], "");
    EXPECT_GT(report["simulation"]["frames"], 20);
    EXPECT_LT(report["simulation"]["frames"], 60);
    EXPECT_GT(report["drawn"], 0);

    // Time stands still once it is paused: the runtime has to end it.
    write_recording(path("poke.hands"), poking(PanelAct::pause));
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
