// What a front counts and names; how its scenes are filled, timed, and compared.
#include "host/verify/front.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace knead {
namespace {

FrontPoint point(int cells, double per_cell, double error, double seconds)
{
    SceneOptions options = default_options(cells);
    options.per_cell = per_cell;
    return {options, error, seconds, error};
}

VerifyOptions quiet()
{
    VerifyOptions o;
    o.device = "cpu", o.quick = true, o.quiet = true, o.threads = 1;
    return o;
}

TEST(Front, WhatIsATenthBetterIsNamedAndWhatIsLessIsChance)
{
    const FrontPoint usual = point(32, 8, 1.0, 1.0);
    std::vector<FrontPoint> all{usual, point(32, 4, 1.0, 0.95), point(24, 8, 2.0, 0.5),
                                point(48, 8, 0.95, 1.0)};
    EXPECT_FALSE(beaten_by(all, usual).at_all());
    EXPECT_EQ(standing(beaten_by(all, usual), "mm"), "on the front");

    all.push_back(point(24, 16, 1.0, 0.6));
    all.push_back(point(24, 27, 0.9, 0.7));
    all.push_back(point(40, 16, 0.5, 0.99));
    const Beaten by = beaten_by(all, usual);
    ASSERT_TRUE(by.quicker && by.righter);
    EXPECT_EQ(by.quicker, &all[4]);
    EXPECT_EQ(by.righter, &all[6]);
    const std::string text = standing(by, "mm");
    EXPECT_NE(text.find("in time by 24 cells/m, 16 a cell, courant 0.97: 1 mm in 0.6 s"),
              text.npos);
    EXPECT_NE(text.find("in error by 40 cells/m, 16 a cell"), text.npos);
}

TEST(Front, AnErrorThatIsLessThanOnFinerCellsIsLuck)
{
    std::vector<FrontPoint> all{point(8, 4, 0.05, 0.1), point(16, 4, 9, 0.2), point(32, 4, 4, 0.4),
                                point(16, 8, 5, 0.2), point(8, 8, std::nan(""), 0.1)};
    count_errors(all);
    EXPECT_EQ(all[0].counted, 9);
    EXPECT_EQ(all[1].counted, 9);
    EXPECT_EQ(all[2].counted, 4);
    EXPECT_EQ(all[3].counted, 5);
    EXPECT_TRUE(std::isinf(all[4].counted));
    EXPECT_TRUE(all[3].beats(all[1]));
    EXPECT_TRUE(all[0].beats(all[4]));
    EXPECT_FALSE(all[0].beats(all[3]));
    EXPECT_EQ(all[0].summary("mm"), "0.05 mm (counts as 9) in 0.1 s");
    EXPECT_EQ(all[2].summary("mm"), "4 mm in 0.4 s");
}

// As many particles as fill a ball, whatever a cell holds, within it; the second time the same.
TEST(Front, ASceneIsFilledAsAScenesFileAsks)
{
    for (const double per_cell : {4.0, 8.0, 12.0, 27.0}) {
        SceneOptions options = default_options(16);
        options.per_cell = per_cell, options.seeds = std::make_shared<Seeds>();
        const BallOfClay first = ball_of_clay(options, 0.3), again = ball_of_clay(options, 0.3);
        const double h = 1.0 / 16 / std::cbrt(per_cell),
                     whole = 4 * std::numbers::pi / 3 * std::pow(squeeze_radius, 3);
        const auto& all = first.setup.particles;
        EXPECT_NEAR(double(all.size()) * h * h * h, whole, 0.01 * whole) << per_cell;
        EXPECT_NEAR(first.setup.materials[0].volume, h * h * h, 1e-15);
        ASSERT_EQ(again.setup.particles.size(), all.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
            EXPECT_LE(length(all[i].x - first.middle), squeeze_radius);
            EXPECT_EQ(length(all[i].x - again.setup.particles[i].x), 0);
        }
    }
}

// Packed particles lie nowhere in rows; a linear map comes back to the digits, at the surface too.
TEST(Front, PlacesAreCarriedByPackedParticlesExactlyWhereTheMapIsLinear)
{
    const auto map = [](Place p) { return Place{0.8 * p.x + 0.1 * p.y, 1.1 * p.y, 1.2 * p.z - 1}; };
    const auto result = [&](int cells, double per_cell) {
        SceneOptions options = default_options(cells);
        options.per_cell = per_cell;
        const BallOfClay ball = ball_of_clay(options, 0.3);
        Squeezed s;
        s.apart = 1.0 / cells / std::cbrt(per_cell);
        for (const Particle<double>& q : ball.setup.particles)
            s.from.push_back(q.x - ball.middle), s.to.push_back(map(s.from.back()));
        return carried(s);
    };
    const std::vector<Place> coarse = result(16, 4), fine = result(24, 27);
    EXPECT_EQ(apart(coarse, fine).matched, coarse.size());
    EXPECT_LT(apart(coarse, fine).rms, 1e-11);
    std::vector<Place> off = fine;
    for (std::size_t i = 0; i < off.size(); i += 2) off[i].x += 1e-3;
    EXPECT_GT(apart(coarse, off).rms, 4e-4);
}

// Runs after the first are as long, are not looked at, and leave its result.
TEST(Front, WhatIsTimedAgainIsLookedAtOnce)
{
    const Verification v(quiet());
    SceneOptions options = default_options(8);
    options.repeats = 3;
    const BallOfClay ball = ball_of_clay(options, 0.3);
    int looks = 0;
    const Driven d =
        timed_drive(v, options, ball.setup, 0.001, 0.01, no_tools, [&](const Simulator&, double t) {
            ++looks;
            return t < 0.0035;
        });
    EXPECT_EQ(looks, 4);
    EXPECT_GT(d.seconds, 0);
    EXPECT_EQ(d.solver->particle_count(), ball.setup.particles.size());
}

// Without projection tools go through clay: a setting that is off is off, and is seen.
TEST(Front, WhatASettingBoughtIsTold)
{
    Verification v(quiet());
    const FrontScene scene{"squeeze", "mm", "itself", {16}, [&v](const SceneOptions& options) {
                               const Squeezed s = squeezed(v, options);
                               return FrontResult{1, s.seconds, s.inside};
                           }};
    feature_rows(v, scene);
    double inside = -1, without = -1;
    for (const VerifyRow& r : v.rows) {
        EXPECT_EQ(r.table, "what a feature bought: squeeze");
        if (r.name == "defaults") inside = r.numbers[2].second;
        if (r.name == "contact.passes 0") without = r.numbers[2].second;
    }
    EXPECT_GE(inside, 0);
    EXPECT_LT(inside, 1);
    EXPECT_GT(without, 10);
}

TEST(Front, ASurfaceIsToldByItsNodes)
{
    Verification v(quiet());
    surface_front(v);
    ASSERT_EQ(v.rows.size(), 4u);
    int defaults = 0;
    std::vector<double> rough;
    for (const VerifyRow& r : v.rows) {
        defaults += r.numbers.back().second == 1;
        EXPECT_GT(r.numbers[0].second, r.numbers[1].second);
        EXPECT_NEAR(r.numbers[2].second, -7, 2);  // what softening takes off so few particles
        rough.push_back(r.numbers[1].second);
    }
    EXPECT_EQ(defaults, 1);
    EXPECT_GT(rough[0], 2 * rough[1]);
}

}  // namespace
}  // namespace knead
