// What is told beforehand of the time that a frame takes.
#include "host/run/estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/assets/splat_object.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/scene/seed.h"
#include "tests/folder.h"

namespace knead {
namespace {

constexpr Device cpu{DeviceKind::cpu, 0};
const std::vector<std::string> coarse{"domain.cells=16", "gravity=[0,0,0]"};

Scene loaded(const std::string& file, const std::vector<std::string>& settings = coarse)
{
    Scene scene = read_scene(file, settings);
    load_splats(scene, available_memory());
    build(scene, available_memory());
    scene.setup.threads = 1;
    return scene;
}

class Estimate : public InFolder {
  protected:
    // The floor of local clay with a ball beside it, or that alone.
    std::string with_ball(bool floor)
    {
        Json root = read_json("scenes/ground.json");
        Json& objects = root["objects"];
        std::filesystem::copy_file("scenes/ground.spz", path("ground.spz"));
        if (!floor) objects.erase(0), root.erase("rest");
        objects.push_back({{"centre", {0.4, 0.6, 0.4}},
                           {"diameter", 0.2},
                           {"material", "clay"},
                           {"category", 1}});
        if (floor)
            root["hands"]["recording"] = "poke";
        else
            root.erase("hands");
        write_whole(path("scene.json"), root.dump());
        return path("scene.json");
    }
};

TEST_F(Estimate, ClayThatComesWithTheHandsIsToldByTheParticle)
{
    FrameCost still = frame_cost(loaded("scenes/ground.json"), cpu);
    still.known = true;  // whatever else this machine does
    EXPECT_TRUE(still.still);
    EXPECT_EQ(still.seconds, 0);
    EXPECT_GT(still.per_thousand, 0);
    const std::string text = cost_text(still);
    EXPECT_NE(text.find("depends on the hands"), std::string::npos) << text;
    EXPECT_NE(text.find(" s on this machine for each 1000 particles"), std::string::npos) << text;
    EXPECT_EQ(text.find(" s a frame"), std::string::npos) << text;
}

TEST_F(Estimate, WhatIsNotKnownWithinAFactorOfThreeIsNotGiven)
{
    FrameCost cost;
    cost.seconds = 0.0725, cost.per_thousand = 0.0415;
    EXPECT_NE(cost_text(cost).find("0.072 s a frame"), std::string::npos) << cost_text(cost);
    cost.known = false;
    for (const bool still : {false, true}) {
        cost.still = still;
        EXPECT_EQ(cost_text(cost).find_first_of("0123456789"), std::string::npos)
            << cost_text(cost);
        EXPECT_NE(cost_text(cost).find("a frame"), std::string::npos) << cost_text(cost);
    }
    // Each is within that factor of what is so, and so within its square of another.
    const Scene ball = loaded("scenes/squeeze.json");
    double least = 1e300, most = 0;
    for (int k = 0; k < 5; ++k) {
        const FrameCost estimated = frame_cost(ball, cpu);
        EXPECT_GT(estimated.seconds, 0);
        if (estimated.known)
            least = std::min(least, estimated.seconds), most = std::max(most, estimated.seconds);
    }
    EXPECT_LT(most, 9 * least) << "or none was known";
}

TEST_F(Estimate, OfBothKindsOfClayEachIsTold)
{
    const Scene both = loaded(with_ball(true));
    FrameCost cost = frame_cost(both, cpu);
    for (int k = 1; k < 10 && !cost.known; ++k) cost = frame_cost(both, cpu);
    if (!cost.known) GTEST_SKIP() << "the speed of this machine changes too much to be measured";
    EXPECT_FALSE(cost.still);
    EXPECT_GT(cost.seconds, 0);
    EXPECT_GT(cost.per_thousand, 0);
    // Of one kind of material: a thousand particles of either cost alike, to what is measured.
    const double thousands = expected_particles(both) / 1000;
    EXPECT_GT(cost.seconds, 0.2 * cost.per_thousand * thousands);
    EXPECT_LT(cost.seconds, 5 * cost.per_thousand * thousands);
    const std::string text = cost_text(cost);
    EXPECT_NE(text.find(" s a frame on this machine"), std::string::npos) << text;
    EXPECT_NE(text.find(" s more for each 1000 particles"), std::string::npos) << text;
}

TEST_F(Estimate, AFrameTakesAboutWhatWasTold)
{
    const Scene ball = loaded(with_ball(false), {"domain.cells=32", "gravity=[0,0,0]"});
    FrameCost cost = frame_cost(ball, cpu);
    cost.known = true;
    EXPECT_EQ(cost.per_thousand, 0);
    EXPECT_FALSE(cost.still);
    EXPECT_EQ(cost_text(cost).find("1000 particles"), std::string::npos);
    const std::unique_ptr<Simulator> solver = make_solver(ball.setup, cpu);
    solver->advance({}, frame_duration(ball));
    const double begin = process_seconds();
    for (int k = 0; k < 3; ++k) solver->advance({}, frame_duration(ball));
    const double took = (process_seconds() - begin) / 3;
    EXPECT_GT(cost.seconds, took / 8);
    EXPECT_LT(cost.seconds, took * 20) << "others may take the processor meanwhile";
}

}  // namespace
}  // namespace knead
