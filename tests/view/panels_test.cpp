// Between panels and session: materials as sliders and back, scenes by name, what is asked for.
#include <gtest/gtest.h>

#include <algorithm>

#include "host/cli/view_panels.h"
#include "host/session/device.h"

namespace knead {
namespace {

TEST(ViewPanels, EveryPresetIsStatedAsItWasMade)
{
    for (const std::string& name : preset_names()) {
        Object object;
        object.preset = name;
        object.material = preset(name);
        const MaterialSpec spec = with_sliders(stated(object), sliders_of(stated(object)));
        const Material<double> again = made(spec), wanted = object.material;
        EXPECT_NEAR(again.mu, wanted.mu, 1e-9 * wanted.mu) << name;
        EXPECT_NEAR(again.lambda, wanted.lambda, 1e-9 * wanted.lambda) << name;
        EXPECT_DOUBLE_EQ(again.yield, wanted.yield) << name;
        EXPECT_DOUBLE_EQ(again.hardening, wanted.hardening) << name;
        EXPECT_DOUBLE_EQ(again.viscosity, wanted.viscosity) << name;
        EXPECT_NEAR(again.friction, wanted.friction, 1e-12) << name;
        EXPECT_NEAR(again.cohesion, wanted.cohesion, 1e-12) << name;
        EXPECT_NEAR(again.bulk, wanted.bulk, 1e-9 * wanted.bulk) << name;
        EXPECT_EQ(again.plasticity, wanted.plasticity) << name;
    }
}

TEST(ViewPanels, SlidersAreThoseThatTheMaterialUses)
{
    const auto names = [](const char* preset) {
        std::string all;
        for (const Slider& s : sliders_of(material_spec(preset))) all += s.name + " ";
        return all;
    };
    EXPECT_EQ(names("jelly"), "Density Stiffness Poisson ");
    EXPECT_EQ(names("viscous-liquid"), "Density Viscosity ");
    EXPECT_EQ(names("wet-sand"), "Density Stiffness Poisson Friction Cohesion ");
    EXPECT_THROW(with_sliders(material_spec("jelly"), {{"Yield", "Pa", 1}}), std::invalid_argument);
    for (const Slider& s : sliders_of(material_spec("clay"))) {
        EXPECT_LE(s.low, s.value);
        EXPECT_GE(s.high, s.value);
    }
}

TEST(ViewPanels, KnowTheScenesBesideTheirOwn)
{
    const std::vector<std::string> scenes = scenes_beside("scenes/squeeze.json");
    EXPECT_EQ(std::count(scenes.begin(), scenes.end(), "scenes/squeeze.json"), 1);
    EXPECT_EQ(std::count(scenes.begin(), scenes.end(), "scenes/pot.json"), 1);
    EXPECT_TRUE(std::is_sorted(scenes.begin(), scenes.end()));
    EXPECT_EQ(scenes_beside("no/such/scene.json").size(), 1u);
}

TEST(ViewPanels, WhatIsAskedForReachesTheSolver)
{
    LiveRule rule;
    rule.make = [](const auto& setup) { return cpu_solver(setup); };
    rule.stepped = true;
    const std::vector<std::string> small{"domain.cells=16", "surface.nodes=32"};
    LiveSession session(load_live_scene("scenes/squeeze.json", small), rule);
    session.settle();
    ViewPanels panels("scenes/squeeze.json");
    panels.follow(*session.state());
    ASSERT_EQ(panels.model.objects.size(), 1u);
    EXPECT_EQ(panels.model.scenes.at(std::size_t(panels.model.scene)), "squeeze");
    EXPECT_TRUE(panels.model.recorded);
    EXPECT_DOUBLE_EQ(panels.model.gravity, 9.81);
    PanelAsks asks;
    asks.gravity = 3, asks.pause = true, asks.tool = 5, asks.material = true;
    for (Slider& s : panels.model.objects[0].sliders)
        if (s.name == "Stiffness") s.value = 2e5;
    panels.obey(asks, session, *session.state());
    session.ask([](const Solver& s) {
        EXPECT_EQ(s.rules().gravity.y, -3);
        EXPECT_NEAR(s.rules().materials[0].mu, 2e5 / 2.6, 1);
        EXPECT_TRUE(s.rules().tools[1].blade);
    });
    panels.follow(*session.state());
    EXPECT_TRUE(panels.model.paused);
    asks = {};
    asks.load = 1000;
    EXPECT_THROW(panels.obey(asks, session, *session.state()), std::out_of_range);
    asks = {};
    asks.preset = true;
    panels.model.objects[0].preset = 5;
    panels.obey(asks, session, *session.state());
    session.ask([](const Solver& s) { EXPECT_EQ(s.rules().materials[0].yield, 0); });
    EXPECT_EQ(session.state()->refused, 0) << session.state()->refusal;
    session.load("scenes/nothing.json", {});
    session.settle();
    panels.follow(*session.state());
    EXPECT_NE(panels.model.notice.find("nothing.json"), std::string::npos);
}

}  // namespace
}  // namespace knead
