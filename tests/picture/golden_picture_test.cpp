// Small pictures of whole runs against those that tests/golden/ keeps, within what other drivers,
// compilers and processors may change, and no more: the same test says that a camera moved by a
// centimetre or a hand that is missing would be seen. tests/golden_pictures.sh renews them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "host/assets/splat_object.h"
#include "host/picture/caption.h"
#include "host/picture/frame_writer.h"
#include "host/picture/splat_picture.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/splats/generate.h"
#include "tests/folder.h"

namespace knead {
namespace {

constexpr double least_psnr = 38;  // [dB] of the whole picture
constexpr int square = 16;         // pixels a side
constexpr double most_off = 8;     // of 255: a colour's mean difference in any such square

// Sum of |a - b| or of (a - b)^2 in a part of two pictures, by colour values.
template <class Of>
double sum(const Image& a, const Image& b, int left, int top, int width, int height, Of&& of)
{
    double all = 0;
    for (int y = top; y < std::min(top + height, a.height); ++y)
        for (int x = 3 * left; x < 3 * std::min(left + width, a.width); ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(3 * a.width) + std::size_t(x);
            all += of(double(a.rgb[i]) - double(b.rgb[i]));
        }
    return all;
}

// "", or in what the pictures differ.
std::string difference(const Image& a, const Image& b)
{
    if (a.width != b.width || a.height != b.height)
        return fmt::format("{} x {} instead of {} x {} pixels", a.width, a.height, b.width,
                           b.height);
    const double squares =
        sum(a, b, 0, 0, a.width, a.height, [](double d) { return d * d; }) / double(a.rgb.size());
    const double psnr = squares > 0 ? 10 * std::log10(255 * 255 / squares) : 200;
    if (psnr < least_psnr) return fmt::format("PSNR {:.1f} dB, below {}", psnr, least_psnr);
    for (int y = 0; y < a.height; y += square)
        for (int x = 0; x < a.width; x += square) {
            const int wide = std::min(square, a.width - x), high = std::min(square, a.height - y);
            const double off =
                sum(a, b, x, y, square, square, [](double d) { return std::fabs(d); }) /
                (3.0 * wide * high);
            if (off > most_off)
                return fmt::format("{:.1f} of 255 off in the square at {}, {}", off, x, y);
        }
    return "";
}

bool renews() { return std::getenv("KNEAD_RENEW_PICTURES") != nullptr; }

// The picture is the one that is kept under this name. One that is not is left in out/golden/.
void expect_kept(const Image& image, const std::string& name)
{
    const std::string kept = "tests/golden/" + name + ".png";
    if (renews()) {
        write_png(kept, image);
        return;
    }
    const std::string why = difference(image, read_png(kept));
    if (why.empty()) return;
    std::filesystem::create_directories("out/golden");
    const std::string found = "out/golden/" + name + ".png";
    write_png(found, image);
    ADD_FAILURE() << kept << ": " << why << "; found: " << found
                  << "; if that is meant: tests/golden_pictures.sh PROGRAM_OF_TESTS";
}

// What a run showed at one of its frames, to be drawn again in other ways.
struct Shown {
    FrameResult frame;
    std::vector<Mesh> meshes;
    std::vector<Gaussian<double>> gaussians;
};

class GoldenPictures : public InFolder {
  protected:
    void SetUp() override
    {
        InFolder::SetUp();
        try {
            const std::string by = Painter::open()->name();
            if (by.find("llvmpipe") == by.npos && by.find("softpipe") == by.npos && renews())
                GTEST_SKIP() << "kept pictures are of software's OpenGL, this is " << by;
        } catch (const std::runtime_error& reason) {
            GTEST_SKIP() << reason.what();
        }
    }

    // Runs the scene to the last of the frames.
    void run(const std::string& file, std::vector<std::string> settings,
             const std::vector<int>& frames)
    {
        for (const char* size : {"pictures.width=240", "pictures.height=180"})
            settings.insert(settings.begin(), size);  // unless they say another
        scene = read_scene(file, settings);
        splats = joined(load_splats(scene, std::size_t(1) << 32));
        build(scene, std::size_t(1) << 32);
        std::unique_ptr<HandSource> hands;
        if (scene.has_hands) hands = std::make_unique<HandSource>(hands_of(scene), scene.hands);
        const std::unique_ptr<Simulator> solver = cpu_solver(scene.setup);
        SessionLoopOptions options = loop_options(scene);
        options.frames = frames.back();
        SessionLoop loop(*solver, recorded_motion(hands.get(), scene.hands), options);
        loop.observe([&](const FrameResult& f) {
            if (std::find(frames.begin(), frames.end(), f.number) != frames.end())
                shown.push_back({f, *loop.meshes(), solver->gaussians()});
        });
        loop.run();
        ASSERT_EQ(loop.failure(), nullptr);
        ASSERT_EQ(shown.size(), frames.size());
    }

    Image drawn(const Shown& what)
    {
        if (!writer) writer = std::make_unique<FrameWriter>(scene, folder.string(), "", 30);
        writer->add(what.frame, what.meshes, splats, what.gaussians);
        return read_png((folder / picture_name(what.frame.number)).string());
    }

    Scene scene;
    SplatCloud splats;
    std::vector<Shown> shown;
    std::unique_ptr<FrameWriter> writer;  // made for the first picture
};

TEST_F(GoldenPictures, OfABallBeforeInAndAfterTheHands)
{
    run("scenes/demo.json", {"domain.cells=20", "surface.nodes=64", "objects.0.material.young=2e4"},
        {8, 75, 150});
    const char* const names[] = {"squeeze-before", "squeeze-in", "squeeze-after"};
    for (std::size_t k = 0; k < 3; ++k) expect_kept(drawn(shown[k]), names[k]);
    // What is wrong is seen.
    const Image right = drawn(shown[1]);
    EXPECT_EQ(difference(right, right), "");
    Shown without = shown[1];
    without.frame.motion.active = {0, 1};
    EXPECT_NE(difference(drawn(without), right), "") << "a hand is missing";
    without = shown[1];
    without.meshes[0].normals.assign(without.meshes[0].normals.size(), {0, -1, 0});
    EXPECT_NE(difference(drawn(without), right), "") << "clay is lit from the wrong side";
    EXPECT_NE(difference(drawn(shown[2]), right), "") << "another frame";
    scene.target.x += 0.01;
    EXPECT_NE(difference(drawn(shown[1]), right), "") << "the camera is off by a centimetre";
}

TEST_F(GoldenPictures, OfAPotOfSplatsInTheHands)
{
    run("scenes/pot.json", {"domain.cells=16", "objects.0.material.young=5e3", "frame_rate=30"},
        {40});
    const Image right = drawn(shown[0]);
    expect_kept(right, "pot");
    Shown still = shown[0];
    for (Gaussian<double>& g : still.gaussians) g.x.y -= 0.01;
    EXPECT_NE(difference(drawn(still), right), "") << "splats beside their clay";
    splats.sh.assign(splats.sh.size(), {0, 0, 0});
    EXPECT_NE(difference(drawn(shown[0]), right), "") << "splats without colour";
}

// Kept without the names of the presets: fonts differ from machine to machine.
TEST_F(GoldenPictures, OfEveryPresetDroppedAndPressedWithItsName)
{
    run("scenes/presets.json",
        {"domain.cells=[56,16,28]", "surface.nodes=112", "pictures.width=320",
         "pictures.height=124"},
        {20});
    const auto names = std::exchange(scene.captions, {});
    const Image nameless = drawn(shown[0]);
    expect_kept(nameless, "presets");
    ASSERT_FALSE(names.empty());
    if (!draws_text()) return;
    for (std::size_t k = 0; k <= names.size(); ++k) {
        scene.captions = names;
        const Image all = drawn(shown[0]);
        if (k < names.size()) scene.captions.erase(scene.captions.begin() + long(k));
        const std::string why = difference(drawn(shown[0]), all);
        if (k < names.size())
            EXPECT_NE(why, "") << names[k].text << " is missing";
        else
            EXPECT_EQ(why, "");
    }
}

// Needs no OpenGL.
TEST(GoldenSplats, OfAGeneratedSceneByTheCpuAlone)
{
    SplatCloud cloud = generated({"golden", 6000, 6000, 0.03, 7});
    SplatFrame frame;
    frame.eyes = load_eyes("far", 150, 160);
    const Image right = image_of(cpu_raster(cloud, frame));
    expect_kept(right, "splats");
    frame.eyes[0].position.x += 0.01f;
    EXPECT_NE(difference(image_of(cpu_raster(cloud, frame)), right), "") << "an eye elsewhere";
}

}  // namespace
}  // namespace knead
