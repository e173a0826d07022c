#include "cuda/mpm/features.h"

#include <gtest/gtest.h>

#include <vector>

namespace knead {
namespace {

// Every combination of uses that a scene can have.
std::vector<Features> scenes()
{
    std::vector<Features> all;
    for (int bits = 0; bits < 64; ++bits)
        for (const PlasticityClass p :
             {PlasticityClass::elastic, PlasticityClass::plastic, PlasticityClass::any})
            all.push_back({(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0,
                           (bits & 16) != 0, p, (bits & 32) != 0});
    return all;
}

constexpr Features all_of(Features f) { return f; }
constexpr Features without_sums(Features f)
{
    f.fixed_point = false;
    return f;
}

template <auto relevant>
Features served(const Features& used)
{
    return dispatch<relevant>(used, []<class Case>(Case) { return Case::features; });
}

TEST(Features, EverySceneIsServedByKernelsThatHaveAllItUses)
{
    for (const Features& used : scenes()) EXPECT_TRUE(served<all_of>(used).include(used));
}

TEST(Features, BodiesAreServedWithBladesAndWithout)
{
    for (Features used : scenes()) {
        used.bodies = used.tools = true, used.colours = 2;
        const Features f = served<all_of>(used);
        EXPECT_TRUE(f.include(used));
        EXPECT_TRUE(f.bodies);
        EXPECT_EQ(f.blades, used.blades);
        EXPECT_EQ(f.rests, used.rests);
        EXPECT_EQ(f.mean_pressure, used.mean_pressure);
        EXPECT_EQ(field_count(used), used.blades ? 7 : 3);
        EXPECT_EQ(run_length(f), 128);
    }
}

TEST(Features, ASceneIsNotGivenWhatCostsMostUnlessItUsesIt)
{
    for (const Features& used : scenes()) {
        const Features f = served<all_of>(used);
        EXPECT_EQ(f.blades, used.blades);
        EXPECT_EQ(f.rests, used.rests);
        EXPECT_EQ(f.fixed_point, used.fixed_point);
        EXPECT_EQ(f.mean_pressure, used.mean_pressure);
        if (!used.blades && !used.rests) {
            EXPECT_EQ(f.tools, used.tools);
            if (used.mean_pressure) continue;
            EXPECT_EQ(f.plasticity, used.plasticity);
            if (used.tools && used.plasticity != PlasticityClass::any) {
                EXPECT_EQ(f.mixed, used.mixed);
            }
        }
        const bool seldom = used.blades || (used.rests && used.mean_pressure);
        if (!seldom && used.plasticity != PlasticityClass::any) {
            EXPECT_NE(f.plasticity, PlasticityClass::any);
        }
    }
}

TEST(Features, WhatAStageDoesNotDependOnMakesNoOtherKernel)
{
    for (Features used : scenes()) {
        const Features f = served<without_sums>(used);
        EXPECT_FALSE(f.fixed_point);
        used.fixed_point = !used.fixed_point;
        EXPECT_EQ(served<without_sums>(used), f);
    }
}

TEST(Features, GaussiansMakeNoOtherKernelOfAnyStage)
{
    for (Features used : scenes()) {
        const Features f = served<all_of>(used);
        used.splats = true;
        EXPECT_EQ(served<all_of>(used), f);
    }
}

TEST(Features, EachCombinationServesItselfSoNoneIsHiddenByOneBeforeIt)
{
    for (std::size_t k = 0; k < combinations; ++k)
        EXPECT_EQ(served<all_of>(combination(k)), combination(k)) << k;
}

}  // namespace
}  // namespace knead
