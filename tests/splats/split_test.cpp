// Splats that are split, and that are added: what is kept, in which order, and how many.
#include "host/splats/split.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/base/parallel.h"
#include "host/splats/generate.h"
#include "host/splats/raster.h"
#include "host/splats/refill.h"

namespace knead {
namespace {

using Gaussians = std::vector<Gaussian<double>>;
constexpr WallOptions far_walls{{-10, -10, -10}, {10, 10, 10}, ContactMode::sticky, 0};

CarriedSplats one_splat(float opacity = 0.9f)
{
    SplatCloud c;
    c.centre = {{0, 0, 0}}, c.opacity = {opacity}, c.sh = {{0.5f, -0.3f, 1}};
    c.rotation = {cast<float>(unit(Quat<double>{0.8, 0.3, -0.4, 0.2}))};
    c.scale = {{0.02f, 0.03f, 0.01f}};
    return carried(c);
}
Gaussian<double> sheared()
{
    Gaussian<double> g = gaussian_at(Vec3<double>{0.1, 0.2, 0.3}, 0);
    g.F = Mat3<double>{{3.2, 0.1, 0}, {0.9, 2.8, -0.2}, {0, 0.3, 0.7}};
    g.sides = below;
    return g;
}

Sym3<double> covariance_of(const CarriedSplats& s, const Gaussian<double>& g, std::size_t i)
{
    const Ellipsoid<double> e{cast<double>(s.cloud.rotation[i]), cast<double>(s.cloud.scale[i])};
    return symmetric(g.F * full(covariance(e)) * transpose(g.F));
}
double longest(const Sym3<double>& sigma)
{
    const Eigen<double> e = eigen(sigma);
    return std::sqrt(max(e.value.x, max(e.value.y, e.value.z)));
}

// Mass one half each: mean and covariance of the pair are those of the one that it was.
TEST(SplitSplat, KeepsMeanAndCovariance)
{
    CarriedSplats s = one_splat();
    Gaussians g{sheared()};
    const Vec3<double> x = g[0].x;
    const Sym3<double> before = covariance_of(s, g[0], 0);
    const SplitReport done = split(s, g, {}, far_walls);
    EXPECT_EQ(done.splits.size(), 1u);
    ASSERT_EQ(g.size(), 2u);
    ASSERT_EQ(s.count(), 2u);
    EXPECT_LT(length(0.5 * (g[0].x + g[1].x) - x), 1e-12);
    const Vec3<double> d = 0.5 * (g[1].x - g[0].x);
    const Sym3<double> one = covariance_of(s, g[0], 0), other = covariance_of(s, g[1], 1);
    const auto near = [&](double a, double b, double between, double wanted) {
        EXPECT_NEAR((a + b) / 2 + between, wanted, 2e-7 * longest(before) * longest(before) * 10);
    };
    near(one.xx, other.xx, d.x * d.x, before.xx), near(one.yy, other.yy, d.y * d.y, before.yy);
    near(one.zz, other.zz, d.z * d.z, before.zz), near(one.xy, other.xy, d.x * d.y, before.xy);
    near(one.xz, other.xz, d.x * d.z, before.xz), near(one.yz, other.yz, d.y * d.z, before.yz);
    EXPECT_LT(longest(one), 0.95 * longest(before));
    EXPECT_NEAR(dot(d, d), 0.5 * longest(before) * longest(before), 1e-8);
}

TEST(SplitSplat, HandsOnAllElse)
{
    CarriedSplats s = one_splat();
    Gaussians g{sheared()};
    split(s, g, {}, far_walls);
    for (const std::size_t i : {0u, 1u}) {
        EXPECT_EQ(g[i].label(), below);
        EXPECT_EQ(g[i].object, 0);
        EXPECT_EQ(g[i].F.b.x, sheared().F.b.x);
        EXPECT_EQ(s.extent[i], 0.03f);
        EXPECT_EQ(s.cloud.sh[i].z, 1.0f);
        EXPECT_EQ(s.cloud.opacity[i], float(pair_opacity(double(0.9f))));
    }
}

// Against the sum over the profile itself.
TEST(SplitSplat, KeepsTheOpticalDepth)
{
    for (const double opacity : {0.05, 0.3, 0.6, 0.9, 0.98, 0.999}) {
        double sum = 0;
        const double h = 1e-3;
        for (double r = h / 2; r < 9; r += h)
            sum += -std::log1p(-opacity * std::exp(-r * r / 2)) * r * h;
        EXPECT_NEAR(summed_depth(opacity), sum, 1e-5) << opacity;
        const double each = pair_opacity(opacity);
        EXPECT_NEAR(2 * std::sqrt(pair_variance) * summed_depth(each), sum, 1e-5) << opacity;
        EXPECT_LT(each, opacity);
    }
    EXPECT_EQ(summed_depth(0), 0);
    EXPECT_NEAR(summed_depth(1), 1.6449340668, 1e-9);
}

// Of one alone the picture changes: its middle is flatter. The bound is what is stated.
TEST(SplitSplat, ThePairComposesToNearlyTheSamePicture)
{
    for (const float opacity : {0.3f, 0.98f}) {
        CarriedSplats s = one_splat(opacity);
        s.cloud.scale = {{0.04f, 0.04f, 0.04f}}, s = carried(s.cloud);
        SplatFrame f;
        f.eyes = {eye_looking({0, 0, -1}, {0, 0, 0}, 0.3, 200, 200)};
        f.moved_centre = {{0, 0, 0}}, f.moved_F = {{{2, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        const Picture before = cpu_raster(s.cloud, f).front();
        Gaussians g{gaussian_at(Vec3<double>{0, 0, 0}, 0)};
        g[0].F.a.x = 2;
        ASSERT_EQ(split(s, g, {}, far_walls).splits.size(), 1u);
        SplatFrame two = f;
        two.moved_centre.clear(), two.moved_F.clear();
        for (const Gaussian<double>& one : g) {
            two.moved_centre.push_back(cast<float>(one.x));
            two.moved_F.push_back(f.moved_F[0]);
        }
        const Picture after = cpu_raster(s.cloud, two).front();
        double square = 0, all = 0, sum = 0, sum_after = 0;
        for (std::size_t i = 0; i < before.pixels(); ++i) {
            const auto a = double(before.alpha[i]), b = double(after.alpha[i]);
            square += (a - b) * (a - b), all += a * a, sum += a, sum_after += b;
        }
        EXPECT_LT(std::sqrt(square / all), 0.2) << opacity;
        EXPECT_NEAR(sum_after / sum, 1, 0.12) << opacity;
    }
}

// --- which, and how many -------------------------------------------------------------------------

struct Many {
    CarriedSplats splats;
    Gaussians gaussians;
};
Many many(int count = 3000)
{
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    SplatLoad load{"small", count, 0};
    Many m{carried(generated(load)), {}};
    for (const Vec3<float>& x : m.splats.cloud.centre) {
        m.gaussians.push_back(gaussian_at(cast<double>(x), 0));
        for (Vec3<double>* column :
             {&m.gaussians.back().F.a, &m.gaussians.back().F.b, &m.gaussians.back().F.c})
            *column = *column + 0.5 * Vec3<double>{normal(random), normal(random), normal(random)};
    }
    return m;
}
double worst(const Many& m)
{
    double most = 0;
    for (std::size_t i = 0; i < m.gaussians.size(); ++i)
        most = max(
            most, longest(covariance_of(m.splats, m.gaussians[i], i)) / double(m.splats.extent[i]));
    return most;
}

TEST(Split, GoesOnUntilNoneIsTooLong)
{
    Many m = many();
    ASSERT_GT(worst(m), 2.5);
    int calls = 0;
    for (; calls < 20 && split(m.splats, m.gaussians, {}, far_walls).splits.size() > 0; ++calls) {
    }
    EXPECT_LT(worst(m), SplitOptions{}.limit * 1.0001);
    EXPECT_GT(calls, 2);
    EXPECT_LT(calls, 20);
    EXPECT_EQ(m.splats.cloud.sh.size(), m.splats.count() * std::size_t(harmonics(3)));
}

TEST(Split, TakesTheWorstFirstWithinBudgetAndCapacity)
{
    Many m = many();
    const double before = worst(m);
    SplitOptions options;
    options.budget = 10;
    SplitReport done = split(m.splats, m.gaussians, options, far_walls);
    EXPECT_EQ(done.splits.size(), 10u);
    EXPECT_GT(done.waiting, 100u);
    EXPECT_LT(worst(m), before);
    options.budget = 1000, options.capacity = m.gaussians.size() + 7;
    done = split(m.splats, m.gaussians, options, far_walls);
    EXPECT_EQ(done.splits.size(), 7u);
    EXPECT_EQ(m.gaussians.size(), options.capacity);
    options.capacity = 5;
    EXPECT_EQ(split(m.splats, m.gaussians, options, far_walls).splits.size(), 0u);
    options = {}, options.smallest = 1;
    EXPECT_EQ(split(m.splats, m.gaussians, options, far_walls).waiting, 0u);
}

TEST(Split, StaysBetweenTheWallsAndRefusesWhatDoesNotBelongTogether)
{
    CarriedSplats s = one_splat();
    Gaussians g{sheared()};
    const WallOptions near{{0, 0, 0}, {0.105, 1, 1}, ContactMode::sticky, 0};
    split(s, g, {}, near);
    EXPECT_LE(max(g[0].x.x, g[1].x.x), 0.105);
    g.pop_back();
    EXPECT_THROW(split(s, g, {}, far_walls), std::invalid_argument);
}

TEST(Split, HasTheSameBitsForAnyNumberOfThreads)
{
    const int threads = loop_threads();
    Many wanted;
    for (const int n : {1, 2, 5}) {
        set_loop_threads(n);
        Many m = many();
        split(m.splats, m.gaussians, {}, far_walls);
        if (n == 1) wanted = m;
        ASSERT_EQ(m.gaussians.size(), wanted.gaussians.size());
        for (std::size_t i = 0; i < m.gaussians.size(); ++i)
            ASSERT_EQ(m.gaussians[i].x.x, wanted.gaussians[i].x.x) << n;
    }
    set_loop_threads(threads);
}

// --- new ones ------------------------------------------------------------------------------------

// A block of particles 1 cm apart; its lower half's faces, and the inside, have splats.
struct Block {
    static constexpr double h = 0.01;
    std::vector<Particle<double>> particles;
    CarriedSplats splats;
    Gaussians gaussians;
};
Block block(double covered_below)
{
    Block b;
    SplatCloud c;
    for (int k = 0; k < 12 * 12 * 12; ++k) {
        const Int3 n{k % 12, k / 12 % 12, k / 144};
        Particle<double> p{};
        p.x = Block::h * Vec3<double>{n.x + 0.5, n.y + 0.5, n.z + 0.5};
        b.particles.push_back(p);
        if (p.x.y > covered_below) continue;
        c.centre.push_back(cast<float>(p.x)), c.opacity.push_back(0.98f);
        c.rotation.push_back({1, 0, 0, 0}), c.scale.push_back({0.007f, 0.007f, 0.007f});
        c.sh.push_back(p.x.x < 0.06 ? Vec3<float>{1, 0, 0} : Vec3<float>{0, 0, 1});
        b.gaussians.push_back(gaussian_at(p.x, 0));
    }
    b.splats = carried(c);
    return b;
}

TEST(Refill, AddsNothingWhereSplatsCoverTheSurface)
{
    Block b = block(1);
    const RefillReport done = refill(b.splats, b.gaussians, b.particles, {Block::h}, {}, far_walls);
    EXPECT_EQ(done.added.size(), 0u);
    EXPECT_EQ(done.bare, 0u);
}

TEST(Refill, CoversWhatIsBareWithDiscsAlongTheSurface)
{
    Block b = block(0.06);
    const std::size_t before = b.gaussians.size();
    const RefillReport done = refill(b.splats, b.gaussians, b.particles, {Block::h}, {}, far_walls);
    EXPECT_GT(done.added.size(), 100u);
    EXPECT_EQ(done.waiting, 0u);
    EXPECT_EQ(b.gaussians.size(), before + done.added.size());
    EXPECT_EQ(b.splats.count(), b.gaussians.size());
    std::size_t on_top = 0;
    for (std::size_t i = before; i < b.gaussians.size(); ++i) {
        const Vec3<double> x = b.gaussians[i].x;
        EXPECT_GT(x.y, 0.05);
        const double off = min(min(x.x, 0.12 - x.x), min(min(x.z, 0.12 - x.z), 0.12 - x.y));
        EXPECT_LT(off, Block::h) << "at the surface";
        const Vec3<double> inner{0.02, 0.02, 0.02};
        if (x.y < 0.11 || x.x < inner.x || x.z < inner.z || x.x > 0.1 || x.z > 0.1) continue;
        ++on_top;
        const Ellipsoid<float> e{b.splats.cloud.rotation[i], b.splats.cloud.scale[i]};
        EXPECT_GT(std::fabs(rotation(e.q).c.y), 0.95f) << "its short axis is the normal";
        EXPECT_LT(e.scale.z, 0.6f * e.scale.x);
    }
    EXPECT_GT(on_top, 15u);
    EXPECT_EQ(refill(b.splats, b.gaussians, b.particles, {Block::h}, {}, far_walls).bare, 0u)
        << "all is covered now";
}

TEST(Refill, TakesColourObjectAndLabelFromAround)
{
    Block b = block(0.06);
    for (Particle<double>& p : b.particles) p.sides = above;
    const std::size_t before = b.gaussians.size();
    refill(b.splats, b.gaussians, b.particles, {Block::h}, {}, far_walls);
    for (std::size_t i = before; i < b.gaussians.size(); ++i) {
        EXPECT_EQ(b.gaussians[i].label(), above);
        const Vec3<float> c = b.splats.cloud.sh[i];
        EXPECT_NEAR(c.x + c.z, 1, 1e-5);
        if (b.gaussians[i].x.y > 0.08) continue;  // far from all: the mean
        const double x = b.gaussians[i].x.x;
        if (x > 0.02 && x < 0.1) continue;
        EXPECT_GT(x < 0.06 ? c.x : c.z, 0.95f);
    }
}

TEST(Refill, KeepsToItsBudgetAndCapacityTheBarestFirst)
{
    Block b = block(0.06);
    RefillOptions options;
    options.budget = 20;
    const RefillReport done =
        refill(b.splats, b.gaussians, b.particles, {Block::h}, options, far_walls);
    EXPECT_EQ(done.added.size(), 20u);
    EXPECT_GT(done.waiting, 50u);
    options.budget = 1000, options.capacity = b.gaussians.size() + 3;
    EXPECT_EQ(
        refill(b.splats, b.gaussians, b.particles, {Block::h}, options, far_walls).added.size(),
        3u);
    EXPECT_EQ(refill(b.splats, b.gaussians, b.particles, {0}, {}, far_walls).bare, 0u)
        << "an object without splats";
}

TEST(Refill, HasTheSameBitsForAnyNumberOfThreads)
{
    const int threads = loop_threads();
    Block wanted;
    for (const int n : {1, 2, 5}) {
        set_loop_threads(n);
        Block b = block(0.06);
        refill(b.splats, b.gaussians, b.particles, {Block::h}, {}, far_walls);
        if (n == 1) wanted = b;
        ASSERT_EQ(b.gaussians.size(), wanted.gaussians.size());
        for (std::size_t i = 0; i < b.gaussians.size(); ++i)
            ASSERT_EQ(b.splats.cloud.sh[i].x, wanted.splats.cloud.sh[i].x) << n;
    }
    set_loop_threads(threads);
}

}  // namespace
}  // namespace knead
