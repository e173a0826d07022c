// Words in pictures: where they are asked for, and nothing else; how scenes name them.
#include "host/picture/caption.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "host/base/outputs.h"
#include "host/scene/scene.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

Image grey(int width, int height)
{
    return {
        width, height,
        std::vector<std::uint8_t>(std::size_t(3) * std::size_t(width) * std::size_t(height), 128)};
}

struct Extent {
    int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
};

// Of the pixels as bright as the pen.
Extent written(const Image& image)
{
    Extent e;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (image.rgb[3 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x))] > 220)
                e = {std::min(e.left, x), std::max(e.right, x), std::min(e.top, y),
                     std::max(e.bottom, y)};
    return e;
}

// Builds without Dear ImGui draw no text.
class Caption : public testing::Test {
  protected:
    void SetUp() override
    {
        if (draws_text()) return;
        Image image = grey(40, 60);
        write_text(image, "H", 20, 30, 24);
        EXPECT_EQ(image.rgb, grey(40, 60).rgb);
        GTEST_SKIP() << "this build draws no text";
    }
    static std::vector<std::uint8_t> shape(const std::string& text)
    {
        Image image = grey(60, 60);
        write_text(image, text, 30, 25, 24);
        return image.rgb;
    }
};

TEST_F(Caption, StandsInTheMiddleOfItsPlaceAndIsAsHighAsAsked)
{
    for (const double height : {7.0, 10.6, 16.0, 24.0, 48.0, 64.0, 90.0, 200.0}) {
        SCOPED_TRACE(height);
        Image image = grey(1200, 500);
        write_text(image, "HEH", 600, 240, height);
        const Extent e = written(image);
        EXPECT_NEAR(e.left + e.right + 1, 1200, 2 + 0.01 * height);
        EXPECT_NEAR(e.top + e.bottom + 1, 480, 2 + 0.03 * height);
        EXPECT_NEAR(e.bottom - e.top + 1, height, 1.5 + 0.02 * height);
        EXPECT_GT(e.right - e.left, 2 * height);
        EXPECT_LT(e.right - e.left, 4 * height);
        EXPECT_EQ(image.rgb[0], 128);
    }
}

TEST_F(Caption, IsWhiteWithADarkOutline)
{
    for (const int ground : {0, 128, 255}) {
        Image image = grey(60, 60);
        std::fill(image.rgb.begin(), image.rgb.end(), std::uint8_t(ground));
        write_text(image, "I", 30, 30, 32);
        const auto at = [&](int x) { return int(image.rgb[std::size_t(3 * (30 * 60 + x))]); };
        int brightest = 0, left = 60;
        for (int x = 0; x < 60; ++x) {
            brightest = std::max(brightest, at(x));
            if (at(x) == 255 && x > 20) left = std::min(left, x);
        }
        EXPECT_EQ(brightest, 255);
        if (ground == 255) left = 29;  // its outline alone is seen
        int darkest = 255;
        for (int x = left - 6; x < left + 6; ++x) darkest = std::min(darkest, at(x));
        EXPECT_LT(darkest, 90) << ground;
        EXPECT_EQ(at(10), ground);
        EXPECT_EQ(at(50), ground);
    }
}

TEST_F(Caption, EveryCharacterHasAShapeOfItsOwn)
{
    const std::vector<std::uint8_t> blank = grey(60, 60).rgb;
    const std::string letters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,:;-+=/%()'!?_<>[]|~";
    EXPECT_EQ(shape(" "), blank);
    EXPECT_EQ(shape(""), blank);
    std::set<std::vector<std::uint8_t>> shapes;
    for (const char letter : letters) {
        const auto one = shape(std::string(1, letter));
        EXPECT_NE(one, blank) << letter;
        EXPECT_TRUE(shapes.insert(one).second) << letter;
    }
}

TEST_F(Caption, NamesBeyondAsciiAreUtf8)
{
    EXPECT_NE(shape("ä"), shape("a"));
    EXPECT_NE(shape("ä"), shape("ö"));
    EXPECT_EQ(shape("ä"), shape("ä")) << "letters that came later change none of the earlier";
    // No UTF-8, characters that no font has, and those beyond 16 bits have the sign for such.
    EXPECT_EQ(shape("\xe4"), shape("\xff"));
    EXPECT_EQ(shape("\xe4"), shape("\xef\xbf\xbe"));
    EXPECT_EQ(shape("\xe4"), shape("\xf0\x9f\x8f\xba"));
    EXPECT_EQ(shape("\xe4"), shape(std::string(1, '\0')));
    EXPECT_NE(shape("\xe4"), shape("ä"));
    // The name of a file, whatever its bytes, cut off inside a character.
    for (const char* name : {"Töpfchen 2.glb", "горшок.ply", "壺.splat", "pot\xc3", "\xf0\x9f\n"})
        EXPECT_NE(shape(name), grey(60, 60).rgb) << name;
    // More letters than are kept.
    std::string all;
    for (int letter = 0x100; letter < 0x800; ++letter)
        all += {char(0xc0 | (letter >> 6)), char(0x80 | (letter & 0x3f))};
    const auto before = shape("ä");
    EXPECT_NE(shape(all), grey(60, 60).rgb);
    EXPECT_EQ(shape("ä"), before);
}

TEST_F(Caption, IsCutOffAtTheEdgesAndLeavesThePictureWhole)
{
    const double huge = 1e300, none = std::numeric_limits<double>::quiet_NaN();
    for (const double x : {-huge, -1e9, -3.0, 0.0, 10.0, 25.0, 1e9, huge, none})
        for (const double height : {-1.0, 0.0, 0.001, 8.0, 400.0, 1e6, huge, none}) {
            Image image = grey(20, 10);
            write_text(image, "edges", x, x, height);
            EXPECT_EQ(image.rgb.size(), 600u);
        }
    Image image = grey(20, 10);
    write_text(image, "", 10, 5, 8);
    EXPECT_EQ(image.rgb, grey(20, 10).rgb);
    // What is inside is as in a larger picture.
    Image whole = grey(100, 60), part = grey(50, 30);
    write_text(whole, "edges", 50, 30, 16);
    write_text(part, "edges", 50, 30, 16);
    for (int y = 0; y < 27; ++y)
        for (int x = 0; x < 3 * 47; ++x)
            ASSERT_EQ(part.rgb[std::size_t(y * 150 + x)], whole.rgb[std::size_t(y * 300 + x)])
                << x << ' ' << y;
}

TEST_F(Caption, AHugeOneFillsThePicture)
{
    Image image = grey(40, 30);
    write_text(image, "I", 20, 15, 1e4);
    EXPECT_EQ(image.rgb, std::vector<std::uint8_t>(image.rgb.size(), 255))
        << "inside of the stroke";
}

TEST(Captions, AreReadWithTheSceneAndRefusedWithTheirPlace)
{
    const Folder folder;
    const auto scene = [&](const std::string& captions) {
        write_whole(folder / "s.json", R"({"schema": "knead.scene/1", "domain": {"cells": 16},
            "objects": [{"centre": [0.5, 0.5, 0.5], "diameter": 0.2}],
            "pictures": {"captions": )" + captions +
                                           "}}");
        return read_scene(folder / "s.json", {});
    };
    const Scene two = scene(R"([{"text": "a b", "at": [0.5, 0.25, 1]},
                                {"text": "c", "at": [0, 0, 0]}])");
    ASSERT_EQ(two.captions.size(), 2u);
    EXPECT_EQ(two.captions[0].text, "a b");
    EXPECT_NEAR((two.captions[0].at + two.origin).y, 0.25, 1e-12);
    const auto why = [&](const std::string& captions) {
        return reason<InputError>([&] { scene(captions); });
    };
    const auto says = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    EXPECT_PRED2(says, why("3"), "/pictures/captions: expected an array");
    EXPECT_PRED2(says, why(R"([{"text": "", "at": [0, 0, 0]}])"), "/pictures/captions/0/text");
    EXPECT_PRED2(says, why(R"([{"text": "ä", "at": [0, 0, 0]}])"), "characters of ASCII");
    EXPECT_PRED2(says, why(R"([{"text": "a"}])"), "/pictures/captions/0/at");
    EXPECT_PRED2(says, why(R"([{"text": "a", "at": [0, 0, 0], "size": 3}])"), "size: unknown key");
}

}  // namespace
}  // namespace knead
