// Words in pictures: where they are asked for, and nothing else; how scenes name them.
#include "host/picture/lettering.h"

#include <gtest/gtest.h>

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

TEST(Lettering, StandsInTheMiddleOfItsPlaceAndIsAsHighAsAsked)
{
    Image image = grey(200, 100);
    write_text(image, "HUH", 100, 40, 24);
    const Extent e = written(image);
    EXPECT_NEAR(e.left + e.right, 200, 3);
    EXPECT_NEAR(e.top + e.bottom, 80, 3);
    EXPECT_NEAR(e.bottom - e.top, 24, 5);
    EXPECT_NEAR(e.right - e.left, 4 * 16, 6);  // 16 units of a sixth of the height
    EXPECT_EQ(image.rgb[0], 128);
}

TEST(Lettering, EveryCharacterHasAShapeOfItsOwn)
{
    const auto shape = [](char c) {
        Image image = grey(40, 60);
        write_text(image, std::string(1, c), 20, 25, 24);
        return image.rgb;
    };
    const std::vector<std::uint8_t> blank = grey(40, 60).rgb;
    const std::string letters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,:;-+=/%()'!?_<>[]|~";
    EXPECT_EQ(shape(' '), blank);
    for (std::size_t a = 0; a < letters.size(); ++a) {
        EXPECT_NE(shape(letters[a]), blank) << letters[a];
        for (std::size_t b = 0; b < a; ++b)
            EXPECT_NE(shape(letters[a]), shape(letters[b])) << letters[a] << letters[b];
    }
    EXPECT_EQ(shape('\xe4'), shape('\x01'));  // a box
}

TEST(Lettering, IsCutOffAtTheEdgesAndLeavesThePictureWhole)
{
    for (const double x : {-1e9, -3.0, 0.0, 10.0, 25.0, 1e9, 1e300})
        for (const double height : {0.001, 8.0, 400.0}) {
            Image image = grey(20, 10);
            write_text(image, "edges", x, x, height);
            EXPECT_EQ(image.rgb.size(), 600u);
        }
    Image image = grey(20, 10);
    write_text(image, "", 10, 5, 8);
    EXPECT_EQ(image.rgb, grey(20, 10).rgb);
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
