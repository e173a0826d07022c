// Pictures of splats: closed forms for few of them, and the rasteriser of tiles against the one
// that goes through every splat in every pixel, in double.
#include "host/splats/raster.h"

#include <gtest/gtest.h>

#include <numbers>

#include "host/base/parallel.h"
#include "tests/reason.h"
#include "tests/splats/raster_cases.h"

namespace knead {
namespace {

constexpr float far = no_depth;
const Vec3<float> red{1, 0, 0}, blue{0, 0, 1}, grey{0.25f, 0.5f, 0.75f};

double alpha_of(double opacity, double squared, double variance)
{
    const double a = opacity * std::exp(-squared / (2 * variance));
    return a < 1.0 / 255 ? 0 : std::min(a, 0.99);
}

TEST(SplatPictures, OneSplatOnTheAxisIsAGaussianOfItsColourToTheEdgeOfWhatIsDrawn)
{
    SplatCloud c;
    put(c, {0, 0, 2}, {0.2f, 0.2f, 0.2f}, 0.9f, grey);
    const SplatFrame frame = seen_from({plain_eye(101, 81)});
    const double f = 50.5, variance = std::pow(0.2 * f / 2, 2) + 0.3;
    for (const Picture& p : {cpu_raster(c, frame).at(0), exact_raster(c, frame).at(0)})
        for (int y = 0; y < 81; ++y)
            for (int x = 0; x < 101; ++x) {
                const auto i = std::size_t(y * 101 + x);
                const double squared = std::pow(x - 50, 2) + std::pow(y - 40, 2);
                const double a = alpha_of(0.9, squared, variance);
                // At the edge, rounding decides.
                if (std::fabs(0.9 * std::exp(-squared / (2 * variance)) * 255 - 1) < 1e-3) continue;
                ASSERT_NEAR(double(p.alpha[i]), a, 2e-6) << x << " " << y;
                ASSERT_NEAR(double(p.colour[i].x), 0.25 * a, 2e-6);
                ASSERT_NEAR(double(p.colour[i].y), 0.50 * a, 2e-6);
                ASSERT_NEAR(double(p.colour[i].z), 0.75 * a, 2e-6);
                if (a > 0.51)
                    ASSERT_FLOAT_EQ(p.depth[i], 2);
                else
                    ASSERT_EQ(p.depth[i], far);
            }
}

TEST(SplatPictures, OfTwoSplatsTheNearerOneLiesInFrontWhateverTheirOrderInMemory)
{
    for (const bool turned : {false, true}) {
        SplatCloud c;
        put(c, {0, 0, turned ? 3.0f : 2.0f}, {1, 1, 1}, 0.6f, turned ? blue : red);
        put(c, {0, 0, turned ? 2.0f : 3.0f}, {1, 1, 1}, turned ? 0.6f : 0.8f, turned ? red : blue);
        if (turned) c.opacity[0] = 0.8f;
        SplatFrame frame = seen_from({plain_eye(33, 33)});
        frame.background = {0, 1, 0};
        const Picture p = cpu_raster(c, frame).at(0);
        const std::size_t middle = 16 * 33 + 16;
        EXPECT_NEAR(p.colour[middle].x, 0.6, 1e-6);
        EXPECT_NEAR(p.colour[middle].z, 0.4 * 0.8, 1e-6);
        EXPECT_NEAR(p.colour[middle].y, 0.4 * 0.2, 1e-6);
        EXPECT_NEAR(p.alpha[middle], 1 - 0.4 * 0.2, 1e-6);
        EXPECT_FLOAT_EQ(p.depth[middle], 2);
    }
}

TEST(SplatPictures, AThousandInALineLetThroughTheProductOfWhatEachDoes)
{
    for (const float opacity : {0.004f, 0.006f, 0.05f}) {
        SplatCloud c;
        for (int k = 0; k < 1000; ++k)
            put(c, {0, 0, 2 + 0.01f * float(k)}, {3, 3, 3}, opacity, grey);
        SplatFrame frame = seen_from({plain_eye(17, 17)});
        frame.background = red;
        const double through = std::pow(1 - double(opacity), 1000);
        for (const Picture& p : {cpu_raster(c, frame).at(0), exact_raster(c, frame).at(0)}) {
            const Vec3<float> middle = p.colour[8 * 17 + 8];
            // Nothing is added below a transmittance of 1e-4.
            EXPECT_NEAR(middle.x, 0.25 * (1 - through) + through, 1.1e-4);
            EXPECT_NEAR(middle.y, 0.5 * (1 - through), 1.1e-4);
            EXPECT_NEAR(p.alpha[8 * 17 + 8], 1 - through, 1.1e-4);
        }
    }
}

// A bumpy ball in a part of the room, a few thousand splats, in front of both eyes.
SplatCloud small_scene(int object = 3000, int background = 3000)
{
    SplatCloud c = generated({"small", object, background, 0.03, 7});
    for (int i = 0; i < object; ++i) c.scale[std::size_t(i)] = 3.5f * c.scale[std::size_t(i)];
    return c;
}

TEST(SplatPictures, TilesGiveWhatEverySplatInEveryPixelGives)
{
    const SplatCloud c = small_scene();
    for (const char* view : {"far", "near"})
        for (const bool antialiased : {false, true}) {
            SplatFrame frame = seen_from(load_eyes(view, 150, 130));
            frame.background = {0.2f, 0.3f, 0.4f};
            frame.options.antialiased = antialiased;
            const std::vector<Picture> tiles = cpu_raster(c, frame), all = exact_raster(c, frame);
            for (std::size_t e = 0; e < 2; ++e) {
                EXPECT_GE(psnr(tiles[e], all[e]), 60) << view << e << antialiased;
                EXPECT_GE(*std::max_element(all[e].alpha.begin(), all[e].alpha.end()), 0.9f);
            }
        }
}

TEST(SplatPictures, OneOrderForBothEyesGivesWhatOneForEachGives)
{
    const SplatCloud c = generated(splat_loads().at(0));
    for (const char* view : {"far", "near45"}) {
        const SplatFrame both = seen_from(load_eyes(view, 240, 256));
        const std::vector<Picture> shared = cpu_raster(c, both);
        for (std::size_t e = 0; e < 2; ++e) {
            const Picture own = cpu_raster(c, seen_from({both.eyes[e]})).at(0);
            EXPECT_GE(psnr(shared[e], own), 45) << view << e;
        }
    }
}

// The same scene turned as a whole, with and without the eye: colours by direction turn with F.
TEST(SplatPictures, ATurnedObjectIsWhatAnEyeTurnedTheOtherWaySees)
{
    const SplatCloud c = small_scene(4000, 0);
    Draw draw(3);
    for (int k = 0; k < 4; ++k) {
        const Mat3<double> Q = draw.rotation();
        SplatFrame moved = seen_from({eye_looking({0, 0, -0.6}, {0, 0, 0}, 1, 128, 128)});
        SplatFrame turned = moved;
        for (const Vec3<float> x : c.centre) {
            moved.moved_centre.push_back(cast<float>(Q * cast<double>(x)));
            moved.moved_F.push_back(cast<float>(Q));
        }
        Eye<float>& eye = turned.eyes[0];
        eye.position = cast<float>(transpose(Q) * cast<double>(eye.position));
        eye.rotation =
            cast<float>(quaternion(transpose(Q) * rotation(unit(cast<double>(eye.rotation)))));
        EXPECT_GE(psnr(cpu_raster(c, moved).at(0), cpu_raster(c, turned).at(0)), 60);
        EXPECT_LT(furthest(exact_raster(c, moved).at(0), exact_raster(c, turned).at(0)), 2e-2);
    }
}

// Twice as large at twice the distance is the same picture; so is F A F^T for a stretch.
TEST(SplatPictures, AStretchedSplatIsOneOfStretchedHalfAxes)
{
    SplatCloud plain, long_one;
    put(plain, {0.1f, 0.2f, 2}, {0.1f, 0.1f, 0.1f}, 0.9f, grey);
    put(long_one, {0.1f, 0.2f, 2}, {0.3f, 0.1f, 0.05f}, 0.9f, grey);
    SplatFrame frame = seen_from({plain_eye(99, 99)}), stretched = frame;
    stretched.moved_centre = plain.centre;
    stretched.moved_F = {{{3, 0, 0}, {0, 1, 0}, {0, 0, 0.5f}}};
    EXPECT_LT(furthest(cpu_raster(plain, stretched).at(0), cpu_raster(long_one, frame).at(0)),
              1e-5);
    // A mirror image has no rotation of its own; it is drawn all the same.
    stretched.moved_F = {{{-3, 0, 0}, {0, 1, 0}, {0, 0, 0.5f}}};
    EXPECT_LT(furthest(cpu_raster(plain, stretched).at(0), cpu_raster(long_one, frame).at(0)),
              1e-5);
}

// A ball of mesh in a block of many small splats, opaque together: in front of it only what lies
// in front is seen, and where the block ends before the ball does, the ball.
TEST(SplatPictures, AMeshHidesWhatLiesBehindItAndNothingElse)
{
    constexpr int side = 96;
    const Eye<float> eye = plain_eye(side, side);
    const Pinhole<float> cam = pinhole(eye);
    SplatFrame frame = seen_from({eye});
    Backdrop ball;
    const Vec3<float> centre{0, 0, 2};
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const Vec3<float> d{(float(x) - cam.cx) / cam.fx, (float(y) - cam.cy) / cam.fy, 1};
            const float b = dot(d, centre), a = dot(d, d),
                        q = b * b - a * (dot(centre, centre) - 0.5f * 0.5f);
            ball.depth.push_back(q > 0 ? (b - std::sqrt(q)) / a : no_depth);
            ball.colour.push_back(q > 0 ? Vec3<float>{0, 1, 0} : Vec3<float>{0, 0, 0});
        }
    frame.behind = {ball};
    // Red in front of z = 2, as far as the ball lets it be, blue behind.
    SplatCloud front, block;
    Draw draw(9);
    const float size = 0.02f;
    for (int k = 0; k < 30000; ++k) {
        const Vec3<float> x =
            cast<float>(Vec3<double>{draw.in(-0.4, 0.4), draw.in(-0.4, 0.4), draw.in(1.3, 2.7)});
        put(block, x, {size, size, size}, 0.3f, x.z < 2 ? red : blue);
        // What no part of which can lie in front of the ball may be left out.
        if (x.z < 1.95f + 4 * size) put(front, x, {size, size, size}, 0.3f, x.z < 2 ? red : blue);
    }
    const Picture p = cpu_raster(block, frame).at(0), exact = exact_raster(block, frame).at(0);
    EXPECT_GE(psnr(p, exact), 45);
    EXPECT_GE(psnr(exact_raster(front, frame).at(0), exact), 60);
    // Through the thickest of the block, the ball's front is 0.2 m in: the density along a ray is
    // known, and with it what reaches the ball.
    const double density = 30000 / (0.8 * 0.8 * 1.4);
    double expected = 0, found = 0;
    int pixels = 0;
    for (int y = 40; y < 56; ++y)
        for (int x = 40; x < 56; ++x) {
            const auto i = std::size_t(y * side + x);
            const double variance = std::pow(double(size) * 48 / 1.4, 2) + 0.3;
            const double spread = std::sqrt(variance) / 48 * 1.4;
            const double per_metre = density * 2 * std::numbers::pi * spread * spread;
            // Of a Gaussian alpha of opacity o: -log(1 - alpha) summed over the plane is Li2(o).
            const double li2 = 0.3 + 0.09 / 4 + 0.027 / 9 + 0.0081 / 16 + 0.00243 / 25;
            expected += std::exp(-per_metre * li2 * (double(ball.depth[i]) - 1.3));
            found += double(p.colour[i].y);
            ++pixels;
            EXPECT_EQ(p.alpha[i], 1);
            EXPECT_LT(p.colour[i].z, 1e-3);
        }
    EXPECT_NEAR(found / pixels, expected / pixels, 0.25 * expected / pixels + 0.005);
}

TEST(SplatPictures, SplatsFadeOutAsTheEyeComesNear)
{
    double before = 2;
    for (const float z : {0.2f, 0.08f, 0.07f, 0.055f, 0.04f, 0.031f, 0.03f, 0.01f, -0.5f}) {
        SplatCloud c;
        put(c, {0, 0, z}, {0.02f, 0.02f, 0.02f}, 0.9f, grey);
        const double a = double(cpu_raster(c, seen_from({plain_eye()})).at(0).alpha[32 * 65 + 32]);
        if (z >= 0.08f) {
            EXPECT_NEAR(a, 0.9, 1e-5);
        }
        if (z == 0.055f) {
            EXPECT_NEAR(a, 0.45, 1e-5);
        }
        if (z <= 0.03f) {
            EXPECT_EQ(a, 0);
        }
        EXPECT_LE(a, before + 1e-5);
        before = a;
    }
}

TEST(SplatPictures, WhatCannotBeDrawnIsLeftOutAndTheRestIsDrawn)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = HUGE_VALF;
    SplatCloud good;
    put(good, {0, 0, 2}, {0.3f, 0.3f, 0.3f}, 0.7f, grey);
    const SplatFrame frame = seen_from({plain_eye()});
    const Picture alone = cpu_raster(good, frame).at(0);
    SplatCloud c = good;
    for (const float bad : {nan, inf, -inf, 1e30f}) {
        put(c, {bad, 0, 1}, {0.1f, 0.1f, 0.1f}, 0.9f, red);
        put(c, {0, bad, 1}, {0.1f, 0.1f, 0.1f}, 0.9f, red);
        put(c, {0, 0, -bad}, {0.1f, 0.1f, 0.1f}, 0.9f, red);  // at 1e30 m it would be a point
        put(c, {0, 0, 1}, {bad, 0.1f, 0.1f}, 0.9f, red);
        put(c, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, 0.9f, red, {0.5f, bad, 0, 0});
    }
    put(c, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, nan, red);
    put(c, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, -1, red);
    put(c, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, 0, red);
    put(c, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, 0.003f, red);  // less than 1 / 255
    put(c, {0, 0, -1}, {0.1f, 0.1f, 0.1f}, 0.9f, red);   // behind the eye
    put(c, {5, 0, 1}, {0.1f, 0.1f, 0.1f}, 0.9f, red);    // beside it
    put(c, {0, -5, 0.1f}, {0.1f, 0.1f, 0.1f}, 0.9f, red);
    EXPECT_EQ(furthest(cpu_raster(c, frame).at(0), alone), 0);
    EXPECT_LT(furthest(exact_raster(c, frame).at(0), alone), 1e-5);
    // A colour that is no number is black.
    put(c, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, 0.9f, {nan, 1, inf});
    EXPECT_TRUE(finite(cpu_raster(c, frame).at(0)));
    EXPECT_TRUE(finite(cpu_raster(SplatCloud{}, frame).at(0)));
    EXPECT_EQ(cpu_raster(SplatCloud{}, frame).at(0).depth.at(7), far);
}

TEST(SplatPictures, AnOpaqueSplatHidesButForAHundredthAndAPointIsAsLargeAsThePixelFilter)
{
    SplatCloud c;
    put(c, {0, 0, 2}, {1, 1, 1}, 1, red);
    put(c, {0, 0, 3}, {1, 1, 1}, 7, blue);  // 1, too
    const Vec3<float> middle = cpu_raster(c, seen_from({plain_eye()})).at(0).colour[32 * 65 + 32];
    EXPECT_NEAR(middle.x, 0.99, 1e-6);
    EXPECT_NEAR(middle.z, 0.01 * 0.99, 1e-6);

    SplatCloud point, disc, needle;
    put(point, {0, 0, 2}, {0, 0, 0}, 0.9f, red);
    put(disc, {0, 0, 2}, {0.1f, 0.1f, 0}, 0.9f, red);
    put(needle, {0, 0, 2}, {3e-6f, 1e4f, 1e-9f}, 0.9f, red,
        {std::cos(0.35f), 0, 0, std::sin(0.35f)});
    SplatFrame frame = seen_from({plain_eye()});
    for (const SplatCloud& one : {point, disc, needle}) {
        const Picture p = cpu_raster(one, frame).at(0);
        EXPECT_TRUE(finite(p));
        EXPECT_GE(psnr(p, exact_raster(one, frame).at(0)), 60);
        EXPECT_NEAR(p.alpha[32 * 65 + 32], 0.9, 1e-4);
    }
    const Picture p = cpu_raster(point, frame).at(0);
    EXPECT_NEAR(p.alpha[32 * 65 + 33], 0.9 * std::exp(-1 / 0.6), 1e-5);
    frame.options.antialiased = true;  // of no area: nothing is left of it
    EXPECT_EQ(cpu_raster(point, frame).at(0).alpha[32 * 65 + 32], 0);
}

TEST(SplatPictures, AHugeSplatCoversThePictureAndOneBeyondAllMeasureIsLeftOut)
{
    for (const float size : {10.0f, 1e4f, 1e5f}) {
        SplatCloud c;
        put(c, {0, 0, 2}, {size, size, size}, 0.5f, grey);
        const Picture p = cpu_raster(c, seen_from({plain_eye()})).at(0);
        EXPECT_NEAR(p.alpha[0], 0.5, 0.02);
        EXPECT_NEAR(p.alpha[64 * 65 + 64], 0.5, 0.02);
    }
}

TEST(SplatPictures, AreTheSameToTheBitForAnyNumberOfThreads)
{
    const SplatCloud c = small_scene();
    const SplatFrame frame = seen_from(load_eyes("far", 100, 90));
    const int threads = loop_threads();
    std::vector<Picture> first;
    for (const int n : {1, 2, 5}) {
        set_loop_threads(n);
        const std::vector<Picture> now = cpu_raster(c, frame);
        if (first.empty()) first = now;
        EXPECT_EQ(furthest(now[0], first[0]), 0);
        EXPECT_EQ(furthest(now[1], first[1]), 0);
        EXPECT_EQ(now[0].depth, first[0].depth);
    }
    set_loop_threads(threads);
}

TEST(SplatPictures, AreTheSameWhateverTheOrderInMemoryAndSplatsThatMayMoveKeepTheirPlaces)
{
    const SplatCloud c = small_scene();
    SplatCloud sorted = c;
    sort_by_place(sorted, 1000);
    double near = 0, near_before = 0;
    for (std::size_t i = 1000; i + 1 < c.count(); ++i) {
        near += double(length(sorted.centre[i + 1] - sorted.centre[i]));
        near_before += double(length(c.centre[i + 1] - c.centre[i]));
    }
    EXPECT_LT(near, 0.3 * near_before);
    for (std::size_t i = 0; i < 1000; ++i) {
        EXPECT_EQ(sorted.centre[i].x, c.centre[i].x);
        EXPECT_EQ(sorted.sh[i * 16 + 7].z, c.sh[i * 16 + 7].z);
    }
    const SplatFrame frame = seen_from(load_eyes("far", 100, 90));
    EXPECT_GE(psnr(cpu_raster(sorted, frame).at(1), cpu_raster(c, frame).at(1)), 60);
    put(sorted, {NAN, HUGE_VALF, -1e30f}, {1, 1, 1}, 1, grey);
    sorted.sh.resize(sorted.count() * 16);
    sort_by_place(sorted);
    EXPECT_EQ(sorted.count(), c.count() + 1);
}

TEST(SplatPictures, FramesWithoutMeaningAreRefused)
{
    SplatCloud c = small_scene(10, 0);
    const auto refused = [&](auto&& spoil) {
        SplatFrame frame = seen_from({plain_eye()});
        spoil(frame);
        return !reason<std::invalid_argument>([&] { cpu_raster(c, frame); }).empty();
    };
    EXPECT_FALSE(refused([](SplatFrame&) {}));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes.clear(); }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes.resize(3, f.eyes[0]); }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes[0].width = 0; }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes[0].width = 1 << 20; }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes[0].right = f.eyes[0].left; }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes[0].rotation = {0, 0, 0, 0}; }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.eyes[0].position.x = NAN; }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.options.near = 0; }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.behind.resize(2); }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.behind.resize(1), f.behind[0].depth.resize(5); }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.moved_centre.resize(3); }));
    EXPECT_TRUE(refused([](SplatFrame& f) { f.moved_centre.resize(11), f.moved_F.resize(11); }));
    EXPECT_TRUE(refused([&](SplatFrame&) { c.opacity.pop_back(); }));
}

}  // namespace
}  // namespace knead
