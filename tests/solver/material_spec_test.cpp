// Materials as people state them: there and back, and what can be, asked by scenes and edits alike.
#include "host/solver/material_spec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/base/errors.h"
#include "host/scene/presets.h"
#include "host/scene/scene.h"
#include "host/solver/edits.h"

namespace knead {
namespace {

// A material that uses the quantity.
MaterialSpec user_of(const MaterialQuantity& quantity)
{
    for (const MaterialSpec& spec : material_specs())
        if (quantity.used(spec)) return spec;
    throw std::logic_error(std::string("no preset uses ") + quantity.key);
}

Setup one_object(const MaterialSpec& spec)
{
    Setup setup;
    setup.lattice = {{16, 16, 16}, 0.05};
    setup.materials.push_back(made(spec));
    setup.materials[0].volume = 1e-5;
    setup.materials[0].mass = 1e-5 * spec.density;
    return setup;
}

std::string refused_edit(const MaterialSpec& from, const MaterialSpec& to)
{
    SceneState rules(one_object(from));
    try {
        rules.set_material(0, made(to));
    } catch (const std::invalid_argument& e) {
        EXPECT_EQ(rules.config().materials[0].density, from.density) << "nothing was changed";
        return e.what();
    }
    return "";
}

std::string refused_scene(const MaterialSpec& from, const std::string& key, double value)
{
    try {
        read_scene("scenes/squeeze.json",
                   {"objects.0.material={\"preset\":\"" + from.name + "\"}",
                    "objects.0.material." + key + "=" + std::to_string(value)});
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(MaterialSpec, ComesBackFromTheConstantsThatItIsMadeInto)
{
    for (const MaterialSpec& spec : material_specs()) {
        const MaterialSpec again = stated(made(spec));
        EXPECT_EQ(again.plasticity, spec.plasticity);
        EXPECT_EQ(again.elasticity, spec.elasticity);
        for (const MaterialQuantity& q : material_quantities())
            if (q.used(spec)) {
                const double value = spec.*q.value;
                EXPECT_NEAR(again.*q.value, value, 1e-12 * std::abs(value)) << spec.name << q.key;
            }
        EXPECT_FALSE(fault_of(spec)) << spec.name;
        EXPECT_FALSE(fault_of(again)) << spec.name;
    }
    MaterialSpec stiff = material_spec("clay");
    stiff.poisson = 0.499, stiff.young = 1e12;
    EXPECT_FALSE(fault_of(stated(made(stiff)))) << "the ends of a range belong to it, rounded";
}

TEST(MaterialSpec, ScenesAndEditsRefuseWhatLiesBeyondEveryRange)
{
    for (const MaterialQuantity& q : material_quantities()) {
        const MaterialSpec from = user_of(q);
        for (const double value :
             {q.high + 0.1 * std::abs(q.high), q.low - 0.1 - 0.1 * std::abs(q.low)}) {
            MaterialSpec to = from;
            to.*q.value = value;
            const auto fault = fault_of(to);
            ASSERT_TRUE(fault) << q.key << " " << value;
            // Snow that is out of its range does not go with its `compress` either.
            EXPECT_EQ(fault->key, std::string(q.key) == "snow" && value > 0 ? "compress" : q.key);
            EXPECT_NE(refused_scene(from, q.key, value), "") << q.key << " " << value;
            // Of 98 degrees the friction is that of 82, which can be.
            if (std::string(q.key) == "friction_angle" && value > 90) continue;
            EXPECT_NE(refused_edit(from, to), "") << q.key << " " << value;
        }
        MaterialSpec none = from;
        none.*q.value = std::numeric_limits<double>::quiet_NaN();
        EXPECT_TRUE(fault_of(none)) << q.key;
        EXPECT_NE(refused_edit(from, none), "") << q.key;
    }
}

TEST(MaterialSpec, AnEditWithPoissonsRatioOfTwoIsRefusedInAShortSentence)
{
    MaterialSpec clay = material_spec("clay"), burst = clay;
    burst.poisson = 2;
    const std::string why = refused_edit(clay, burst);
    EXPECT_EQ(why, "poisson: expected 0 to 0.499, found 2");
    MaterialSpec hang = clay;
    hang.young = 1e15;
    EXPECT_EQ(refused_edit(clay, hang).find("young: expected 1 to 1e+12 Pa"), 0u);
}

TEST(MaterialSpec, WhatALawCannotDoWithoutIsAskedForByScenesAndEdits)
{
    MaterialSpec clay = material_spec("clay"), flowing = clay;
    flowing.yield = 0;
    EXPECT_NE(refused_edit(clay, flowing).find("yield"), std::string::npos);
    EXPECT_NE(refused_scene(clay, "yield", 0).find("yield"), std::string::npos);
    const MaterialSpec sand = material_spec("wet-sand");
    MaterialSpec dust = sand;
    dust.friction_angle = 0, dust.cohesion = 0;
    EXPECT_NE(refused_edit(sand, dust).find("friction_angle"), std::string::npos);
}

TEST(MaterialSpec, SlidersLieInTheRangesOfTheirQuantities)
{
    for (const MaterialQuantity& q : material_quantities()) {
        if (q.slider.high <= q.slider.low) continue;
        EXPECT_GE(q.slider.low, q.low) << q.key;
        EXPECT_LE(q.slider.high, q.high) << q.key;
        EXPECT_TRUE(!q.slider.logarithmic || q.slider.low > 0) << q.key;
    }
    EXPECT_THROW(material_quantity("flow"), std::out_of_range);
}

TEST(Gravity, OfAnEditHasTheRangeOfAScenes)
{
    SceneState rules(one_object(material_spec("clay")));
    EXPECT_THROW(rules.set_gravity({0, -1e4, 0}), std::invalid_argument);
    EXPECT_NO_THROW(rules.set_gravity({0, -most_gravity, 0}));
    EXPECT_THROW(read_scene("scenes/squeeze.json", {"gravity=[0,-10000,0]"}), InputError);
}

}  // namespace
}  // namespace knead
