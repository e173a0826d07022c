// Materials that a frame's substeps cannot carry: simulated softer, by as much as is said.
#include "host/scene/soften.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/live/live_session.h"
#include "host/run/report.h"
#include "host/scene/foresight.h"
#include "host/scene/presets.h"
#include "host/solver/audit.h"
#include "host/verify/clay.h"

namespace knead {
namespace {

// A block of 4 x 6 x 4 cells of 1 cm, so far above the floor at 3 cm.
Scene block(const std::string& material, double above, const std::vector<std::string>& settings)
{
    const std::string text =
        R"({"schema": "knead.scene/1", "domain": {"edge": 0.2, "cells": 20},
            "walls": {"min": [0.03, 0.03, 0.03], "max": [0.17, 0.17, 0.17],
                      "contact_mode": "slip"},
            "objects": [{"name": "stone", "shape": "box", "centre": [0.1, )" +
        std::to_string(0.06 + above) + R"(, 0.1], "size": [0.04, 0.06, 0.04], "material": )" +
        material + "}]}";
    Scene scene = parse_scene(text, "stone.json", settings);
    scene.setup.threads = 1;
    return scene;
}

const char* const stone = R"({"young": 1e9, "poisson": 0.3, "density": 2500, "yield": 1e5})";

std::string refusal(const std::string& material, const std::vector<std::string>& settings)
{
    try {
        block(material, 0, settings);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

double height(const Simulator& solver)
{
    const auto all = solver.particles();
    double sum = 0;
    for (const Particle<double>& q : all) sum += q.x.y;
    return sum / double(all.size());
}

// How far its middle sinks in the first swing after its weight is put on it [m].
double first_swing(const Scene& given, double frame)
{
    Scene scene = given;
    build(scene, std::size_t(1) << 30);
    const auto solver = cpu_solver(scene.setup);
    const double start = height(*solver);
    double lowest = start;
    for (int i = 0; i < 400; ++i) {
        solver->advance({}, frame);
        const double now = height(*solver);
        if (now > lowest + 0.02 * (start - lowest) && i > 2) break;
        lowest = std::fmin(lowest, now);
    }
    return start - lowest;
}

TEST(Soften, WithoutTheKeyAndWhereItIsNotNeededNothingChanges)
{
    for (const char* key : {"step.soften_beyond=0", "step.soften_beyond=100000"}) {
        const Scene plain = block(stone, 0, {}), requested = block(stone, 0, {key});
        const Object &a = plain.objects[0], &b = requested.objects[0];
        EXPECT_EQ(b.softer, 1);
        EXPECT_EQ(a.material.mu, b.material.mu);
        EXPECT_EQ(a.material.lambda, b.material.lambda);
        EXPECT_EQ(a.material.bulk, b.material.bulk);
        EXPECT_EQ(a.material.yield, b.material.yield);
        EXPECT_EQ(softened_text(requested, b), "");
        EXPECT_TRUE(softened_facts(requested).empty());
        EXPECT_EQ(foresee(plain).substeps, foresee(requested).substeps);
    }
}

TEST(Soften, AFrameTakesAsManySubstepsAsAskedForAndTheTextSaysWhatThatCosts)
{
    const Scene plain = block(stone, 0, {});
    const Scene s = block(stone, 0, {"step.soften_beyond=60"});
    const double needed = foresee(plain).substeps;
    EXPECT_GT(needed, 600);
    EXPECT_EQ(foresee(s).substeps, 60);
    const Object& o = s.objects[0];
    EXPECT_NEAR(o.softer, std::pow(needed / 60, 2), 0.01 * o.softer);
    EXPECT_NEAR(elastic_modulus(o.material) * o.softer, 1e9, 1);
    EXPECT_EQ(o.material.density, 2500);
    EXPECT_EQ(o.material.yield, 1e5);
    const std::string text = softened_text(s, o);
    EXPECT_EQ(text.find("stone: simulated at "), 0u) << text;
    EXPECT_NE(text.find(" MPa instead of 1 GPa, bends about "), std::string::npos) << text;
    EXPECT_NE(text.find("; 60 substeps a frame instead of "), std::string::npos) << text;
    EXPECT_NE(text.find("it yields at the same stress"), std::string::npos) << text;
    EXPECT_EQ(softened_facts(s).at(0).at("text"), text);
    EXPECT_EQ(softened_facts(s).at(0).at("given_Pa"), elastic_modulus(o.material) * o.softer);
}

TEST(Soften, LiquidsAndSandAreSoftenedAndYieldAtTheSameStress)
{
    const Scene water = block(R"({"preset": "viscous-liquid", "bulk": 2e9, "viscosity": 0.001})", 0,
                              {"step.soften_beyond=50"});
    EXPECT_EQ(foresee(water).substeps, 50);
    EXPECT_NE(softened_text(water, water.objects[0]).find("bulk modulus of "), std::string::npos);
    const Material<double> sand = preset("wet-sand");
    const Material<double> soft = softer(sand, 10);
    const auto tip = [](const Material<double>& m) { return m.bulk * m.cohesion; };
    EXPECT_NEAR(tip(soft), tip(sand), 1e-9 * tip(sand));
    EXPECT_EQ(soft.friction, sand.friction);
}

TEST(Soften, WhatWouldYieldOnlyAtItsOwnStiffnessIsRefusedWithTheSubstepsThatItNeeds)
{
    const std::string hard = R"({"young": 1e9, "poisson": 0.3, "density": 2500, "yield": 1e8})";
    const std::string said = refusal(hard, {"step.soften_beyond=60"});
    const std::string expected = "/step/soften_beyond: expected at least ";
    ASSERT_NE(said.find(expected), std::string::npos) << said;
    const int enough = std::stoi(said.substr(said.find(expected) + expected.size()));
    EXPECT_EQ(refusal(hard, {"step.soften_beyond=" + std::to_string(enough)}), "accepted");
    EXPECT_NE(refusal(hard, {"step.soften_beyond=" + std::to_string(enough - 2)}), "accepted");
    EXPECT_NE(refusal(stone, {"step.soften_beyond=60", "step.fixed=1e-4"}), "accepted");
    EXPECT_NE(refusal(stone, {"step.soften_beyond=60", "clock=paper"}), "accepted");
}

TEST(Soften, AnElasticBlockSinksUnderItsWeightByAsManyTimesAsIsSaid)
{
    const std::string rubber =
        R"({"preset": "jelly", "young": 1e6, "poisson": 0.3, "density": 1000})";
    const Scene plain = block(rubber, 0, {});
    const Scene soft = block(rubber, 0, {"step.soften_beyond=16"});
    const double times = soft.objects[0].softer;
    EXPECT_GT(times, 5);
    const double ratio = first_swing(soft, 5e-4 * std::sqrt(times)) / first_swing(plain, 5e-4);
    EXPECT_NEAR(ratio / times, 1, 0.1);
}

TEST(Soften, AMaterialThatALiveSessionIsGivenIsSoftenedLikewise)
{
    const auto live = load_live_scene(
        "scenes/squeeze.json", {"domain.cells=16", "surface.nodes=32", "step.soften_beyond=30"});
    LiveOptions options;
    options.make_solver = cpu_solver;
    options.stepped = true;
    LiveSession session(live, options);
    const Material<double> clay = preset("clay"), stiff = softer(clay, 1e-4);
    const double times = softening(live->scene, stiff);
    EXPECT_GT(times, 10);
    const auto modulus_with = [&](const Material<double>& given) {
        session.send(SetMaterial{ObjectId{1}, stated(given)});
        double modulus = 0;
        session.inspect_solver([&](const Simulator& s) {
            modulus = elastic_modulus(s.editable()->config().materials[0]);
        });
        return modulus;
    };
    EXPECT_NEAR(modulus_with(stiff) * times / elastic_modulus(stiff), 1, 1e-6);
    EXPECT_NEAR(modulus_with(clay) / elastic_modulus(clay), 1, 1e-6);
}

// It comes to rest up to a cell above the floor, whose nodes it feels as far as they weigh (1).
TEST(Soften, ItMayBeRepeatedFromTheStatedMaterial)
{
    const Scene once = block(stone, 0, {"step.soften_beyond=20", "objects.0.category=3"});
    ASSERT_GT(once.objects[0].softer, 1);
    const auto same = [](const Object& a, const Object& b) {
        const Material<double>&m = a.material, &n = b.material;
        return a.softer == b.softer && m.mu == n.mu && m.lambda == n.lambda && m.bulk == n.bulk &&
               m.cohesion == n.cohesion && m.yield == n.yield && m.density == n.density &&
               m.volume == n.volume && m.mass == n.mass && m.category == n.category;
    };
    Scene again = once;
    soften(again), soften(again);
    EXPECT_TRUE(same(again.objects[0], once.objects[0]));
    Scene built = once;
    build(built, std::size_t(1) << 30);
    again = built;
    soften(again);
    EXPECT_TRUE(same(again.objects[0], built.objects[0]));
    EXPECT_GT(again.objects[0].material.mass, 0);
    // Another limit, and none.
    again.soften_beyond = 40;
    soften(again);
    EXPECT_TRUE(same(again.objects[0], [&] {
        Scene other = block(stone, 0, {"step.soften_beyond=40", "objects.0.category=3"});
        build(other, std::size_t(1) << 30);
        return other.objects[0];
    }()));
    again.soften_beyond = 0;
    soften(again);
    EXPECT_EQ(again.objects[0].softer, 1);
    EXPECT_EQ(again.objects[0].material.mu, made(again.objects[0].stated).mu);
}

TEST(Soften, AStiffBlockFallsRestsAndIsPressedByAToolInFewSubstepsWithoutAGuard)
{
    constexpr int requested = 40;
    constexpr double high = 0.03, begin = 2, end = 2.6;  // [m] [s]
    Scene scene = block(stone, high, {"step.soften_beyond=" + std::to_string(requested)});
    build(scene, std::size_t(1) << 30);
    auto& s = scene.setup;
    const Place floor{0.1, s.walls.min.y, 0.1};
    add_ball_tool(s, 0.03, ContactMode::separate, 0.4);
    const auto solver = cpu_solver(s);
    const double start = height(*solver), frame = frame_duration(scene), dx = s.lattice.dx;
    const auto tool = [&](double t) {  // from `begin` on down to 2 cm deep, and up again
        const double way = std::max(0.0, 0.2 * std::min(t - begin, begin + 0.5 - t));
        return std::vector{stands_at(floor + Place{0, 0.06 + 0.03 + 0.03 - way, 0})};
    };
    double fell = 0, before = 0, at_rest = 0, pressed = 0;
    const auto elastic = [&] { return audit(solver->particles(), s.materials, dx).elastic; };
    const FrameStats all = drive(*solver, frame, end, tool, [&](double t) {
        if (t < begin - 0.1) before = start - height(*solver);
        if (t < begin) fell = start - height(*solver), at_rest = elastic();
        if (t < begin + 0.25) pressed = elastic();
        return true;
    });
    EXPECT_LT(fell, high + 0.1 * dx);
    EXPECT_GT(fell, high - 1.1 * dx);
    EXPECT_NEAR(fell, before, 0.1 * dx);
    EXPECT_LE(all.substeps, 1.1 * requested * end / frame);
    EXPECT_GT(pressed, 10 * at_rest);
    EXPECT_EQ(
        all[Count::clipped] + all[Count::repaired] + all[Count::abrupt] + all[Count::moved_far], 0);
    EXPECT_EQ(audit(solver->particles(), s.materials, dx).broken, 0);
}

}  // namespace
}  // namespace knead
