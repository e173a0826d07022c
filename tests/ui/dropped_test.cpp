// What becomes of a file that is dropped into the window.
#include "host/ui/dropped.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "host/base/outputs.h"
#include "host/files/splat_file.h"
#include "host/scene/new_scene.h"
#include "host/session/backend.h"
#include "host/session/session_file.h"
#include "tests/folder.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

class Dropped : public InFolder {
  protected:
    std::string make(const std::string& name, const std::string& bytes)
    {
        write_whole(path(name), bytes);
        return path(name);
    }
    static std::string shipped(const std::string& name)
    {
        return fs::absolute("scenes/" + name).string();
    }
    static LiveState table()
    {
        static const auto scene = load_live_scene(new_scene_name);
        LiveState state;
        state.scene = scene;
        state.document = std::make_shared<const Document>(document_of(scene->scene));
        state.situation.document = state.document.get();
        return state;
    }
    static std::string refused(const std::string& file, const LiveState& state = table())
    {
        const auto found = command_for_file(file, state);
        const Refusal* refusal = std::get_if<Refusal>(&found);
        return refusal ? refusal->text() : "";
    }
    template <class C>
    static C command(const std::string& file, const LiveState& state = table())
    {
        const auto found = command_for_file(file, state);
        if (const Refusal* refusal = std::get_if<Refusal>(&found)) {
            ADD_FAILURE() << refusal->text();
            return {};
        }
        return std::get<C>(std::get<Command>(found));
    }
};

TEST_F(Dropped, ScenesAndSessionsAreOpenedWhateverTheirNames)
{
    EXPECT_EQ(command<Open>("scenes/squeeze.json").file, shipped("squeeze.json"));
    EXPECT_EQ(command<Open>(shipped("two-lumps.knead")).file, shipped("two-lumps.knead"));
    fs::copy(shipped("squeeze.json"), path("a scene"));
    fs::copy(shipped("two-lumps.knead"), path("session.json"));
    EXPECT_EQ(command<Open>(path("a scene")).file, path("a scene"));
    EXPECT_EQ(command<Open>(path("session.json")).file, path("session.json"));
    EXPECT_EQ(dropped_kind(path("session.json")), DroppedKind::session);
    EXPECT_EQ(dropped_kind(make("x", "// a comment\n" + new_scene())), DroppedKind::scene);
}

TEST_F(Dropped, SplatsBecomeAnObjectOnFreeGround)
{
    LiveState state = table();
    const AddObject first = command<AddObject>(shipped("pot.spz"), state);
    const WallOptions& walls = state.document->scene->walls;
    const double size = first.object.source.splats.size;
    EXPECT_EQ(first.object.name, "pot");
    EXPECT_EQ(first.object.source.splats.file, shipped("pot.spz"));
    EXPECT_EQ(first.object.source.shape, ShapeKind::splats);
    EXPECT_EQ(first.object.id.value, 0u);
    EXPECT_GT(first.object.pose.p.y - size / 2, walls.min.y);
    EXPECT_LT(first.object.pose.p.y - size / 2, walls.min.y + 0.01);
    // The next ones are beside it, of other categories.
    Document document = *state.document;
    SceneObject there = first.object;
    there.id = {1};
    document.objects = {std::make_shared<const SceneObject>(there)};
    there.source.splats.size = size / 4;
    state.document = std::make_shared<const Document>(document);
    fs::copy(shipped("pot.spz"), path("other.json"));
    const AddObject second = command<AddObject>(path("other.json"), state);
    EXPECT_EQ(second.object.category, 1);
    EXPECT_GT(length(second.object.pose.p - first.object.pose.p), 0);
    for (const double x : {second.object.pose.p.x, second.object.pose.p.z}) {
        EXPECT_GE(x - size / 2, walls.min.x - 1e-12);
        EXPECT_LE(x + size / 2, walls.max.x + 1e-12);
    }
}

// A mesh is not read until the session adds it.
TEST_F(Dropped, MeshesBecomeAnObjectWhereOthersAppear)
{
    const std::string mesh =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
             {"cube.obj", text}, {"mesh.ply", mesh}, {"a.stl", "solid a"}}) {
        const AddObject added = command<AddObject>(make(name, bytes));
        const ObjectSource& source = added.object.source;
        EXPECT_EQ(source.shape, ShapeKind::mesh);
        EXPECT_EQ(source.mesh.file, path(name));
        EXPECT_EQ(source.mesh.up, name == "a.stl" ? UpAxis::z : UpAxis::y);
        EXPECT_EQ(added.object.name, fs::path(name).stem());
        EXPECT_GT(source.mesh.size, 0.05);
        EXPECT_TRUE(adds_object(path(name)));
        const WallOptions& walls = table().document->scene->walls;
        EXPECT_GE(added.object.pose.p.y - source.mesh.size / 2, walls.min.y);
    }
    EXPECT_FALSE(adds_object("scenes/squeeze.json"));
    EXPECT_FALSE(adds_object(path("gone.obj")));
}

TEST_F(Dropped, WhatCannotBecomeClayIsRefusedWithTheReason)
{
    for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
             {"notes.txt", "no scene"},
             {"empty", ""},
             {"other.json", "{\"schema\": \"knead.report/1\"}"},
             {"broken.json", "{\"schema\": "},
             {"list.json", "[1, 2]"},
             {"points.csv", "x,y,z\n1,2,3\n"}})
        EXPECT_NE(refused(make(name, bytes)).find(name + ": expected a scene"), std::string::npos)
            << refused(path(name));
    EXPECT_NE(refused("scenes/squeeze.hands").find("expected a scene"), std::string::npos);
    EXPECT_NE(refused(folder.string()).find("is a folder"), std::string::npos);
    EXPECT_NE(refused(path("gone.json")).find("gone.json"), std::string::npos);
}

TEST_F(Dropped, SplatsAreRefusedWhereNoClayCanBeAdded)
{
    LiveState state = table();
    state.situation.editable = false;
    EXPECT_NE(refused(shipped("pot.spz"), state), "");
    EXPECT_NE(refused(shipped("pot.spz"), LiveState{}), "");
    EXPECT_EQ(refused(shipped("squeeze.json"), state), "");
}

// On an empty table, and beside a pot that is there.
TEST_F(Dropped, ALiveSessionTakesTheSplats)
{
    LiveOptions options;
    options.make_solver = [](const knead::Setup& setup) { return cpu_solver(setup); };
    options.stepped = true, options.recorded = false;
    LiveSession session(load_live_scene(new_scene_name, {"domain.cells=16", "surface.nodes=32"}),
                        options);
    session.wait_for_commands();
    for (std::size_t i = 1; i <= 2; ++i) {
        const auto before = session.state();
        session.send(command<AddObject>(shipped("pot.spz"), *before));
        session.wait_for_commands();
        const auto state = session.state();
        EXPECT_EQ(state->refusal, "");
        ASSERT_EQ(state->document->objects.size(), i);
        ASSERT_TRUE(state->splats);
        EXPECT_EQ(splat_categories(*state->document).size(), i) << "not drawn as a surface";
        EXPECT_GT(state->splats->count(), i * 20000);
    }
    session.advance_to(0.1);
    EXPECT_EQ(session.state()->failure, "");
    EXPECT_GT(session.digest().particles, 100);
    const auto bad = [&](const std::string& name, const std::string& bytes) {
        session.send(command<AddObject>(make(name, bytes), *session.state()));
        session.wait_for_commands();
        return session.state()->refusal;
    };
    EXPECT_NE(bad("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").find("expected a closed"),
              std::string::npos);
    session.send(command<AddObject>(make("bad.splat", std::string(33, 'x')), *session.state()));
    session.wait_for_commands();
    EXPECT_NE(session.state()->refusal.find("bad.splat"), std::string::npos)
        << session.state()->refusal;
}

}  // namespace
}  // namespace knead
