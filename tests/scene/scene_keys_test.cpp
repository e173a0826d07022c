// Keys of a scene whose range or default hangs on others.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "host/base/json_reader.h"
#include "host/scene/scene.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

class SceneKeys : public InFolder {
  protected:
    Scene scene(const std::vector<std::string>& settings) const
    {
        const std::filesystem::path path = folder / "scene.json";
        std::ofstream(path) << R"({"schema": "knead.scene/1", "objects": [
            {"centre": [0.5, 0.5, 0.5], "diameter": 0.5, "material": "jelly"}]})";
        return read_scene(path.string(), settings);
    }
};

TEST_F(SceneKeys, SnowThatMakesEnergyAsItIsPackedIsRefusedByTheNamesOfItsKeys)
{
    const auto complaint = [&](const std::string& compress, const std::string& snow) {
        return reason<InputError>([&] {
            scene({"objects.0.material.preset=snow", "objects.0.material.compress=" + compress,
                   "objects.0.material.snow=" + snow});
        });
    };
    EXPECT_EQ(complaint("0.025", "10"), "");
    EXPECT_EQ(complaint("0.05", "10"), "");
    EXPECT_EQ(complaint("0.1", "3"), "");
    const std::string refused = complaint("0.1", "12");
    EXPECT_NE(
        refused.find("/objects/0/material/compress: expected 1.5 compress (snow + 3) below 1, "
                     "or packing it would make energy, found 0.1 with a `snow` of 12"),
        std::string::npos)
        << refused;
    // Of another plasticity they have no effect.
    EXPECT_EQ(reason<InputError>([&] { scene({"objects.0.material.compress=0.9"}); }), "");
}

TEST_F(SceneKeys, BodiesHaveAFieldEachAndNoKnife)
{
    EXPECT_FALSE(scene({}).setup.contact.separate);
    EXPECT_EQ(scene({}).setup.contact.friction, 0.4);
    const Scene s = scene({"contact.categories=separate", "contact.friction=0.7"});
    EXPECT_TRUE(s.setup.contact.separate);
    EXPECT_EQ(s.setup.contact.friction, 0.7);
    const auto complaint = [&](std::vector<std::string> settings) {
        settings.push_back("contact.categories=separate");
        return reason<InputError>([&] { scene(settings); });
    };
    EXPECT_NE(complaint({"contact.friction=3"}).find("/contact/friction: expected"),
              std::string::npos);
    const auto objects = [](int categories) {
        std::string list;
        for (int c = 0; c < categories; ++c)
            list += (c ? "," : "") + std::string(R"({"centre": [0.5, 0.5, 0.5], "diameter": 0.2,
                "material": "jelly", "category": )") +
                    std::to_string(c) + "}";
        return "objects=[" + list + "]";
    };
    EXPECT_EQ(complaint({objects(64)}), "");
    EXPECT_NE(complaint({objects(65)})
                  .find("/contact/categories: expected \"weld\", or objects of at most 64 "
                        "categories, found \"separate\" with 65"),
              std::string::npos)
        << complaint({objects(65)});
    EXPECT_EQ(complaint({R"(hands={"left": {"held": "knife"}})"}), "");
}

TEST_F(SceneKeys, BoxesThatAloneDecideWhatMovesReachTwoRadiiOfAFingertip)
{
    const auto reach = [&](const char* mode, const char* zoom, const char* cells) {
        return scene({std::string("rest.mode=") + mode,
                      std::string("hands={\"zoom\": ") + zoom + "}",
                      std::string("domain.cells=") + cells})
            .setup.rest.reach;
    };
    EXPECT_DOUBLE_EQ(reach("localized", "2.5", "64"), 8.0 / 64);
    EXPECT_DOUBLE_EQ(reach("localized", "2.5", "256"), 0.05);
    EXPECT_DOUBLE_EQ(reach("localized", "1", "256"), 8.0 / 256);
    EXPECT_DOUBLE_EQ(reach("sleep", "2.5", "64"), 4.0 / 64);
}

}  // namespace
}  // namespace knead
