// Pictures of splats that are given up: soon, at whatever stage, and whole where nobody asks for
// it.
#include <gtest/gtest.h>

#include "host/base/parallel.h"
#include "host/picture/splat_picture.h"
#include "host/splats/cancellable_for.h"
#include "host/splats/raster.h"
#include "tests/asks.h"
#include "tests/splats/raster_cases.h"

namespace knead {
namespace {

constexpr double soon = 0.1;  // [s] of the processor
constexpr int never = 1 << 30;

// One thread, so that its questions are all that are asked.
class StoppedPictures : public testing::Test {
  protected:
    void SetUp() override { set_loop_threads(1); }
    void TearDown() override { set_loop_threads(threads); }

    const int threads = loop_threads();
    Asks asks;
};

// Side by side before the eye, the nearest last.
SplatCloud many(int count)
{
    SplatCloud c;
    for (int i = 0; i < count; ++i)
        put(c, {float(i % 1000) / 500 - 1, 0, 3 - float(i) / float(count)}, {0.01f, 0.01f, 0.01f},
            0.5f, {1, 0, 0});
    return c;
}

TEST_F(StoppedPictures, AHugeOneAsksAllTheWay)
{
    SplatCloud c;
    put(c, {0, 0, 2}, {0.5f, 0.5f, 0.5f}, 0.9f, {1, 0, 0});
    SplatFrame frame = seen_from({plain_eye(8192, 4096)});
    frame.stop = asks.until(never);
    const std::vector<Picture> pictures = cpu_raster(c, frame);
    EXPECT_LT(asks.longest_wait(), soon);
    ASSERT_EQ(pictures.size(), 1u);

    const std::function<bool()> stop = asks.until(never);
    const Image image = image_of(pictures, stop);
    EXPECT_LT(asks.longest_wait(), soon);
    EXPECT_EQ(image.rgb.size(), std::size_t(3) * 8192 * 4096);
}

TEST_F(StoppedPictures, OneOfManySplatsAsksAllTheWay)
{
    const SplatCloud c = many(2000000), fewer = many(500000);
    SplatFrame frame = seen_from({plain_eye(64, 16)});
    frame.stop = asks.until(never);
    EXPECT_EQ(cpu_raster(c, frame).size(), 1u);
    EXPECT_LT(asks.longest_wait(), soon);
    frame.eyes = {plain_eye(4, 1)};
    frame.stop = asks.until(never);
    EXPECT_EQ(exact_raster(fewer, frame).size(), 1u);
    EXPECT_LT(asks.longest_wait(), soon);
}

TEST_F(StoppedPictures, WhereverItIsGivenUpThereIsNone)
{
    const SplatCloud c = many(70000);
    SplatFrame frame = seen_from({plain_eye(64, 64), plain_eye(64, 64)});
    for (const bool exact : {false, true}) {
        frame.stop = {};
        if (exact) frame.eyes = {plain_eye(3, 2)};
        const auto draw = [&] { return exact ? exact_raster(c, frame) : cpu_raster(c, frame); };
        const std::vector<Picture> whole = draw();
        frame.stop = asks.until(never);
        const std::vector<Picture> polled = draw();
        ASSERT_EQ(polled.size(), frame.eyes.size());
        for (std::size_t e = 0; e < polled.size(); ++e) EXPECT_EQ(furthest(polled[e], whole[e]), 0);
        const int all = asks.count;
        EXPECT_GT(all, 20);
        for (int n = 1; n <= all; n = n < 40 ? n + 1 : n + n / 5) {
            frame.stop = asks.until(n);
            EXPECT_TRUE(draw().empty()) << n << " of " << all;
            EXPECT_GE(asks.count, n);
        }
    }
}

TEST_F(StoppedPictures, ThereIsNoImageOfOneThatIsGivenUp)
{
    const SplatCloud c = many(100);
    const Image image{32, 16, std::vector<std::uint8_t>(3 * 32 * 16, 200)};
    const std::vector<float> depths(32 * 16, 1e9f);
    Camera camera;
    camera.eye = {0, 0, 0}, camera.target = {0, 0, 2}, camera.width = 32, camera.height = 16;
    EXPECT_EQ(with_splats(image, depths, camera, c, {}, asks.until(never)).rgb.size(),
              3u * 32 * 16);
    const int all = asks.count;
    for (const int n : {1, 2, 3, 4, 5, 6, all / 2, all - 1, all}) {
        EXPECT_TRUE(with_splats(image, depths, camera, c, {}, asks.until(n)).rgb.empty()) << n;
        EXPECT_LE(asks.count, n + 10);
    }
}

TEST(SortUnlessStopped, SortsAsStableSortDoes)
{
    for (const std::size_t n : {0, 1, 1000, 32768, 32769, 65536, 200000}) {
        std::vector<std::pair<int, std::size_t>> v;
        for (std::size_t i = 0; i < n; ++i) v.push_back({int(i * 2654435761u % 1009), i});
        std::vector<std::pair<int, std::size_t>> expected = v;
        const auto less = [](const auto& a, const auto& b) { return a.first < b.first; };
        std::stable_sort(expected.begin(), expected.end(), less);
        EXPECT_TRUE(sort_unless_stopped(v, SplatFrame{}, less));
        EXPECT_EQ(v, expected) << n;
    }
}

}  // namespace
}  // namespace knead
