// The folder of a live session: its mesh lies where that of an export does.
#include "host/ui/live_results.h"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/files/mesh_reader.h"
#include "host/session/backend.h"
#include "tests/folder.h"

namespace knead {
namespace {

// Walls at the domain's low faces: the simulation's origin is four cells below the file's.
constexpr const char* two_balls = R"({"schema": "knead.scene/1", "frame_rate": 60,
    "domain": {"edge": 1, "cells": 32}, "gravity": [0, 0, 0], "surface": {"nodes": 32},
    "walls": {"min": [0, 0, 0], "max": [1, 1, 1]},
    "objects": [{"name": "left", "centre": [0.3, 0.4, 0.5], "diameter": 0.3},
                {"name": "right", "centre": [0.7, 0.4, 0.5], "diameter": 0.3, "category": 5}]})";

class LiveResultsFolder : public InFolder {};

TEST_F(LiveResultsFolder, TheMeshHasTheVerticesAndCategoriesOfTheExport)
{
    write_whole(path("scene.json"), two_balls);
    LiveOptions options;
    options.stepped = true, options.recorded = false;
    options.make_solver = [](const knead::Setup& s) { return make_solver(s, parse_device("cpu")); };
    LiveSession session(load_live_scene(path("scene.json")), options);
    session.send(Export{path("export.glb"), {}, {}, {}});
    session.wait_for_commands();
    for (int i = 0; i < 30000 && session.state()->exports == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_EQ(session.state()->exported, path("export.glb")) << session.state()->refusal;

    LiveOutputs outputs;
    outputs.out = path("out"), outputs.report = "view.json";
    const FolderLock lock = prepare(outputs);
    LiveResults results;
    results.state = session.state();
    ASSERT_GT(length(results.state->scene->scene.origin), 0.1);
    EXPECT_TRUE(write_results(outputs, results, {}));
    const std::vector<Mesh> written = read_mesh(path("out/mesh.glb")),
                            other = read_mesh(path("export.glb"));
    ASSERT_EQ(written.size(), 2u);
    ASSERT_EQ(other.size(), 2u);
    for (std::size_t m = 0; m < 2; ++m) {
        EXPECT_EQ(written[m].category, m == 0 ? 0 : 5);
        EXPECT_EQ(other[m].category, written[m].category);
        ASSERT_EQ(written[m].vertices.size(), other[m].vertices.size());
        Vec3<double> middle{};
        for (std::size_t v = 0; v < written[m].vertices.size(); ++v) {
            EXPECT_EQ(length(written[m].vertices[v] - other[m].vertices[v]), 0);
            middle = middle + 1.0 / double(written[m].vertices.size()) *
                                  cast<double>(written[m].vertices[v]);
        }
        EXPECT_NEAR(middle.x, m == 0 ? 0.3 : 0.7, 0.01) << "in the frame of the scene's file";
        EXPECT_NEAR(middle.y, 0.4, 0.01);
    }
}

}  // namespace
}  // namespace knead
