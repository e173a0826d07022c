// Scenes of splats that stand still and are clay where tools come near.
#include "host/paging/local_clay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "host/assets/procedural_ground.h"
#include "host/base/errors.h"
#include "host/paging/local_surface.h"
#include "host/paging/scene_splats.h"
#include "host/splats/cells.h"
#include "host/splats/deformed.h"
#include "tests/paging/local_scene.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Place = Vec3<double>;

TEST_P(LocalScene, ABallLeavesADentAndFarSplatsKeepTheirBits)
{
    const SplatCloud before = local->slots_cloud();
    const Place at{0.4, 0.2, 0.5};
    press(at);
    EXPECT_GT(solver->particles().size(), 500u);
    leave();
    EXPECT_EQ(report.cubes, 0u);
    EXPECT_TRUE(solver->particles().empty());
    EXPECT_TRUE(solver->gaussians().empty());
    EXPECT_EQ(repaired, 0);
    EXPECT_GT(dent(at), 0.015);
    EXPECT_LT(dent(at), 0.05);
    EXPECT_LT(dent(at + Place{0.13, 0, 0}, 0.02), 0.004) << "beside it the floor holds";
    const SplatCloud& now = local->slots_cloud();
    std::size_t same = 0;
    for (std::size_t i = 0; i < before.count(); ++i) {
        const Place d = cast<double>(before.centre[i]) - at;
        if (std::hypot(d.x, d.z) < 0.25) continue;
        ++same;
        ASSERT_EQ(std::memcmp(&now.centre[i], &before.centre[i], sizeof now.centre[i]), 0) << i;
        ASSERT_EQ(std::memcmp(&now.rotation[i], &before.rotation[i], sizeof now.rotation[i]), 0);
        ASSERT_EQ(std::memcmp(&now.scale[i], &before.scale[i], sizeof now.scale[i]), 0);
    }
    EXPECT_GT(same, 15000u);
}

TEST_P(LocalScene, AHandThatOnlyComesNearChangesNothing)
{
    const SplatCloud before = local->slots_cloud();
    move({0.5, 0.23, 0.5}, {0.5, 0.23, 0.5}, away, away, 20);
    EXPECT_GT(report.splats, 100u);
    leave();
    EXPECT_EQ(report.splats, 0u);
    EXPECT_TRUE(same_bits(local->slots_cloud().centre, before.centre));
    EXPECT_TRUE(same_bits(local->slots_cloud().scale, before.scale));
}

TEST_P(LocalScene, WhatIsGivenBackLooksAsItDid)
{
    const Picture before = seen();
    press({0.5, 0.2, 0.5});
    const Picture as_clay = seen();
    EXPECT_LT(psnr(before, as_clay), 45) << "nothing happened";
    leave();
    EXPECT_GT(psnr(as_clay, seen()), 50);
}

TEST_P(LocalScene, ASecondDentLeavesTheFirst)
{
    const Place one{0.35, 0.2, 0.4}, other{0.8, 0.2, 0.8};
    press(one);
    const Place high{0, 0.1, 0};
    move(one + high, other + high, away, away, 30);
    move(other + high, other + high, away, away, 33);  // for what is given back
    const double first = dent(one);
    EXPECT_GT(first, 0.015);
    press(other);
    leave();
    EXPECT_EQ(dent(one), first) << "to the bit";
    EXPECT_GT(dent(other), 0.015);
}

// The second time, the clay is made of the dented splats.
TEST_P(LocalScene, TheSamePlaceMayBeKneadedAgain)
{
    const Place at{0.5, 0.2, 0.5};
    press(at, 0.02);
    leave();
    const double first = dent(at);
    press(at, 0.045);
    leave();
    EXPECT_GT(dent(at), first + 0.008);
    EXPECT_LT(dent(at), 0.07);
}

TEST_P(LocalScene, TwoHandsHaveTwoRegions)
{
    const Place a{0.3, 0.2, 0.3}, b{0.9, 0.2, 0.9}, high{0, 0.1, 0}, low{0, -0.03, 0};
    press(a);
    const std::size_t one = most_cubes;
    make();
    most_cubes = 0;
    move(a + high, a + low, b + high, b + low, 25);
    EXPECT_GT(double(most_cubes), 1.5 * double(one));
    EXPECT_LT(double(most_cubes), 2.5 * double(one));
    move(a + low, a + high, b + low, b + high, 15);
    leave();
    EXPECT_GT(dent(a), 0.015);
    EXPECT_GT(dent(b), 0.015);
    EXPECT_LT(dent({0.6, 0.2, 0.6}), 1e-9);
}

// No particle is there twice, and none is missing between.
TEST_P(LocalScene, OverlappingRegionsHaveNoSeam)
{
    const Place a{0.5, 0.26, 0.5}, b{0.8, 0.26, 0.5};
    move(a, a, away, away, 2);
    const std::size_t one = solver->particles().size();
    move(a, a, b, b, 2);
    EXPECT_GT(solver->particles().size(), one);
    const std::vector<Particle<double>> q = solver->particles();
    std::vector<Place> x;
    for (const Particle<double>& p : q) x.push_back(p.x);
    const double spacing = std::cbrt(scene.setup.materials[0].volume);
    const Cells cells(x, spacing);
    std::size_t lonely = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        double nearest = 1e30;
        cells.each_near(x[i], {spacing, spacing, spacing}, [&](std::uint32_t j) {
            if (j != i) nearest = std::fmin(nearest, length(x[j] - x[i]));
        });
        ASSERT_GT(nearest, 0.6 * spacing) << i;
        lonely += nearest > 1.2 * spacing;
    }
    EXPECT_EQ(lonely, 0u);
    EXPECT_EQ(repaired, 0);
}

// Work goes with what is near the hands, not with the scene.
TEST_P(LocalScene, AScenesSizeCostsNothing)
{
    const SplatCloud alone = placed(tiled_ground(20000), {1, 0, 0, 0}, 1, {0.6, 0.2, 0.6});
    local = std::make_unique<LocalClay>(scene, 0, alone, *moving);
    press({0.5, 0.2, 0.5});
    const std::size_t splats = moving->cloud().count(), particles = solver->particles().size();
    const long blocks = last.active_blocks;
    // The same floor four times: three more above it.
    const SplatCloud floor = tiled_ground(20000);
    SplatCloud four = floor;
    for (const float up : {0.65f, 0.75f, 0.85f}) {
        for (std::size_t i = 0; i < floor.count(); ++i)
            four.centre.push_back(floor.centre[i] + Vec3<float>{0, up, 0});
        const auto more = [](auto& to, const auto& from) {
            to.insert(to.end(), from.begin(), from.end());
        };
        more(four.rotation, floor.rotation), more(four.scale, floor.scale);
        more(four.opacity, floor.opacity), more(four.sh, floor.sh);
    }
    make();
    local = std::make_unique<LocalClay>(scene, 0, placed(four, {1, 0, 0, 0}, 1, {0.6, 0.2, 0.6}),
                                        *moving);
    press({0.5, 0.2, 0.5});
    EXPECT_EQ(moving->cloud().count(), splats);
    EXPECT_EQ(solver->particles().size(), particles);
    EXPECT_EQ(last.active_blocks, blocks);
    EXPECT_EQ(local->slots_cloud().count(), 80000u);
}

TEST_P(LocalScene, TheBitsAreTheSameForAnyNumberOfThreads)
{
    if (GetParam()) GTEST_SKIP() << "threads are the CPU's";
    std::vector<Gaussian<double>> wanted;
    for (const int threads : {1, 3}) {
        make();
        scene.setup.threads = threads, solver = made();
        move({0.5, 0.3, 0.5}, {0.55, 0.18, 0.5}, away, away, 12);
        if (threads == 1) wanted = solver->gaussians();
        EXPECT_TRUE(same_bits(solver->gaussians(), wanted)) << threads;
    }
    EXPECT_GT(wanted.size(), 100u);
}

// As a checkpoint does.
TEST_P(LocalScene, ItsStateGoesOnInTheSameBits)
{
    const Place a{0.5, 0.3, 0.5}, b{0.55, 0.18, 0.5}, c{0.8, 0.26, 0.7};
    make({"deterministic=true"});
    press({0.3, 0.2, 0.3}), leave();
    move(a, b, away, away, 12);
    const LocalState state = local->state();
    const CarriedSplats carried = moving->state();
    SavedState saved = solver->save();
    const int then = number;
    move(b, c, away, away, 20), leave();
    const SplatCloud wanted = local->slots_cloud();
    make({"deterministic=true"});
    number = then;
    moving->set_state(carried), local->set_state(state), solver->load(saved);
    move(b, c, away, away, 20), leave();
    EXPECT_TRUE(same_bits(local->slots_cloud().centre, wanted.centre));
    EXPECT_TRUE(same_bits(local->slots_cloud().scale, wanted.scale));
    EXPECT_TRUE(same_bits(local->slots_cloud().rotation, wanted.rotation));
    LocalState bad = state;
    bad.slot_of[0] = int(bad.cloud.count());
    EXPECT_THROW(local->set_state(bad), std::invalid_argument);
    bad = state, bad.active.pop_back();
    EXPECT_THROW(local->set_state(bad), std::invalid_argument);
    bad = state, bad.clay.begin()->second = bad.objects;
    EXPECT_THROW(local->set_state(bad), std::invalid_argument);
}

TEST_P(LocalScene, NeedsTheLocalizedModeAndIsOneAtMost)
{
    EXPECT_THROW(make({"rest.mode=sleep"}), InputError);
    EXPECT_THROW(make({"objects.0.depth=-1"}), InputError);
    EXPECT_NO_THROW(make({"objects.0.depth=0.05"}));
}

// Hills of splats: between corners deep places are told to a tenth of a step, others exactly.
TEST(LocalSurfaceOfSplats, IsKnownInACubeByItsCorners)
{
    std::vector<Place> x, n;
    const double gap = 0.01, dx = 1.0 / 48, depth = 0.17;
    for (int i = 0; i < 100; ++i)
        for (int j = 0; j < 100; ++j) {
            const double a = gap * i, c = gap * j;
            x.push_back({a, 0.4 + 0.03 * std::sin(6 * a) * std::cos(5 * c), c});
            const Place along{-0.18 * std::cos(6 * a) * std::cos(5 * c), 1,
                              0.15 * std::sin(6 * a) * std::sin(5 * c)};
            n.push_back((1 / length(along)) * along);
        }
    const LocalSurface surface(surface_patches(x, n, dx), depth, 2 * dx);
    const double edge = 8 * dx;
    int inside = 0, deep = 0;
    for (int y = 1; y < 4; ++y) {
        const Place low{3 * edge, y * edge, 2 * edge};
        const CubeHeights cube = CubeHeights::of(surface, {Cubes::key({3, y, 2})}, edge).at(0);
        for (int k = 0; k < 4000; ++k) {
            const Place at =
                low + edge / 20 * Place{k % 20 + 0.5, k / 20 % 10 * 2 + 0.5, k / 200 + 0.5};
            const auto wanted = surface.height(at), found = cube.height(at);
            if (wanted && std::abs(*wanted) < 0.5 * dx) {
                ASSERT_EQ(found, wanted) << k;
            } else if (found && *found > 2 * edge / CubeHeights::parts) {
                ASSERT_TRUE(!wanted || *wanted > edge / CubeHeights::parts) << k;
            } else if (wanted && found) {
                ASSERT_NEAR(*found, *wanted, 0.2 * dx) << k;
            }
            if (wanted && *wanted < 0 && *wanted > -depth) {
                ASSERT_TRUE(found) << k;
            }
            inside += wanted && *wanted < 0, deep += wanted && *wanted < -4 * dx;
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(deep, 500);
}

INSTANTIATE_TEST_SUITE_P(Devices, LocalScene, ::testing::Bool(),
                         [](const auto& device) { return device.param ? "cuda" : "cpu"; });

}  // namespace
}  // namespace knead
