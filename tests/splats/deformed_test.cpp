// Clouds of splats after a deformation, as files hold them.
#include "host/splats/deformed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/splats/generate.h"
#include "host/splats/raster.h"

namespace knead {
namespace {

SplatCloud some_cloud()
{
    SplatLoad load{"small", 3000, 0};
    return generated(load);
}

// Twisted about the vertical and drawn out, differently everywhere.
std::vector<Gaussian<double>> twisted(const SplatCloud& cloud)
{
    std::vector<Gaussian<double>> moved;
    for (const Vec3<float>& c : cloud.centre) {
        const Vec3<double> x = cast<double>(c);
        Gaussian<double> g = gaussian_at(x, 0);
        const Mat3<double> Q = rotation(turn_about(Vec3<double>{0, 1, 0}, 4 * x.y));
        const Mat3<double> stretch{{1.5, 0, 0}, {0.2, 0.8, 0}, {0, 0.1, 0.9 + x.x}};
        g.F = Q * stretch, g.x = g.F * x;
        moved.push_back(g);
    }
    return moved;
}

// What a file shows is what was shown before: covariances and colours both hold.
TEST(DeformedSplats, LookInAFileAsTheyDidWhereTheyMoved)
{
    const SplatCloud cloud = some_cloud();
    const std::vector<Gaussian<double>> moved = twisted(cloud);
    SplatFrame live;
    live.eyes = {eye_looking({0.2, -0.3, -0.7}, {0, 0, 0}, 0.6, 320, 240)};
    SplatFrame still = live;
    for (const Gaussian<double>& g : moved) {
        live.moved_centre.push_back(cast<float>(g.x));
        live.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
    }
    const Picture seen = cpu_raster(cloud, live).front();
    const Picture written = cpu_raster(deformed(cloud, moved), still).front();
    EXPECT_GT(psnr(seen, written), 60);
    EXPECT_LT(psnr(seen, cpu_raster(cloud, still).front()), 30) << "nothing was deformed";
}

TEST(DeformedSplats, APlacedCloudLooksTheSameFromAnEyeThatIsPlacedWithIt)
{
    const SplatCloud cloud = some_cloud();
    const Quat<double> q = unit(Quat<double>{0.8, 0.3, -0.4, 0.2});
    const double scale = 2.5;
    const Vec3<double> shift{1, -2, 3};
    const auto place = [&](Vec3<double> x) { return scale * rotate(q, x) + shift; };
    const Vec3<double> from{0.2, -0.3, -0.7}, up{0, -1, 0};
    SplatFrame before, after;
    before.eyes = {eye_looking(from, {0, 0, 0}, 0.6, 320, 240, up)};
    after.eyes = {eye_looking(place(from), place({0, 0, 0}), 0.6, 320, 240, rotate(q, up))};
    EXPECT_GT(psnr(cpu_raster(cloud, before).front(),
                   cpu_raster(placed(cloud, q, scale, shift), after).front()),
              60);
}

TEST(DeformedSplats, BeyondTheGaussiansTheyStayAndMoreOfTheseAreRefused)
{
    const SplatCloud cloud = some_cloud();
    std::vector<Gaussian<double>> moved = twisted(cloud);
    moved.resize(1000);
    const SplatCloud now = deformed(cloud, moved);
    EXPECT_NE(now.centre[999].x, cloud.centre[999].x);
    EXPECT_EQ(now.centre[1000].x, cloud.centre[1000].x);
    EXPECT_EQ(now.scale[1000].y, cloud.scale[1000].y);
    EXPECT_EQ(now.opacity, cloud.opacity);
    moved.resize(cloud.count() + 1);
    EXPECT_THROW(deformed(cloud, moved), std::invalid_argument);
}

// A splat that was pressed flat or turned inside out is still one that can be written.
TEST(DeformedSplats, DegenerateDeformationsGiveRotationsAndHalfAxesThatAreNumbers)
{
    SplatCloud cloud = some_cloud();
    std::vector<Gaussian<double>> moved;
    const Mat3<double> bad[] = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
                                {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}},
                                {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}},
                                {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                {{1e6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1}}};
    for (const Mat3<double>& F : bad) {
        moved.push_back(gaussian_at(Vec3<double>{0, 0, 0}, 0));
        moved.back().F = F;
    }
    const SplatCloud now = deformed(cloud, moved);
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const Quat<float> q = now.rotation[i];
        EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 1e-5) << i;
        EXPECT_TRUE(std::isfinite(dot(now.scale[i], now.scale[i]))) << i;
        for (int k = 0; k < harmonics(now.degree); ++k) {
            const Vec3<float> c = now.sh[i * std::size_t(harmonics(now.degree)) + std::size_t(k)];
            EXPECT_TRUE(std::isfinite(dot(c, c))) << i << " " << k;
        }
    }
}

}  // namespace
}  // namespace knead
