// The way of a camera: through its keys, smoothly, and refused where it is none.
#include "host/cli/camera_path.h"

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

using V = Vec3<double>;

std::vector<CameraKey> keys()
{
    return {{1, {{0, 0, -2}, {0, 0, 0}}},
            {1.5, {{1, 0, -2}, {0, 1, 0}}},
            {3, {{2, 1, -1}, {0, 1, 1}}},
            {4, {{2, 5, -1}, {0, 0, 1}}}};
}

TEST(CameraPath, PassesEveryKeyAndStandsStillBeforeAndBehind)
{
    const auto all = keys();
    for (const CameraKey& k : all) {
        EXPECT_NEAR(length(view_at(all, k.time).eye - k.view.eye), 0, 1e-12);
        EXPECT_NEAR(length(view_at(all, k.time).at - k.view.at), 0, 1e-12);
    }
    EXPECT_EQ(length(view_at(all, 0).eye - all.front().view.eye), 0);
    EXPECT_EQ(length(view_at(all, 1e9).at - all.back().view.at), 0);
}

TEST(CameraPath, HasNoJumpAndNoKinkAtAKey)
{
    const auto all = keys();
    const double h = 1e-5;
    for (std::size_t k = 1; k + 1 < all.size(); ++k) {
        const double t = all[k].time;
        const V at = view_at(all, t).eye, before = at - view_at(all, t - h).eye,
                behind = view_at(all, t + h).eye - at;
        EXPECT_LT(length(before), 1e-3);
        EXPECT_LT(length(before - behind), 1e-3 * length(before)) << "key " << k;
    }
}

TEST(CameraPath, OfKeysOnALineAtTheirTimesIsThatLine)
{
    std::vector<CameraKey> line;
    for (double t : {0.0, 0.5, 2.0, 2.25}) line.push_back({t, {{t, 2 * t, -1}, {0, 0, t}}});
    for (double t = 0; t <= 2.25; t += 0.0625)
        EXPECT_NEAR(length(view_at(line, t).eye - V{t, 2 * t, -1}), 0, 1e-12) << t;
}

TEST(CameraPath, IsReadOrRefusedWithItsPlace)
{
    const Folder folder;
    const auto written = [&](const std::string& keys_text) {
        write_whole(folder / "p.json", R"({"schema": "knead.path/1", "keys": )" + keys_text + "}");
        return folder / "p.json";
    };
    const auto why = [&](const std::string& keys_text) {
        return reason<InputError>([&] { read_camera_path(written(keys_text)); });
    };
    const std::string first = R"([{"time": 0, "eye": [0, 0, -2], "at": [0, 0, 0]}, )";
    const auto all =
        read_camera_path(written(first + R"({"time": 2, "eye": [1, 0, -2], "at": [0, 1, 0]}])"));
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[1].time, 2);
    EXPECT_EQ(all[1].view.at.y, 1);
    const auto says = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    EXPECT_PRED2(says, why("[]"), "/keys: expected an array of at least 2 keys");
    EXPECT_PRED2(says, why("3"), "/keys: expected an array");
    EXPECT_PRED2(says, why(first + R"({"time": 0, "eye": [1, 0, 0], "at": [0, 1, 0]}])"),
                 "/keys: expected times that rise");
    EXPECT_PRED2(says, why(first + R"({"time": 1, "eye": [1, 0, 0], "at": [1, 0, 0]}])"),
                 "/keys/1/eye: expected another place");
    EXPECT_PRED2(says, why(first + R"({"time": 1, "eye": [1, 0], "at": [1, 0, 0]}])"),
                 "/keys/1/eye");
    EXPECT_PRED2(says, why(first + R"({"time": 1e9, "eye": [1, 0, 1], "at": [1, 0, 0]}])"),
                 "/keys/1/time");
    EXPECT_PRED2(says, why(first + R"({"time": 1, "eye": [1, 0, 1], "at": [1, 0, 0], "x": 1}])"),
                 "/keys/1/x: unknown key");
    EXPECT_PRED2(says, why(first + "7]"), "/keys/1");
    write_whole(folder / "p.json", R"({"schema": "knead.scene/1", "keys": []})");
    EXPECT_PRED2(says, reason<InputError>([&] { read_camera_path(folder / "p.json"); }),
                 "/schema: expected \"knead.path/1\"");
}

}  // namespace
}  // namespace knead
