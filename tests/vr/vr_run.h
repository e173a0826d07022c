// `knead vr` run from end to end by a test: the real loader, the replay runtime, no screen.
#pragma once
#ifdef KNEAD_XR_PROGRAM
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
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
#include "tests/folder.h"
#include "tests/vr/panel_drivers.h"

namespace knead {
namespace fs = std::filesystem;

using Json = nlohmann::json;

struct Pixels {
    int width = 0, height = 0;
    std::vector<png_byte> rgb;
    const png_byte* at(int x, int y) const { return &rgb[std::size_t(3 * (y * width + x))]; }
};

inline Pixels pixels_of(const std::string& path)
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
inline Red red_of(const Pixels& picture)
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

// A head that looks down at the clay, and the recorded squeeze.
inline Json squeeze()
{
    return {{"hands", "scenes/squeeze.hands"},
            {"width", 192},
            {"height", 192},
            {"head", {{{"time", 0}, {"at", {0, 0.2, 0.36}}, {"tilt", -29}}}}};
}

class KneadVr : public InFolder {
  protected:
    std::vector<std::string> scene{"scenes/squeeze.json", "--cells",  "16",  "--set",
                                   "surface.nodes=32",    "--device", "cpu", "--deterministic",
                                   "--threads",           "1"};

    // Runs `knead vr` on the squeeze under a script; `report` is what it said.
    int vr(Json script, const std::vector<std::string>& more)
    {
        script["log"] = path("log");
        std::ofstream(path("script.json")) << script.dump();
        std::vector<std::string> words{"env",
                                       "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                                       "XDG_STATE_HOME=" + path("state"),
                                       "KNEAD_REPLAY_SCRIPT=" + path("script.json"),
                                       KNEAD_XR_PROGRAM,
                                       "vr"};
        words.insert(words.end(), scene.begin(), scene.end());
        for (const char* word : {"--binding", "egl", "--place", place.c_str(), "--json", "--quiet"})
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
    // What it says on stderr while three frames are shown, or as many as `more` asks for.
    std::string messages(const std::vector<std::string>& more, const Json& script = squeeze())
    {
        std::ofstream(path("script.json")) << script.dump();
        std::vector<std::string> words{"sh",
                                       "-c",
                                       "\"$@\" 2>&1 >\"$0\"",
                                       path("said"),
                                       "env",
                                       "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME,
                                       "XDG_STATE_HOME=" + path("state"),
                                       "KNEAD_REPLAY_SCRIPT=" + path("script.json"),
                                       KNEAD_XR_PROGRAM,
                                       "vr"};
        words.insert(words.end(), scene.begin(), scene.end());
        words.insert(words.end(), {"--binding", "egl"});
        if (std::find(more.begin(), more.end(), "--frames") == more.end())
            words.insert(words.end(), {"--frames", "3"});
        words.insert(words.end(), more.begin(), more.end());
        std::string said;
        EXPECT_EQ(output_of(words, said, 300), exit_ok) << said;
        return said;
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
    // 300 frames of the squeeze, deterministic, of which so many pairs of eyes were drawn. Its
    // hands were recorded to r.hands.
    void expect_whole_squeeze(int drawn)
    {
        expect_sound();
        EXPECT_EQ(report["stray_gl_errors"], 0);
        EXPECT_EQ(report["drawn"], drawn);
        EXPECT_EQ(report["simulation"]["frames"], 299);
        EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
        // What the hands do is seen in the very frame for which they were located.
        EXPECT_LE(report["display"]["motion_to_dent_frames"]["max"], 2);
        expect_parallax();
    }
    // Both eyes of every picture that was dumped show the clay, at the distance at which it is.
    void expect_parallax() const
    {
        int pictures = 0;
        for (const Json& line : log) {
            if (!line.contains("eyes") || !line["eyes"][0].contains("file")) continue;
            ++pictures;
            const Json &left_eye = line["eyes"][0], &right_eye = line["eyes"][1];
            EXPECT_NEAR(left_eye["p"][0].get<double>(), -0.032, 1e-6);
            // Reversed depth: the near distance over the distance along the gaze.
            EXPECT_TRUE(left_eye["depth"]["near"].is_null()) << "infinite";
            EXPECT_NEAR(left_eye["depth"]["far"], 0.05, 1e-6);
            const Pixels seen = pixels_of(left_eye["file"]);
            const Red l = red_of(seen), r = red_of(pixels_of(right_eye["file"]));
            ASSERT_GT(l.count, 0.0082 * seen.width * seen.height);
            EXPECT_NEAR(r.count, l.count, 0.1 * l.count);
            EXPECT_NEAR(l.y, r.y, 0.005 * seen.height) << "eyes are level";
            // Parallax: as far apart as two eyes see one thing at its distance, their own frusta
            // taken off. The ball's middle is at the origin, its seen side nearer.
            const auto tangent = [&](const Json& eye, double x) {
                const double low = std::tan(eye["fov"][0].get<double>());
                const double high = std::tan(eye["fov"][1].get<double>());
                return low + (high - low) * x / seen.width;
            };
            const double parallax = tangent(left_eye, l.x) - tangent(right_eye, r.x);
            const double distance = 0.064 / parallax;
            EXPECT_GT(distance, std::hypot(0.2, 0.36) - 0.1) << line["frame"];
            // Hands that leave the ball roll it away, by 13 cm of the scene at 64 cells.
            const double rolled = line["frame"] > 100 ? 0.06 : 0;
            EXPECT_LT(distance, std::hypot(0.2, 0.36) + 0.02 + rolled) << line["frame"];
        }
        EXPECT_GT(pictures, 0);
    }
    // Frame 75, which was dumped, against tests/vr/golden.
    void expect_goldens() const
    {
        for (const char* name : goldens) {
            const std::string made = path("dump") + "/" + name;
            const Pixels seen = pixels_of(made);
            const Pixels golden = pixels_of(std::string("tests/vr/golden/") + name);
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

    static constexpr const char* goldens[] = {"frame_00075_left.png", "frame_00075_right.png"};
    bool panel = false;
    std::string place = "0,0,0";
    Json report;
    std::vector<Json> log;
};

// A right hand whose index finger does what `act` lets it do on the panel. Empty in a build without
// panels.
inline Recording poking(const std::function<void(PanelDriver&, PanelSession&)>& act)
{
    Recording recording{"poke", 90, 0, {}};
    PanelSession session(in_headset);
    FingerDriver finger(session, Workplace{{0, 0, 0}, 0});
    if (!finger.drawing) return recording;
    finger.moved = [&](Vec3<float> tip, bool tracked) {
        HandFrame frame;
        frame.time = double(recording.frames.size()) / 90.0;
        Hand& hand = frame.hand[right] = open_hand(right);
        const Vec3<float> shift = tip - hand.joints[index_tip].p;
        for (auto& joint : hand.joints) joint.p = joint.p + shift;
        hand.tracked = tracked;
        hand.valid.fill(tracked);
        for (auto& joint : frame.hand[left].joints) joint = {{0, 0, 0, 0}, {0, 0, 0}};
        recording.frames.push_back(frame);
    };
    act(finger, session);
    return recording;
}
inline Recording poking(Control target)
{
    return poking([&](PanelDriver& finger, PanelSession&) { finger.press({target, 0}); });
}

}  // namespace knead
#endif
