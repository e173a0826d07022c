// The device's pictures of splats against the CPU's: what a colour of 16 bits allows.
#include "host/splats/gpu_raster.h"

#include <gtest/gtest.h>

#include "host/solver/editable_simulator.h"
#include "tests/reason.h"
#include "tests/splats/raster_cases.h"

namespace knead {
namespace {

class GpuSplatPictures : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

// Pixels in which depth differs, of those that have one: where transmittance passes 1/2, rounding
// may choose the splat before or after.
double depths_apart(const Picture& a, const Picture& b)
{
    std::size_t apart = 0;
    for (std::size_t i = 0; i < a.pixels(); ++i)
        apart += std::fabs(a.depth[i] - b.depth[i]) > 1e-3f * b.depth[i];
    return double(apart) / double(a.pixels());
}

void expect_same(const std::vector<Picture>& device, const std::vector<Picture>& host)
{
    ASSERT_EQ(device.size(), host.size());
    for (std::size_t e = 0; e < host.size(); ++e) {
        EXPECT_GE(psnr(device[e], host[e]), 60) << "eye " << e;
        EXPECT_LT(depths_apart(device[e], host[e]), 2e-3) << "eye " << e;
        double alpha = 0;
        for (std::size_t i = 0; i < host[e].pixels(); ++i)
            alpha = std::max(alpha, double(std::fabs(device[e].alpha[i] - host[e].alpha[i])));
        EXPECT_LT(alpha, 0.02) << "eye " << e;
    }
}

TEST_F(GpuSplatPictures, AreTheCpusForTwoEyesAndForOneNearAndFar)
{
    const SplatCloud cloud = generated(splat_loads().at(0));
    GpuRaster raster(cloud);
    for (const char* view : {"far", "near45", "near"}) {
        SplatFrame frame = seen_from(load_eyes(view, 500, 530));  // no whole number of tiles
        frame.background = {0.1f, 0.2f, 0.3f};
        expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
        EXPECT_EQ(raster.stats().dropped, 0u);
        frame.eyes.resize(1);
        frame.options.antialiased = true;
        expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    }
}

TEST_F(GpuSplatPictures, AreTheCpusForEveryDegreeOfColour)
{
    const SplatCloud full = generated({"small", 20000, 20000, 0.02, 3});
    for (int degree = 0; degree <= max_sh_degree; ++degree) {
        SplatCloud cloud = full;
        cloud.degree = degree;
        cloud.sh.clear();
        for (std::size_t i = 0; i < full.count(); ++i)
            for (int k = 0; k < harmonics(degree); ++k)
                cloud.sh.push_back(
                    full.sh[i * std::size_t(harmonics(max_sh_degree)) + std::size_t(k)]);
        const SplatFrame frame = seen_from(load_eyes("far", 320, 320));
        expect_same(GpuRaster(cloud).pictures(frame), cpu_raster(cloud, frame));
    }
}

TEST_F(GpuSplatPictures, AreTheCpusForSplatsThatMoveAndAMeshBetweenThem)
{
    const SplatCloud cloud = generated({"small", 30000, 30000, 0.02, 4});
    SplatFrame frame = seen_from(load_eyes("far", 320, 288));
    Draw draw(11);
    const Mat3<double> Q = draw.rotation();
    for (std::size_t i = 0; i < 25000; ++i) {
        const Mat3<double> F{1.3 * Q.a, 0.8 * Q.b, Q.c + 0.2 * Q.a};
        frame.moved_centre.push_back(cast<float>(F * cast<double>(cloud.centre[i])));
        frame.moved_F.push_back(cast<float>(F));
    }
    GpuRaster raster(cloud);
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    for (std::size_t e = 0; e < 2; ++e) {
        Backdrop mesh;
        for (int y = 0; y < 288; ++y)
            for (int x = 0; x < 320; ++x) {
                mesh.depth.push_back(x + y < 250 ? 0.45f + 0.001f * float(y) : no_depth);
                mesh.colour.push_back({0.1f, float(x) / 320, float(y) / 288});
            }
        frame.behind.push_back(mesh);
    }
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    frame.behind[1] = {};
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    GpuRaster fewer(generated({"small", 20000, 0, 0.02, 4}));
    EXPECT_NE(reason<std::invalid_argument>([&] { fewer.pictures(frame); }), "");
}

// A mesh that is nearer from row to row, in a part of the picture.
Backdrop half_before(const Eye<float>& eye)
{
    Backdrop mesh;
    for (int n = 0; n < eye.width * eye.height; ++n) {
        const int x = n % eye.width, y = n / eye.width;
        mesh.depth.push_back(2 * x > y ? 0.6f - 0.5f * float(y) / float(eye.height) : no_depth);
        mesh.colour.push_back({0.1f, float(x % 7) / 7, float(y % 5) / 5});
    }
    return mesh;
}

// With a mesh half in front of them, through one rasteriser whose pictures change their size.
TEST_F(GpuSplatPictures, AreTheCpusNearAMeshInPicturesOfAnySize)
{
    const SplatCloud cloud = generated({"small", 20000, 20000, 0.02, 4});
    GpuRaster raster(cloud);
    for (const auto& [width, height] : {std::pair{64, 64}, {129, 97}, {200, 70}, {81, 260}}) {
        SplatFrame frame = seen_from(load_eyes("near", width, height));
        for (const Eye<float>& eye : frame.eyes) frame.behind.push_back(half_before(eye));
        expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
        frame.behind.clear(), frame.eyes.resize(1);
        expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    }
    const SplatFrame tiny = seen_from(load_eyes("near", 5, 3));
    EXPECT_GE(psnr(raster.pictures(tiny)[1], cpu_raster(cloud, tiny)[1]), 60);
}

// A first frame lists all tiles by parts, later ones whole where that is cheaper; a rasteriser that
// saw something else before chooses otherwise again.
TEST_F(GpuSplatPictures, AreTheSameToTheBitHoweverTilesAreListed)
{
    const SplatCloud cloud = generated(splat_loads().at(0));
    const std::size_t count = 63 * 51;  // squares of hidden
    for (const char* view : {"far", "near"})
        for (const bool masked : {false, true}) {
            SplatFrame frame = seen_from(load_eyes(view, 1001, 803));
            frame.fovea = {Fovea<float>{}, fovea_of(masked ? 10 : 20)};
            if (masked) {
                for (const Eye<float>& eye : frame.eyes) frame.behind.push_back(half_before(eye));
                frame.hidden = {std::vector<char>(count, 0), std::vector<char>(count, 0)};
                for (std::size_t n = 0; n < count; n += 3) frame.hidden[n % 2][n] = 1;
            }
            GpuRaster raster(cloud, std::size_t(1) << 24);
            const std::vector<Picture> by_parts = raster.pictures(frame);
            const std::size_t most = raster.stats().instances;
            const std::vector<Picture> mixed = raster.pictures(frame);
            const std::size_t fewer = raster.stats().instances;
            if (std::string(view) == "near") {
                EXPECT_LT(fewer, most) << "tiles that are listed whole";
            }
            EXPECT_LE(fewer, most);
            raster.pictures(seen_from(load_eyes("near45", 1001, 803)));
            const std::vector<Picture> other = raster.pictures(frame);
            EXPECT_EQ(raster.stats().dropped, 0u);
            for (std::size_t e = 0; e < 2; ++e)
                for (const auto* again : {&mixed, &other}) {
                    EXPECT_EQ(furthest((*again)[e], by_parts[e]), 0) << view << masked;
                    EXPECT_EQ((*again)[e].depth, by_parts[e].depth) << view << masked;
                }
        }
}

// All of a large cloud in a few tiles: whole lists would be longer than a block should look
// through.
TEST_F(GpuSplatPictures, AreListedByPartsWhereTheyAreSeenSmall)
{
    const SplatCloud cloud = generated({"small", 200000, 0, 0.02, 4});
    const SplatFrame frame = seen_from({eye_looking({0, 0, -3}, {0, 0, 0}, 1, 640, 640),
                                        eye_looking({0.06, 0, -3}, {0, 0, 0}, 1, 640, 640)});
    GpuRaster raster(cloud);
    const std::vector<Picture> first = raster.pictures(frame);
    const std::size_t instances = raster.stats().instances;
    EXPECT_EQ(furthest(raster.pictures(frame)[0], first[0]), 0);
    EXPECT_EQ(raster.stats().instances, instances);
    expect_same(first, cpu_raster(cloud, frame));
    EXPECT_GT(raster.stats().deferred, 0u) << "long lists are shared out";
    SplatFrame coarse = frame;
    coarse.fovea = {fovea_of(1), {0.02f, 0, 0, 0.02f}};
    expect_same(raster.pictures(coarse), cpu_raster(cloud, coarse));
    for (int e = 0; e < 2; ++e) coarse.behind.push_back(half_before(frame.eyes[0]));
    expect_same(raster.pictures(coarse), cpu_raster(cloud, coarse));
    EXPECT_GT(raster.stats().deferred, 0u);
}

TEST_F(GpuSplatPictures, AreTheCpusBesideAFovea)
{
    const SplatCloud cloud = generated({"small", 20000, 20000, 0.02, 4});
    GpuRaster raster(cloud);
    SplatFrame frame = seen_from(load_eyes("far", 403, 301));
    frame.background = {0.1f, 0.2f, 0.3f};
    const auto plain = raster.pictures(frame);
    frame.fovea = {{}, {0, 0, 20, 30}};
    EXPECT_EQ(furthest(raster.pictures(frame)[1], plain[1]), 0);
    frame.fovea = {{0.1f, -0.2f, 0.2f, 0.5f}, {-0.3f, 0.1f, 0.1f, 0.1f}};
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    EXPECT_LT(psnr(raster.pictures(frame)[1], plain[1]), 60);
    frame.hidden = {std::vector<char>(26 * 19, 0), {}};
    for (std::size_t t = 0; t < 26 * 19; t += 3) frame.hidden[0][t] = 1;
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    for (int e = 0; e < 2; ++e) frame.behind.push_back(half_before(frame.eyes[0]));
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    frame.fovea.clear(), frame.behind.clear(), frame.hidden.clear();
    EXPECT_EQ(furthest(raster.pictures(frame)[1], plain[1]), 0);
}

TEST_F(GpuSplatPictures, AreTheSameToTheBitAgainAndAgain)
{
    const SplatCloud cloud = generated(splat_loads().at(0));
    const SplatFrame frame = seen_from(load_eyes("near", 400, 400));
    GpuRaster raster(cloud);
    const std::vector<Picture> first = raster.pictures(frame);
    for (int k = 0; k < 3; ++k) {
        const std::vector<Picture> again = raster.pictures(frame);
        EXPECT_EQ(furthest(again[0], first[0]), 0);
        EXPECT_EQ(furthest(again[1], first[1]), 0);
        EXPECT_EQ(again[1].depth, first[1].depth);
    }
}

TEST_F(GpuSplatPictures, AreEmptyWhereNobodySeesThem)
{
    const SplatCloud cloud = generated({"small", 20000, 0, 0.02, 4});
    SplatFrame frame = seen_from({plain_eye(160, 120), plain_eye(160, 120)});
    GpuRaster raster(cloud);
    const auto whole = raster.pictures(frame);
    frame.hidden = {std::vector<char>(80, 0), {}};
    for (std::size_t t = 0; t < 80; t += 3) frame.hidden[0][t] = 1;
    const auto masked = raster.pictures(frame);
    expect_same(masked, cpu_raster(cloud, frame));
    EXPECT_LT(psnr(masked[0], whole[0]), 40);
    EXPECT_EQ(psnr(masked[1], whole[1]), 200) << "of the other eye all is seen";
    for (std::size_t y = 0; y < 4; ++y)  // one whole tile, beside squares of others
        for (std::size_t x = 4; x < 8; ++x) frame.hidden[0][10 * y + x] = 1;
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    std::swap(frame.hidden[0], frame.hidden[1]);
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    std::swap(frame.hidden[0], frame.hidden[1]);
    frame.hidden[0].assign(80, 1);
    const Picture nothing = raster.pictures(frame)[0];
    for (const float alpha : nothing.alpha) ASSERT_EQ(alpha, 0);
    frame.hidden.clear();
    EXPECT_EQ(psnr(raster.pictures(frame)[0], whole[0]), 200);
}

TEST_F(GpuSplatPictures, AreOfAnotherCloudOnceItIsShown)
{
    const SplatCloud first = generated({"small", 3000, 0, 0.02, 4});
    const SplatCloud more = generated({"small", 3700, 0, 0.02, 5});
    const SplatFrame frame = seen_from({plain_eye(160, 120)});
    GpuRaster raster(first, 0, -1, 4000);
    EXPECT_TRUE(raster.serves(more));
    expect_same(raster.pictures(frame), cpu_raster(first, frame));
    raster.prepare(more);
    expect_same(raster.pictures(frame), cpu_raster(first, frame));
    raster.show_prepared();
    expect_same(raster.pictures(frame), cpu_raster(more, frame));
    raster.prepare(first), raster.show_prepared();
    expect_same(raster.pictures(frame), cpu_raster(first, frame));
    const SplatCloud many = generated({"small", 4001, 0, 0.02, 5});
    EXPECT_FALSE(raster.serves(many));
    EXPECT_THROW(raster.prepare(many), std::invalid_argument);
}

// What is nearest stays: every pixel is that of a cloud without its farthest splats.
TEST_F(GpuSplatPictures, WhereThereIsNoRoomTheFarthestAreLeftOutAndCounted)
{
    SplatCloud cloud;
    cloud.degree = 0;
    for (int k = 0; k < 64; ++k)
        put(cloud, {0, 0, 1 + 0.1f * float(k)}, {20, 20, 20}, 0.3f, {float(k % 2), 0.5f, 0.2f});
    const SplatFrame frame = seen_from({plain_eye(160, 160)});  // 50 parts of 9 tiles
    SplatCloud nearest;
    for (int k = 0; k < 16; ++k)
        put(nearest, cloud.centre[std::size_t(k)], {20, 20, 20}, 0.3f, {float(k % 2), 0.5f, 0.2f});
    GpuRaster raster(cloud, 800);
    const std::vector<Picture> found = raster.pictures(frame);
    EXPECT_EQ(raster.stats().instances, 3200u);
    EXPECT_EQ(raster.stats().dropped, 2400u);
    EXPECT_EQ(raster.stats().visible, 64u);
    expect_same(found, cpu_raster(nearest, frame));
    // The next frame lists its tiles whole, for which there is room enough.
    expect_same(raster.pictures(frame), cpu_raster(cloud, frame));
    EXPECT_EQ(raster.stats().instances, 576u);
    EXPECT_EQ(raster.stats().dropped, 0u);
    // Left to choose, it takes room for all.
    GpuRaster roomy(cloud);
    expect_same(roomy.pictures(frame), cpu_raster(cloud, frame));
    EXPECT_EQ(roomy.stats().dropped, 0u);
}

TEST_F(GpuSplatPictures, NumbersThatCannotBeDrawnDoNoHarm)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = HUGE_VALF;
    SplatCloud cloud;
    for (int k = 0; k < 200; ++k)
        put(cloud, {0.01f * float(k % 20), 0.01f * float(k / 20), 1}, {0.02f, 0.02f, 0.02f}, 0.5f,
            {0.2f, 0.4f, 0.6f});
    const SplatFrame frame = seen_from({plain_eye(100, 100)});
    const std::vector<Picture> sound = cpu_raster(cloud, frame);
    for (const float bad : {nan, inf, -inf}) {
        put(cloud, {bad, 0, 1}, {0.1f, 0.1f, 0.1f}, 0.9f, {1, 1, 1});
        put(cloud, {0, 0, bad}, {0.1f, 0.1f, 0.1f}, 0.9f, {1, 1, 1});
        put(cloud, {0, 0, 1}, {0.1f, bad, 0.1f}, 0.9f, {1, 1, 1});
        put(cloud, {0, 0, 1}, {0.1f, 0.1f, 0.1f}, bad == inf ? nan : bad, {1, 1, 1});
    }
    expect_same(GpuRaster(cloud).pictures(frame), sound);
    const Picture nothing = GpuRaster(SplatCloud{}).pictures(frame).at(0);
    EXPECT_TRUE(finite(nothing));
    EXPECT_EQ(nothing.depth.at(5), no_depth);
    EXPECT_NE(reason<std::invalid_argument>(
                  [&] { GpuRaster(cloud).pictures(seen_from({plain_eye(16000, 16000)})); }),
              "");
}

}  // namespace
}  // namespace knead
