// The projection of one splat: against the mapping of points that it is the first order of, tile
// tests against every pixel, polar rotations, depth keys.
#include "cuda/splats/footprint.h"

#include <gtest/gtest.h>

#include <vector>

#include "cuda/splats/blend.h"
#include "cuda/splats/eye.h"
#include "tests/splats/raster_cases.h"

namespace knead {
namespace {

Pinhole<double> some_pinhole()
{
    Eye<double> eye{{0.1, -0.2, 0.3},
                    unit(Quat<double>{0.9, 0.1, -0.2, 0.05}),
                    -1.1,
                    0.8,
                    -0.9,
                    1.2,
                    1000,
                    1100};
    EXPECT_TRUE(valid(eye));
    return pinhole(eye);
}

Vec3<double> pixel_of(const Pinhole<double>& c, Vec3<double> x)  // u, v, depth
{
    const Vec3<double> t = c.to_eye * (x - c.position);
    return {c.fx * t.x / t.z + c.cx, c.fy * t.y / t.z + c.cy, t.z};
}

// The point of the world at (x, y, z) of the eye's axes.
Vec3<double> at(const Pinhole<double>& c, Vec3<double> t)
{
    return c.position + transpose(c.to_eye) * t;
}

TEST(Footprints, TheSidesOfTheFrustumAreTheSidesOfThePicture)
{
    const Pinhole<double> c = some_pinhole();
    const Vec3<double> low = pixel_of(c, at(c, {-1.1 * 2, -0.9 * 2, 2}));
    const Vec3<double> high = pixel_of(c, at(c, {0.8 * 2, 1.2 * 2, 2}));
    EXPECT_NEAR(low.x, -0.5, 1e-9);
    EXPECT_NEAR(low.y, -0.5, 1e-9);
    EXPECT_NEAR(high.x, 999.5, 1e-9);
    EXPECT_NEAR(high.y, 1099.5, 1e-9);
}

// Sigma on the screen and the covariance with depth, by differences of where points go.
TEST(Footprints, TheCovarianceIsThatOfTheProjectionToFirstOrder)
{
    const Pinhole<double> c = some_pinhole();
    Draw draw(2);
    for (int k = 0; k < 200; ++k) {
        const Vec3<double> x = at(c, {draw.in(-1, 0.7), draw.in(-0.8, 1.1), 1.0});
        const Ellipsoid<double> e{quaternion(draw.rotation()),
                                  {draw.in(0.01, 0.03), draw.in(0.01, 0.03), draw.in(0.01, 0.03)}};
        const Mat3<double> L = half_axes(e);
        Footprint<double> f;
        ASSERT_TRUE(project(c, SplatOptions<double>{}, x, L, 0.8, f));
        double uu = 0.3, vv = 0.3, uv = 0, uz = 0, vz = 0;
        for (const Vec3<double> axis : {L.a, L.b, L.c}) {
            const double h = 1e-4;
            const Vec3<double> d =
                (1 / (2 * h)) * (pixel_of(c, x + h * axis) - pixel_of(c, x - h * axis));
            uu += d.x * d.x, vv += d.y * d.y, uv += d.x * d.y, uz += d.x * d.z, vz += d.y * d.z;
        }
        const double det = uu * vv - uv * uv, half_log2_e = 0.5 / std::log(2.0);
        EXPECT_NEAR(f.a, half_log2_e * vv / det, 1e-7 * f.a);
        EXPECT_NEAR(f.c, half_log2_e * uu / det, 1e-7 * f.c);
        EXPECT_NEAR(f.b, -2 * half_log2_e * uv / det, 1e-7 * (f.a + f.c));
        EXPECT_NEAR(f.gx, (uz * vv - vz * uv) / det, 1e-9);
        EXPECT_NEAR(f.gy, (vz * uu - uz * uv) / det, 1e-9);
        const Vec3<double> p = pixel_of(c, x);
        EXPECT_NEAR(f.u, p.x, 1e-9);
        EXPECT_NEAR(f.v, p.y, 1e-9);
        EXPECT_NEAR(f.depth, p.z, 1e-12);
    }
}

// A thin disc that is large on the screen: its depth is that of its plane.
TEST(Footprints, TheDepthOfADiscIsThatOfItsPlane)
{
    const Pinhole<double> c = some_pinhole();
    Draw draw(8);
    for (int k = 0; k < 50; ++k) {
        const Vec3<double> t{draw.in(-0.5, 0.5), draw.in(-0.5, 0.5), 1};
        Mat3<double> Q = draw.rotation();
        Vec3<double> n = c.to_eye * Q.c;
        if (std::fabs(dot(n, t)) < 0.3) continue;  // seen from the side
        Footprint<double> f;
        ASSERT_TRUE(project(c, SplatOptions<double>{}, at(c, t),
                            half_axes(Ellipsoid<double>{quaternion(Q), {0.1, 0.1, 0}}), 0.8, f));
        // The ray through a pixel close by meets the plane at depth n.t / n.d.
        const Vec3<double> d{(f.u + 0.01 - c.cx) / c.fx, (f.v - c.cy) / c.fy, 1};
        const Vec3<double> e{(f.u - c.cx) / c.fx, (f.v + 0.01 - c.cy) / c.fy, 1};
        EXPECT_NEAR(f.gx, (dot(n, t) / dot(n, d) - 1) / 0.01, 0.01 * std::fabs(f.gx) + 1e-5);
        EXPECT_NEAR(f.gy, (dot(n, t) / dot(n, e) - 1) / 0.01, 0.01 * std::fabs(f.gy) + 1e-5);
    }
}

TEST(Footprints, TheBoxIsAsTightAsWhatIsDrawnAndATileIsReachedWhereAPixelOfItIs)
{
    const Eye<float> eye = plain_eye(400, 400);
    const Pinhole<float> c = pinhole(eye);
    Draw draw(4);
    long reached = 0, hit = 0;
    for (int k = 0; k < 600; ++k) {
        Footprint<float> f;
        const Ellipsoid<double> e{quaternion(draw.rotation()),
                                  {draw.power(-4, -1), draw.power(-4, -1), draw.power(-4, -1)}};
        const Ellipsoid<float> g{cast<float>(e.q), cast<float>(e.scale)};
        const Vec3<float> x = cast<float>(Vec3<double>{draw.in(-0.9, 0.9), draw.in(-0.9, 0.9), 1});
        if (!project(c, SplatOptions<float>{}, x, half_axes(g), float(draw.in(0.01, 1)), f))
            continue;
        for (int ty = 0; ty < 25; ++ty)
            for (int tx = 0; tx < 25; ++tx) {
                const float x0 = 16 * float(tx), y0 = 16 * float(ty);
                bool any = false;
                for (int n = 0; n < 256 && !any; ++n)
                    any = alpha_at(f, x0 + float(n % 16), y0 + float(n / 16)) > 0;
                const bool test = reaches(f, x0, y0, x0 + 15, y0 + 15);
                const bool box = f.u + f.half_width >= x0 && f.u - f.half_width <= x0 + 15 &&
                                 f.v + f.half_height >= y0 && f.v - f.half_height <= y0 + 15;
                reached += test, hit += any;
                EXPECT_TRUE(test || !any);
                EXPECT_TRUE(box || !any);
            }
    }
    EXPECT_GT(hit, 2000);
    EXPECT_LT(double(reached), 1.15 * double(hit));  // what lies between pixels
}

TEST(Footprints, WhatCoversAPatchIsBlendedToTheSameBitsWithoutASecondLook)
{
    const Pinhole<float> c = pinhole(plain_eye(400, 400));
    Draw draw(8);
    const auto start = [](float left) {
        Pixel<float> p;
        p.transmittance = left, p.colour = {0.1f, 0.2f, 0.3f}, p.depth = 0.7f;
        return p;
    };
    const auto same = [](const Pixel<float>& a, const Pixel<float>& b) {
        return a.transmittance == b.transmittance && a.depth == b.depth &&
               length(a.colour - b.colour) == 0;
    };
    int covered = 0, full = 0;
    for (int k = 0; k < 20000; ++k) {
        Footprint<float> f;
        const Ellipsoid<double> e{quaternion(draw.rotation()),
                                  {draw.power(-3, 0), draw.power(-3, 0), draw.power(-3, 0)}};
        const Vec3<double> x{draw.in(-0.9, 0.9), draw.in(-0.9, 0.9), 1};
        const float opacity = k % 50 == 0 ? 1.0f : float(draw.in(0.01, 0.99));
        if (!project(c, SplatOptions<float>{}, cast<float>(x),
                     half_axes(Ellipsoid<float>{cast<float>(e.q), cast<float>(e.scale)}), opacity,
                     f))
            continue;
        const float x0 = 16 * float(k % 25), y0 = 8 * float(k % 49);
        const bool covers_it = covers(f, x0, y0, x0 + 15, y0 + 7);
        bool everywhere = true;
        for (int n = 0; n < 128; ++n) {
            const float px = x0 + float(n % 16), py = y0 + float(n / 16), left = 0.49f;
            const float alpha = alpha_at(f, px, py);
            everywhere = everywhere && alpha > 0 && opacity <= float(max_alpha);
            Pixel<float> deep = start(left), whole = deep, plain = deep, by_hand = deep;
            const Vec3<float> colour{0.5f, 0.6f, 0.7f};
            blend_deep(deep, f, colour, px, py);
            blend(plain, f, colour, px, py);
            if (alpha > 0) add(by_hand, alpha, colour);
            EXPECT_TRUE(same(deep, by_hand) && same(plain, by_hand));
            if (!covers_it) continue;
            blend_covered(whole, f, colour, px, py);
            EXPECT_TRUE(same(whole, by_hand)) << k;
        }
        covered += covers_it, full += everywhere;
        EXPECT_TRUE(everywhere || !covers_it);
    }
    EXPECT_GT(covered, 1000);
    EXPECT_GT(covered, 0.98 * full);
}

template <class R>
class PolarRotation : public ::testing::Test {
};
TYPED_TEST_SUITE(PolarRotation, Scalars);

TYPED_TEST(PolarRotation, IsTheRotationOfAStretchThatIsTurned)
{
    using R = TypeParam;
    Draw draw(5);
    const double tolerance = either<R>(2e-5, 1e-12);
    for (int k = 0; k < 300; ++k) {
        const Mat3<double> Q = draw.rotation(), P = draw.rotation();
        const Vec3<double> s{draw.in(0.3, 3), draw.in(0.3, 3), draw.in(0.3, 3)};
        const Mat3<double> F = Q * full(composed(P, s));
        EXPECT_LT(size(cast<double>(polar_rotation(cast<R>(F))) - Q), tolerance);
    }
    const Mat3<R> none{};
    for (const Mat3<R>& F :
         {none, Mat3<R>{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}, Mat3<R>{{0, 2, 0}, {0, 0, 0}, {0, 0, 1}},
          Mat3<R>{{-1, 0, 0}, {0, -1, 0}, {0, 0, -2}}}) {
        const Mat3<R> Q = polar_rotation(F);
        EXPECT_NEAR(double(determinant(Q)), 1, 1e-5);
        EXPECT_LT(double(size(transpose(Q) * Q - diagonal(R(1)))), 1e-5);
    }
}

TEST(DepthKeys, RiseWithDistanceToOnePartInAMillion)
{
    const float near = 0.03f;
    Draw draw(6);
    const auto key = [&](double distance, Vec3<double> d) {
        return depth_key(cast<float>((distance / length(d)) * d), near);
    };
    for (int k = 0; k < 20000; ++k) {
        const double d = draw.power(-3, 4), beyond = d * 1.000003;
        const Vec3<double> p = draw.vector(1), q = draw.vector(1);
        EXPECT_GE(key(beyond, q), key(d, p));
        EXPECT_LT(key(beyond, q), no_depth_key);
        if (d > near && beyond < 65536 * near) {
            EXPECT_GT(key(beyond, q), key(d, p));
        }
    }
    EXPECT_EQ(depth_key({HUGE_VALF, 0, 0}, near), no_depth_key - 1);
    EXPECT_EQ(depth_key({0, 3e38f, 3e38f}, near), no_depth_key - 1);
    EXPECT_EQ(depth_key({NAN, 0, 0}, near), 0u);
}

}  // namespace
}  // namespace knead
