// What a scene says of splats that are split and added.
#include <gtest/gtest.h>

#include <fstream>

#include "host/base/errors.h"
#include "host/scene/scene.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

class SplatKeys : public InFolder {
  protected:
    Scene scene(const std::string& splats) const
    {
        const std::string file = path("scene.json");
        std::ofstream(file) << R"({"schema": "knead.scene/1", "objects": [{"diameter": 0.1,
            "centre": [0.5, 0.5, 0.5]}])"
                            << splats << "}";
        return read_scene(file);
    }
    std::string complaint(const std::string& splats) const
    {
        return reason<InputError>([&] { scene(", \"splats\": " + splats); });
    }
};

TEST_F(SplatKeys, ArriveWithTheirDefaults)
{
    const UpkeepOptions plain = scene("").upkeep;
    EXPECT_TRUE(plain.splits && plain.refills);
    EXPECT_EQ(plain.every, 5);
    EXPECT_EQ(plain.split.limit, SplitOptions{}.limit);
    EXPECT_EQ(plain.refill.see_through, RefillOptions{}.see_through);
    const UpkeepOptions all = scene(R"(, "splats": {"every": 3, "capacity": 9000,
        "split": {"limit": 2, "smallest": 0.01, "budget": 7},
        "refill": {"see_through": 0.5, "budget": 8}})")
                                  .upkeep;
    EXPECT_EQ(all.every, 3);
    EXPECT_EQ(all.capacity, 9000u);
    EXPECT_EQ(all.split.limit, 2);
    EXPECT_EQ(all.split.smallest, 0.01);
    EXPECT_EQ(all.split.budget, 7u);
    EXPECT_EQ(all.refill.see_through, 0.5);
    EXPECT_EQ(all.refill.budget, 8u);
    const UpkeepOptions off =
        scene(R"(, "splats": {"split": {"limit": 0}, "refill": {"see_through": 1}})").upkeep;
    EXPECT_FALSE(off.splits || off.refills);
}

TEST_F(SplatKeys, WhatCannotBeIsRefusedWithItsPlace)
{
    EXPECT_NE(complaint(R"({"evry": 2})").find("every"), std::string::npos);
    EXPECT_NE(complaint(R"({"every": 0})").find("/splats/every"), std::string::npos);
    EXPECT_NE(complaint(R"({"split": {"limit": 1}})").find("1.1"), std::string::npos);
    EXPECT_NE(complaint(R"({"split": {"budget": 0}})").find("/splats/split/budget"),
              std::string::npos);
    EXPECT_NE(complaint(R"({"refill": {"see_through": 0}})").find("see_through"),
              std::string::npos);
    EXPECT_NE(complaint(R"({"refill": 3})").find("/splats/refill"), std::string::npos);
}

}  // namespace
}  // namespace knead
