// Pictures that are coarse beside what an eye looks at.
#include "cuda/splats/fovea.h"

#include <gtest/gtest.h>

#include "tests/reason.h"
#include "tests/splats/raster_cases.h"

namespace knead {
namespace {

SplatCloud room() { return generated({"small", 20000, 20000, 0.02, 4}); }

// Squares of 64 pixels: 7 x 5, the last ones cut. A splat takes as many pixels as in a headset.
SplatFrame two_eyes()
{
    SplatFrame frame = seen_from(load_eyes("far", 403, 301));
    for (Eye<float>& e : frame.eyes)
        for (float* const side : {&e.left, &e.right, &e.up, &e.down}) *side *= 0.2f;
    return frame;
}

int step_at(const SplatFrame& f, std::size_t e, int x, int y)
{
    const auto first = [](int i) { return i / fovea_square * fovea_square; };
    return fovea_step(f.fovea[e], pinhole(f.eyes[e]), first(x), first(y));
}

bool same(const Picture& a, std::size_t i, const Picture& b, std::size_t j)
{
    return length(a.colour[i] - b.colour[j]) == 0 && a.alpha[i] == b.alpha[j] &&
           a.depth[i] == b.depth[j];
}

TEST(Foveas, ASquareHasTheStepOfItsNearestPoint)
{
    const Pinhole<float> eye = pinhole(plain_eye(640, 640));  // 320 pixels a tangent of 1
    const Fovea<float> f{0.1f, -0.2f, 0.3f, 0.61f};           // at (351.5, 255.5), 96, 195.2
    EXPECT_EQ(fovea_step(f, eye, 320, 192), 1) << "it lies in this square";
    EXPECT_EQ(fovea_step(f, eye, 448, 192), 2) << "96.5 pixels to the right";
    EXPECT_EQ(fovea_step(f, eye, 384, 256), 1);
    EXPECT_EQ(fovea_step(f, eye, 192, 192), 2) << "96.5 to the left";
    EXPECT_EQ(fovea_step(f, eye, 128, 192), 2);
    EXPECT_EQ(fovea_step(f, eye, 64, 192), 4);
    EXPECT_EQ(fovea_step(f, eye, 320, 448), 2);
    EXPECT_EQ(fovea_step(f, eye, 320, 512), 4);
    EXPECT_EQ(fovea_step(Fovea<float>{}, eye, 0, 0), 1) << "where nobody asks for it all is fine";
    const Fovea<float> around = fovea_of(30);
    EXPECT_NEAR(around.fine, std::tan(0.5235988), 1e-6);
    EXPECT_NEAR(around.middling, 1, 1e-6);
    EXPECT_LT(fovea_of(80).middling, 100);
}

TEST(Foveas, OneThatCoversThePictureChangesNoBit)
{
    const SplatCloud cloud = room();
    SplatFrame frame = two_eyes();
    const std::vector<Picture> plain = cpu_raster(cloud, frame);
    frame.fovea = {{0.5f, 0.5f, 20, 30}, {}};
    EXPECT_EQ(blended_share(frame, 0), 1);
    const std::vector<Picture> covered = cpu_raster(cloud, frame);
    for (std::size_t e = 0; e < 2; ++e)
        for (std::size_t i = 0; i < plain[e].pixels(); ++i)
            ASSERT_TRUE(same(plain[e], i, covered[e], i)) << i;
}

TEST(Foveas, BesideOneASampleStandsForItsBlockAndWithinItNothingChanges)
{
    const SplatCloud cloud = room();
    SplatFrame frame = two_eyes();
    const std::vector<Picture> plain = cpu_raster(cloud, frame);
    frame.fovea = {{0.02f, -0.04f, 0.04f, 0.1f}, {-0.06f, 0.02f, 0.06f, 0.12f}};
    const std::vector<Picture> found = cpu_raster(cloud, frame);
    for (std::size_t e = 0; e < 2; ++e) {
        EXPECT_GT(psnr(found[e], plain[e]), 34);
        EXPECT_LT(psnr(found[e], plain[e]), 60);
        int pixels[5] = {}, samples = 0;
        for (int y = 0; y < 301; ++y)
            for (int x = 0; x < 403; ++x) {
                const int step = step_at(frame, e, x, y);
                const auto i = std::size_t(403 * y + x);
                ++pixels[step], samples += x % step == 0 && y % step == 0;
                const auto first = std::size_t(403 * (y / step * step) + x / step * step);
                ASSERT_TRUE(same(found[e], i, found[e], first)) << x << " " << y;
                if (step == 1) {
                    ASSERT_TRUE(same(found[e], i, plain[e], i)) << x << " " << y;
                }
            }
        EXPECT_GT(std::min({pixels[1], pixels[2], pixels[4]}), 4000);
        EXPECT_NEAR(blended_share(frame, e), samples / (403.0 * 301), 1e-12);
        EXPECT_LT(blended_share(frame, e), 0.6);
    }
}

// A sample lies amid its pixels: a slope keeps its mean, at every step.
TEST(Foveas, SamplesAreTakenInTheMiddle)
{
    SplatCloud cloud;
    put(cloud, {0, 0, 2}, {0.8f, 0.8f, 0.8f}, 0.5f, {1, 1, 1});
    SplatFrame frame = seen_from({plain_eye(256, 256)});
    const Picture plain = cpu_raster(cloud, frame).at(0);
    for (const float middling : {1e-3f, 1e3f}) {
        frame.fovea = {{5, 5, 0, middling}};
        const Picture found = cpu_raster(cloud, frame).at(0);
        double mean = 0, mean_found = 0, first_moment = 0;
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x) {
                const auto i = std::size_t(256 * y + x);
                mean += double(plain.alpha[i]), mean_found += double(found.alpha[i]);
                first_moment += (x - 127.5) * double(found.alpha[i]);
            }
        EXPECT_NEAR(mean_found / mean, 1, 1e-3);
        EXPECT_LT(std::fabs(first_moment / mean), 0.01) << "pixels";
    }
}

TEST(Foveas, WhatLiesBehindIsEachPixelsOwn)
{
    SplatFrame frame = two_eyes();
    frame.background = {0.1f, 0.2f, 0.3f};
    Backdrop mesh;
    for (int n = 0; n < 403 * 301; ++n) {
        mesh.depth.push_back(n % 5 ? 0.5f + 0.001f * float(n % 97) : no_depth);
        mesh.colour.push_back({0.1f, float(n % 7) / 7, float(n % 11) / 11});
    }
    frame.behind = {mesh, {}};
    const std::vector<Picture> plain = cpu_raster(SplatCloud{}, frame);
    frame.fovea = {{0, 0, 0.02f, 0.06f}, {0, 0, 0, 0}};
    const std::vector<Picture> found = cpu_raster(SplatCloud{}, frame);
    for (std::size_t e = 0; e < 2; ++e)
        for (std::size_t i = 0; i < plain[e].pixels(); ++i)
            ASSERT_TRUE(same(plain[e], i, found[e], i)) << i;
}

TEST(Foveas, WithoutMeaningAreRefused)
{
    const SplatCloud cloud = generated({"small", 10, 0, 0.02, 4});
    const auto refused = [&](std::vector<Fovea<float>> fovea) {
        SplatFrame frame = seen_from({plain_eye()});
        frame.fovea = std::move(fovea);
        return !reason<std::invalid_argument>([&] { cpu_raster(cloud, frame); }).empty();
    };
    EXPECT_FALSE(refused({{}}));
    EXPECT_FALSE(refused({{0, 0, 0, 0}}));
    EXPECT_TRUE(refused({{}, {}}));
    EXPECT_TRUE(refused({{0, 0, -1, 1}}));
    EXPECT_TRUE(refused({{0, 0, 2, 1}}));
    EXPECT_TRUE(refused({{NAN, 0, 1, 2}}));
    EXPECT_TRUE(refused({{0, 0, 1, HUGE_VALF}}));
}

}  // namespace
}  // namespace knead
