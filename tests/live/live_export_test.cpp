// Exports of a live session: size, names, objects and frame of the files, what the state reports,
// and that a replay writes nothing.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <thread>

#include "cuda/math/box.h"
#include "host/assets/procedural_object.h"
#include "host/base/json_reader.h"
#include "host/files/gltf.h"
#include "host/files/mesh_reader.h"
#include "host/files/splat_file.h"
#include "host/live/live_session.h"
#include "host/live/session_log.h"
#include "host/session/backend.h"
#include "tests/folder.h"

namespace knead {
namespace {

constexpr double cell = 1.0 / 32;  // [m]

// A ball of half a metre and two blocks of one category. Walls at the domain's low faces: the
// simulation's origin is four cells below the file's. No gravity: nothing moves.
constexpr const char* ball_and_blocks = R"({"schema": "knead.scene/1", "frame_rate": 60,
    "domain": {"edge": 1, "cells": 32}, "gravity": [0, 0, 0], "surface": {"nodes": 32},
    "walls": {"min": [0, 0, 0], "max": [1, 1, 1]},
    "objects": [
      {"name": "ball", "centre": [0.35, 0.35, 0.35], "diameter": 0.5},
      {"name": "left block", "shape": "box", "centre": [0.75, 0.75, 0.75], "size": [0.2, 0.2, 0.2],
       "category": 1},
      {"name": "lid", "shape": "box", "centre": [0.75, 0.75, 0.35], "size": [0.2, 0.2, 0.2],
       "category": 1}]})";
// Two clouds.
constexpr const char* pots = R"({"schema": "knead.scene/1", "frame_rate": 60,
    "domain": {"edge": 1, "cells": 32}, "gravity": [0, 0, 0],
    "objects": [
      {"name": "pot", "shape": "splats", "file": "pot.ply", "size": 0.2, "centre": [0.3, 0.5, 0.5]},
      {"name": "jug", "shape": "splats", "file": "pot.ply", "size": 0.2, "centre": [0.7, 0.5, 0.5],
       "category": 1}]})";

template <class T>
Vec3<double> extents(const Box3<T>& box)
{
    return cast<double>(box.high - box.low);
}
Box3<float> box_around(const std::vector<Vec3<float>>& all)
{
    Box3<float> box{all.at(0), all.at(0)};
    for (const Vec3<float> x : all) grow(box, x);
    return box;
}
Box3<float> box_around(const std::vector<Mesh>& meshes)
{
    Box3<float> box = box_around(meshes.at(0).vertices);
    for (const Mesh& mesh : meshes)
        for (const Vec3<float> x : mesh.vertices) grow(box, x);
    return box;
}

ObjectRef object(const std::string& name) { return name; }
std::optional<std::vector<ObjectRef>> named(const std::string& name)
{
    return std::vector<ObjectRef>{object(name)};
}

class LiveExport : public InFolder {
  protected:
    void begin(const char* text, bool stepped = true)
    {
        std::ofstream(path("scene.json")) << text;
        LiveOptions options;
        options.make_solver = make;
        options.stepped = stepped, options.recorded = false, options.logs = true;
        session = std::make_unique<LiveSession>(load_live_scene(path("scene.json")), options);
        session->wait_for_commands();
        ASSERT_EQ(session->state()->failure, "");
    }
    static std::unique_ptr<Simulator> make(const knead::Setup& setup)
    {
        return make_solver(setup, {DeviceKind::cpu, 0});
    }
    // Exports and waits; returns the refusal.
    std::string exported(Export command)
    {
        const auto before = session->state();
        const std::string to = command.file;
        session->send(std::move(command));
        std::shared_ptr<const LiveState> now;
        for (int i = 0; i < 30000; ++i) {
            now = session->state();
            if (now->exports > before->exports || now->refused > before->refused) break;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        if (now->refused > before->refused) return now->refusal;
        EXPECT_EQ(now->exports, before->exports + 1);
        EXPECT_EQ(now->exported, to);
        return "";
    }
    std::vector<std::string> names_in(const std::string& glb) const
    {
        std::vector<std::string> names;
        for (const GltfPart& part :
             parse_gltf(read_text(glb, 1 << 28), glb, GltfSkins::ignored).parts)
            names.push_back(part.mesh);
        return names;
    }

    std::unique_ptr<LiveSession> session;
};
using Texts = std::vector<std::string>;

TEST_F(LiveExport, ABallOfHalfAMetreIs500MillimetresInAnStlAndHalfAMetreElsewhere)
{
    begin(ball_and_blocks);
    const auto across = [&](Export command) {
        command.objects = named("ball");
        EXPECT_EQ(exported(command), "");
        return box_around(read_mesh(command.file));
    };
    const Box3<float> stl = across({path("a.stl"), {}, {}, {}});
    const Box3<float> glb = across({path("a.glb"), {}, {}, {}});
    const Box3<float> obj = across({path("a.obj"), {}, {}, {}});
    const Box3<float> ply = across({path("a.ply"), {}, LengthUnit::centimetre, {}});
    const Box3<float> inch = across({path("b.stl"), {}, LengthUnit::inch, {}});
    const auto expect = [](const Box3<float>& box, double unit) {
        for (const double x : {extents(box).x, extents(box).y, extents(box).z})
            EXPECT_NEAR(x * unit, 0.5, cell);
        const Vec3<double> centre = 0.5 * unit * cast<double>(box.low + box.high);
        EXPECT_NEAR(centre.x, 0.35, cell / 2) << "in the frame of the scene's file";
        EXPECT_NEAR(centre.y, 0.35, cell / 2);
        EXPECT_NEAR(centre.z, 0.35, cell / 2);
    };
    expect(stl, 1e-3), expect(glb, 1), expect(obj, 1), expect(ply, 1e-2), expect(inch, 0.0254);
    EXPECT_NEAR(extents(stl).x, 1e3 * extents(glb).x, 1e-3);
    EXPECT_EQ(read_text(path("b.stl"), 1 << 28).rfind("knead; inches", 0), 0u);
}

TEST_F(LiveExport, FilesHaveAMeshPerCategoryNamedAfterItsObjects)
{
    begin(ball_and_blocks);
    EXPECT_EQ(exported({path("all.glb"), {}, {}, {}}), "");
    EXPECT_EQ(names_in(path("all.glb")), (Texts{"ball", "left block + lid"}));
    EXPECT_EQ(exported({path("all.obj"), {}, {}, {}}), "");
    const std::string obj = read_text(path("all.obj"), 1 << 28);
    EXPECT_NE(obj.find("\no ball\n"), std::string::npos);
    EXPECT_NE(obj.find("\no left_block_+_lid\n"), std::string::npos);
    EXPECT_EQ(exported({path("one.glb"), {}, {}, named("lid")}), "");
    EXPECT_EQ(names_in(path("one.glb")), Texts{"left block + lid"}) << "one surface";

    session->send(SetFlags{object("ball"), {}, true});
    EXPECT_EQ(exported({path("shown.glb"), {}, {}, {}}), "");
    EXPECT_EQ(names_in(path("shown.glb")), Texts{"left block + lid"});
    EXPECT_EQ(exported({path("named.glb"), {}, {}, named("ball")}), "");
    EXPECT_EQ(names_in(path("named.glb")), Texts{"ball"});
    session->send(SetCategory{object("lid"), 2});
    session->send(Rename{object("lid"), "Deckel"});
    EXPECT_EQ(exported({path("parted.glb"), {}, {}, {}}), "");
    EXPECT_EQ(names_in(path("parted.glb")), (Texts{"left block", "Deckel"}));
}

TEST_F(LiveExport, ItIsNoStepAndAReplayWritesNothing)
{
    begin(ball_and_blocks);
    const auto before = session->state();
    EXPECT_EQ(exported({path("a.stl"), {}, {}, named("ball")}), "");
    const auto after = session->state();
    EXPECT_EQ(after->steps->size(), before->steps->size());
    EXPECT_EQ(after->unsaved, before->unsaved);
    EXPECT_EQ(after->document, before->document);
    EXPECT_EQ(after->mesh_version, before->mesh_version);
    const std::vector<AppliedCommand> applied = session->take_applied();
    ASSERT_EQ(applied.size(), 1u);
    const Export* logged = std::get_if<Export>(&applied[0].issued.command);
    ASSERT_TRUE(logged && logged->objects);
    EXPECT_TRUE(logged->objects->at(0).by == ObjectRef(ObjectId{1}).by);
    session->advance_to(2.0 / 60);
    const SessionLog log = session->session_log();
    std::filesystem::remove(path("a.stl"));
    EXPECT_EQ(replayed(log, make).size(), session->digest().particles);
    EXPECT_FALSE(std::filesystem::exists(path("a.stl")));
}

TEST_F(LiveExport, WhatCannotBeWrittenIsRefusedWithItsReason)
{
    begin(ball_and_blocks);
    EXPECT_EQ(exported({path("a.step"), {}, {}, {}}).rfind("Export: file: expected a name that", 0),
              0u);
    EXPECT_EQ(exported({path("a.glb"), {}, {}, named("bal")}),
              "Export: objects: there is no object \"bal\"; the nearest name is \"ball\"");
    const std::string nowhere = path("no folder/a.glb");
    const std::string why = exported({nowhere, {}, {}, {}});
    EXPECT_EQ(why.rfind("Export: " + nowhere + ": ", 0), 0u) << why;
    EXPECT_NE(why.find("No such file or directory"), std::string::npos) << why;
    EXPECT_EQ(session->state()->exported, "");
    EXPECT_EQ(files(), 1) << "the scene alone";
    session->send(RemoveObjects{{ObjectId{1}, ObjectId{2}, ObjectId{3}}});
    EXPECT_EQ(exported({path("a.glb"), {}, {}, {}}), "Export: there is nothing to export");
    LiveOptions options;
    options.make_solver = make;
    session = std::make_unique<LiveSession>(nullptr, options);
    EXPECT_EQ(exported({path("a.glb"), {}, {}, {}}), "Export: there is no simulation");
}

TEST_F(LiveExport, FramesGoOnMeanwhileAndTheEndWaitsForTheFile)
{
    begin(ball_and_blocks, false);
    const long frames = session->state()->frame.number;
    EXPECT_EQ(exported({path("a.obj"), {}, {}, {}}), "");
    for (int i = 0; i < 10000 && session->state()->frame.number < frames + 3; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_GE(session->state()->frame.number, frames + 3);
    EXPECT_EQ(session->state()->failure, "");
    for (int i = 0; i < 20; ++i) session->send(Export{path("b.obj"), {}, {}, {}});
    session->send(Export{path("c.obj"), {}, {}, {}});
    session->wait_for_commands();
    const auto state = session->state();
    EXPECT_TRUE(state->refused == 0 ||
                state->refusal == "Export: the exports before it are not written yet")
        << state->refusal;
    session.reset();
    EXPECT_EQ(read_text(path("b.obj"), 1 << 28), read_text(path("a.obj"), 1 << 28));
}

TEST_F(LiveExport, SplatsAreWrittenInTheFrameOfTheFile)
{
    write_splats(path("pot.ply"), glazed_pot(2000));
    begin(pots);
    ASSERT_TRUE(session->state()->splats);
    const std::size_t count = session->state()->splats->count();
    EXPECT_EQ(exported({path("all.ply"), {}, {}, {}}), "");
    const SplatCloud all = read_splats(path("all.ply")).cloud;
    EXPECT_EQ(all.count(), count);
    EXPECT_EQ(exported({path("jug.spz"), {}, {}, named("jug")}), "");
    const SplatCloud jug = read_splats(path("jug.spz")).cloud;
    EXPECT_EQ(jug.count(), count / 2);
    const Vec3<double> middle =
        0.5 * cast<double>(box_around(jug.centre).low + box_around(jug.centre).high);
    EXPECT_NEAR(middle.x, 0.7, 0.02);
    EXPECT_NEAR(middle.y, -0.5, 0.06) << "axes right, down, forward";
    EXPECT_NEAR(middle.z, -0.5, 0.02);
    EXPECT_EQ(exported({path("jug.splat"), {}, LengthUnit::millimetre, named("jug")}), "");
    const SplatCloud large = read_splats(path("jug.splat")).cloud;
    EXPECT_NEAR(extents(box_around(large.centre)).x, 1e3 * extents(box_around(jug.centre)).x, 1);
    session->send(SetFlags{object("pot"), {}, true});
    EXPECT_EQ(exported({path("shown.ply"), {}, {}, {}}), "");
    EXPECT_EQ(read_splats(path("shown.ply")).cloud.count(), count / 2);
    EXPECT_EQ(exported({path("clay.stl"), {}, {}, named("jug")}), "");
    EXPECT_GT(read_mesh(path("clay.stl"))[0].triangles.size(), 100u);
}

}  // namespace
}  // namespace knead
