// The empty table: opened, filled, saved, opened again and recovered, as a scene of a file is.
#include "host/scene/new_scene.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "host/scene/presets.h"
#include "host/session/backend.h"
#include "host/ui/session_line.h"
#include "tests/folder.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

class NewScene : public InFolder {
  protected:
    NewScene()
    {
        const char* given = ::getenv("XDG_STATE_HOME");
        if (given) before = given;
        ::setenv("XDG_STATE_HOME", path("state").c_str(), 1);
        options.make_solver = [](const knead::Setup& setup) { return cpu_solver(setup); };
        options.stepped = true, options.recorded = false, options.protects = true;
    }
    ~NewScene() override
    {
        if (before.empty())
            ::unsetenv("XDG_STATE_HOME");
        else
            ::setenv("XDG_STATE_HOME", before.c_str(), 1);
    }
    static std::shared_ptr<const LiveScene> small()
    {
        return load_live_scene(new_scene_name, {"domain.cells=16", "surface.nodes=32"});
    }
    static AddObject ball()
    {
        SceneObject o;
        o.name = "ball", o.material = material_spec("soft-clay");
        o.pose.p = {0.2, 0.15, 0.2};
        o.source.size = {0.15, 0.15, 0.15};
        return {o};
    }
    // Sends it, waits, and expects that it was applied.
    static std::shared_ptr<const LiveState> apply(LiveSession& session, const Command& command)
    {
        const int refused = session.state()->refused;
        session.send(command);
        session.wait_for_commands();
        const auto state = session.state();
        EXPECT_EQ(state->refused, refused) << state->refusal;
        EXPECT_EQ(state->failure, "");
        return state;
    }
    LiveOptions options;

  private:
    std::string before;
};

TEST_F(NewScene, HasAFloorAndNoObjects)
{
    const Scene scene = parse_scene(new_scene(), new_scene_name);
    EXPECT_TRUE(scene.objects.empty());
    EXPECT_FALSE(scene.has_hands);
    EXPECT_EQ(scene.name, "new");
    EXPECT_LT(scene.setup.gravity.y, 0);
    EXPECT_EQ(scene_text(new_scene_name), new_scene());
    EXPECT_EQ(scene_text("scenes/squeeze.json").find("knead.scene/1") != std::string::npos, true);
    EXPECT_THROW(scene_text("./new"), InputError) << "a file of this name";
    EXPECT_FALSE(is_session(new_scene_name));
}

TEST_F(NewScene, TakesClayAndLetsItGo)
{
    LiveSession session(small(), options);
    session.advance_to(0.1);
    EXPECT_EQ(session.digest().particles, 0);
    EXPECT_TRUE(meshes_of(*session.state())->empty());
    auto state = apply(session, ball());
    EXPECT_EQ(state->document->objects.size(), 1u);
    session.advance_to(0.3);
    EXPECT_GT(session.digest().particles, 100);
    EXPECT_FALSE(meshes_of(*session.state())->empty());
    state = apply(session, Undo{});
    EXPECT_TRUE(state->document->objects.empty());
    EXPECT_EQ(session.digest().particles, 0);
    apply(session, Redo{});
    apply(session, Reset{});
    EXPECT_EQ(session.digest().particles, 0);
    state = apply(session, SetLattice{24});
    EXPECT_EQ(state->document->scene->cells, 24) << "reads the scene again";
    EXPECT_EQ(state->scene->scene.path, new_scene_name);
}

TEST_F(NewScene, IsOpenedByACommandSavedAndOpenedAgain)
{
    const std::string saved = path("mine.knead");
    std::string hash;
    {
        LiveSession session(
            load_live_scene("scenes/squeeze.json", {"domain.cells=16", "surface.nodes=32"}),
            options);
        auto state = apply(session, Open{new_scene_name, {"surface.nodes=32"}, 16});
        EXPECT_EQ(state->document->scene->cells, 16);
        EXPECT_TRUE(state->document->objects.empty());
        EXPECT_EQ(fs::path(save_command(*state).file).stem().string().substr(0, 3), "new");
        apply(session, Save{saved, {}});  // empty
        apply(session, ball());
        session.advance_to(0.2);
        hash = session.digest().hash;
        apply(session, Save{saved, {}});
    }
    const SessionFile file(saved);
    EXPECT_EQ(file.scene().path, new_scene_name);
    EXPECT_EQ(file.scene().text, new_scene());
    options.session = saved;
    LiveSession again(nullptr, options);
    again.wait_until_open();
    EXPECT_EQ(again.digest().hash, hash);
    EXPECT_EQ(again.state()->document->objects.size(), 1u);
    EXPECT_EQ(again.state()->scene->scene.path, new_scene_name);
    apply(again, Undo{});
    EXPECT_EQ(again.digest().particles, 0);
}

TEST_F(NewScene, IsRecoveredFromItsLog)
{
    {
        LiveSession session(small(), options);
        apply(session, ball());
        session.advance_to(0.2);
    }
    const std::vector<Recoverable> all = recoverable_sessions();
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].scene, new_scene_name);
    options.session = all[0].file;
    LiveSession again(nullptr, options);
    again.wait_until_open();
    EXPECT_EQ(again.state()->document->objects.size(), 1u);
    EXPECT_GT(again.digest().particles, 100);
}

}  // namespace
}  // namespace knead
