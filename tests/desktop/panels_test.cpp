// Between panels and session: materials as sliders and back, scenes by name, what is asked for.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "host/base/errors.h"
#include "host/desktop/view_panels.h"
#include "host/desktop/view_still.h"
#include "host/session/backend.h"
#include "host/ui/panel_commands.h"
#include "host/ui/scene_list.h"
#include "host/ui/session_line.h"
#include "tests/folder.h"

namespace knead {
namespace {

TEST(ViewPanels, EveryPresetIsStatedAsItWasMade)
{
    for (const std::string& name : preset_names()) {
        const Material<double> wanted = preset(name);
        MaterialSpec spec = stated(wanted);
        spec = with_sliders(spec, sliders_of(spec));
        const Material<double> again = made(spec);
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
    LiveOptions options;
    options.make_solver = [](const auto& setup) { return cpu_solver(setup); };
    options.stepped = true;
    const std::vector<std::string> small{"domain.cells=16", "surface.nodes=32"};
    LiveSession session(load_live_scene("scenes/squeeze.json", small), options);
    session.wait_for_commands();
    ViewPanels panels("scenes/squeeze.json");
    panels.follow(*session.state());
    ASSERT_EQ(panels.model.objects.size(), 1u);
    EXPECT_EQ(panels.model.scenes.at(std::size_t(panels.model.scene)), "squeeze");
    EXPECT_TRUE(panels.model.recorded);
    EXPECT_DOUBLE_EQ(panels.model.gravity, 9.81);
    PanelRequests requests;
    requests.gravity = 3, requests.tool = 5, requests.material = true;
    for (Slider& s : panels.model.objects[0].sliders)
        if (s.name == "Stiffness") s.value = 2e5;
    panels.apply(requests, session);
    EXPECT_DOUBLE_EQ(panels.model.gravity, 3) << "before it is answered";
    session.inspect_solver([](const Simulator& s) {
        EXPECT_EQ(s.editable()->config().gravity.y, -3);
        EXPECT_NEAR(s.editable()->config().materials[0].mu, 2e5 / 2.6, 1);
        EXPECT_TRUE(s.editable()->config().tools[1].blade);
    });
    session.send(Pause{true});
    session.wait_for_commands();
    panels.follow(*session.state());
    EXPECT_TRUE(panels.model.paused);
    EXPECT_THROW(panels.load(1000, session), std::out_of_range);
    requests = {};
    requests.preset = true;
    panels.model.objects[0].preset = 5;
    panels.apply(requests, session);
    EXPECT_EQ(panels.model.objects[0].sliders.size(), sliders_of(material_specs().at(5)).size());
    session.inspect_solver(
        [](const Simulator& s) { EXPECT_EQ(s.editable()->config().materials[0].yield, 0); });
    EXPECT_EQ(session.state()->refused, 0) << session.state()->refusal;
    session.send(Open{"scenes/nothing.json", {}, {}});
    session.wait_for_commands();
    panels.follow(*session.state());
    EXPECT_NE(panels.model.notice.find("nothing.json"), std::string::npos);
}

// Its document has no hands, so that the window's are a change that makes their tools.
TEST(ViewPanels, AHandIsGivenToASceneThatHasNone)
{
    LiveOptions options;
    options.make_solver = [](const auto& setup) { return cpu_solver(setup); };
    options.stepped = true;
    LiveSession session(
        load_live_scene("scenes/materials.json", {"domain.cells=16", "surface.nodes=32"}), options);
    session.wait_for_commands();
    const auto state = session.state();
    const auto tools = [&] {
        std::size_t count = 0;
        session.inspect_solver(
            [&](const Simulator& s) { count = s.editable()->config().tools.size(); });
        return count;
    };
    EXPECT_EQ(tools(), 0u);
    session.send(hands_command(settings_of(state->hands, state->scene->scene.origin)));
    EXPECT_EQ(tools(), 2u);
    EXPECT_EQ(session.state()->refusal, "");
    EXPECT_TRUE(session.state()->document->hands->present[right]);
}

class RefusalTest : public testing::Test {
  protected:
    RefusalTest()
    {
        session.wait_for_commands();
        panels.follow(*session.state());
    }
    static LiveOptions options()
    {
        LiveOptions by;
        by.make_solver = [](const auto& setup) { return cpu_solver(setup); };
        by.stepped = true;
        return by;
    }
    Slider& slider(const std::string& name)
    {
        for (Slider& s : panels.model.objects.at(0).sliders)
            if (s.name == name) return s;
        throw std::out_of_range(name);
    }
    // Whether the session did it.
    bool apply(const PanelRequests& requests)
    {
        const int before = session.state()->refused;
        panels.apply(requests, session);
        session.wait_for_commands();
        panels.follow(*session.state());
        return session.state()->refused == before;
    }
    double young()
    {
        double found = 0;
        session.inspect_solver(
            [&](const Simulator& s) { found = stated(s.editable()->config().materials[0]).young; });
        return found;
    }

    const std::vector<std::string> small{"domain.cells=16", "surface.nodes=32"};
    LiveSession session{load_live_scene("scenes/squeeze.json", small), options()};
    ViewPanels panels{"scenes/squeeze.json"};
};

// What is typed into a slider may lie beyond its ends, but not beyond what can be.
TEST_F(RefusalTest, ATypedNumberThatCannotBeLeavesTheControl)
{
    const double before = slider("Poisson").value;
    PanelRequests requests;
    requests.material = true;
    slider("Poisson").value = 2;
    EXPECT_FALSE(apply(requests));
    EXPECT_DOUBLE_EQ(slider("Poisson").value, before);
    EXPECT_NE(panels.model.notice.find("poisson: expected 0 to 0.499, found 2"), std::string::npos)
        << panels.model.notice;
    EXPECT_EQ(panels.model.notice, session.state()->refusal);
    slider("Stiffness").value = 1e15;
    EXPECT_FALSE(apply(requests));
    EXPECT_NEAR(slider("Stiffness").value, young(), 1e-6);
    slider("Stiffness").value = 2e7;
    EXPECT_TRUE(apply(requests)) << "beyond the slider, but a material that can be";
    EXPECT_NEAR(young(), 2e7, 1);
    EXPECT_EQ(slider("Stiffness").high, 2e7);
    requests = {};
    requests.gravity = 1e5;
    panels.model.gravity = 1e5;
    EXPECT_FALSE(apply(requests));
    EXPECT_DOUBLE_EQ(panels.model.gravity, 9.81);
    EXPECT_NE(panels.model.notice.find("at most 1000 m/s^2"), std::string::npos)
        << panels.model.notice;
    EXPECT_EQ(session.state()->failure, "");
}

TEST_F(RefusalTest, ALockedObjectKeepsItsMaterialAndTheNoticeSaysWhy)
{
    session.send(SetFlags{ObjectId{1}, true, {}});
    const double before = young();
    panels.follow(*session.state());
    PanelRequests requests;
    requests.material = true;
    slider("Stiffness").value = 2e5;
    EXPECT_FALSE(apply(requests));
    EXPECT_NE(panels.model.notice.find("\"ball\" is locked"), std::string::npos)
        << panels.model.notice;
    EXPECT_NEAR(young(), before, 1e-6);
    EXPECT_DOUBLE_EQ(slider("Stiffness").value, before);
    requests = {};
    requests.preset = true;
    const int preset = panels.model.objects[0].preset;
    panels.model.objects[0].preset = (preset + 1) % int(panels.model.presets.size());
    EXPECT_FALSE(apply(requests));
    EXPECT_EQ(panels.model.objects[0].preset, preset);
    EXPECT_DOUBLE_EQ(slider("Stiffness").value, before);
}

// A slider that is dragged is ahead of the simulation, and does not go back meanwhile.
TEST_F(RefusalTest, AControlIsNotSetBackBeforeItsCommandIsAnswered)
{
    const auto before = session.state();
    PanelRequests requests;
    requests.material = true, requests.drag = 1;
    slider("Stiffness").value = 2e5;
    const double high = slider("Stiffness").high;
    panels.apply(requests, session);
    panels.follow(*before);
    EXPECT_DOUBLE_EQ(slider("Stiffness").value, 2e5);
    session.wait_for_commands();
    panels.follow(*session.state());
    EXPECT_DOUBLE_EQ(slider("Stiffness").value, 2e5);
    EXPECT_EQ(slider("Stiffness").high, high);
    EXPECT_NEAR(young(), 2e5, 1e-3);
    const std::vector<AppliedCommand> applied = session.take_applied();
    ASSERT_FALSE(applied.empty());
    EXPECT_EQ(applied.back().issued.drag, 1u);
    EXPECT_EQ(applied.back().issued.origin, Origin::window);
}

// A frame of a million substeps would hang: what the panel cannot know, the session refuses.
TEST_F(RefusalTest, AMaterialThatNeedsTooManySubstepsIsRefusedAndTheControlShowsWhatHolds)
{
    const double before = young();
    PanelRequests requests;
    requests.material = true;
    slider("Stiffness").value = 1e12;
    slider("Density").value = 1;
    EXPECT_FALSE(apply(requests));
    EXPECT_EQ(session.state()->refused, 1);
    EXPECT_NE(session.state()->refusal.find("most_substeps"), std::string::npos);
    EXPECT_EQ(panels.model.notice, session.state()->refusal);
    EXPECT_EQ(session.state()->failure, "");
    EXPECT_NEAR(young(), before, 1e-6);
    EXPECT_NEAR(slider("Stiffness").value, before, 1e-6);
}

// --cells and --set go with every scene that is chosen; what one does not take is said.
TEST_F(RefusalTest, SettingsGoWithASceneThatIsChosenAsFarAsItTakesThem)
{
    const std::vector<std::string> settings{"surface.nodes=24", "objects.1.material.young=2e5",
                                            "gravity=[0,-3,0]"};
    ViewPanels choosing("scenes/squeeze.json", settings, 16);
    choosing.follow(*session.state());
    const auto at = std::find(choosing.model.scenes.begin(), choosing.model.scenes.end(), "poke");
    ASSERT_NE(at, choosing.model.scenes.end());
    choosing.load(int(at - choosing.model.scenes.begin()), session);
    session.wait_for_commands();
    const auto state = session.state();
    ASSERT_NE(state->scene->scene.path.find("poke"), std::string::npos) << state->refusal;
    const auto& setup = state->scene->scene.setup;
    const std::vector<std::string> kept{"surface.nodes=24", "gravity=[0,-3,0]", "domain.cells=16"};
    EXPECT_EQ(state->scene->settings, kept);
    EXPECT_EQ(setup.gravity.y, -3);
    EXPECT_EQ(state->scene->scene.surface_nodes, 24);
    EXPECT_NE(state->refusal.find("objects.1.material.young=2e5"), std::string::npos);
    EXPECT_EQ(state->refusal.find("surface.nodes"), std::string::npos);
    choosing.follow(*state);
    EXPECT_EQ(choosing.model.notice, state->refusal);
    EXPECT_EQ(choosing.model.scene, int(at - choosing.model.scenes.begin()));
}

// A stepped session of little clay, with its log in a folder of its own.
class SessionPanelTest : public testing::Test {
  protected:
    SessionPanelTest() { ::setenv("XDG_STATE_HOME", folder.path().c_str(), 1); }
    ~SessionPanelTest() override { ::unsetenv("XDG_STATE_HOME"); }
    static LiveOptions options(const std::string& session = "")
    {
        LiveOptions by;
        by.make_solver = [](const auto& setup) { return cpu_solver(setup); };
        by.stepped = true, by.recorded = false, by.protects = true, by.session = session;
        return by;
    }
    static std::unique_ptr<LiveSession> begun(const std::string& session = "")
    {
        const auto scene = load_live_scene("scenes/squeeze.json", small());
        auto live =
            std::make_unique<LiveSession>(session.empty() ? scene : nullptr, options(session));
        live->wait_until_open();
        return live;
    }
    static std::vector<std::string> small() { return {"domain.cells=16", "surface.nodes=16"}; }
    // Requests what `set` sets, and shows what became of it.
    void request(LiveSession& live, const std::function<void(PanelRequests&)>& set)
    {
        panels.follow(*live.state());
        PanelRequests requests;
        set(requests);
        panels.apply(requests, live);
        live.wait_for_commands();
        panels.follow(*live.state());
    }
    static double gravity(LiveSession& live)
    {
        double found = 0;
        live.inspect_solver([&](const Simulator& s) { found = s.editable()->config().gravity.y; });
        return found;
    }
    // Waits for the log's thread.
    static bool saved(LiveSession& live)
    {
        for (int i = 0; i < 1000 && live.state()->unsaved; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        return !live.state()->unsaved;
    }

    Folder folder;
    ViewPanels panels{"scenes/squeeze.json"};
};

TEST_F(SessionPanelTest, ButtonsHaveLabelsAndReasonsOfTheTable)
{
    const auto live = begun();
    request(*live, [](PanelRequests&) {});
    EXPECT_EQ(panels.model.undo.label, "Undo");
    EXPECT_EQ(panels.model.undo.why_not, "there is nothing to undo");
    EXPECT_EQ(panels.model.redo.why_not, "there is nothing to redo");
    EXPECT_EQ(panels.model.save.label, "Save");
    EXPECT_EQ(panels.model.save.why_not, "");
    EXPECT_EQ(panels.model.session, "");
    ASSERT_EQ(panels.model.steps.size(), 1u);
    EXPECT_EQ(panels.model.steps[0].label, "Beginning");

    request(*live, [](PanelRequests& r) { r.gravity = 3; });
    EXPECT_EQ(gravity(*live), -3);
    EXPECT_EQ(panels.model.undo.why_not, "");
    request(*live, [](PanelRequests& r) { r.undo = true; });
    EXPECT_EQ(gravity(*live), -9.81);
    EXPECT_DOUBLE_EQ(panels.model.gravity, 9.81);
    EXPECT_EQ(panels.model.undo.why_not, "there is nothing to undo");
    EXPECT_EQ(panels.model.redo.why_not, "");
    EXPECT_EQ(panels.model.session, "unsaved");
    request(*live, [](PanelRequests& r) { r.redo = true; });
    EXPECT_EQ(gravity(*live), -3);
    ASSERT_EQ(panels.model.steps.size(), 2u);
    EXPECT_EQ(panels.model.steps[1].label, "Gravity");
    EXPECT_TRUE(panels.model.steps[1].current);
    request(*live, [](PanelRequests& r) { r.go_to = 0; });
    EXPECT_EQ(gravity(*live), -9.81);
    EXPECT_TRUE(panels.model.steps[0].current);
}

TEST_F(SessionPanelTest, SavesUnderTheNameOfTheLastTimeOrOneThatIsFree)
{
    const auto live = begun();
    request(*live, [](PanelRequests& r) { r.gravity = 3; });
    const std::filesystem::path before = std::filesystem::current_path();
    const LiveState unsaved = *live->state();
    std::filesystem::current_path(folder.path());
    EXPECT_EQ(save_command(unsaved).file, "squeeze.knead");
    std::ofstream("squeeze.knead") << "of another";
    EXPECT_EQ(save_command(unsaved).file, "squeeze-2.knead");
    request(*live, [](PanelRequests& r) { r.save = true; });
    EXPECT_TRUE(saved(*live));
    std::filesystem::current_path(before);
    panels.follow(*live->state());
    const std::string file = folder / "squeeze-2.knead";
    EXPECT_EQ(panels.model.session, "saved as " + file);
    EXPECT_EQ(save_command(*live->state()).file, file);
    EXPECT_TRUE(is_session(file));

    const auto again = begun(file);
    EXPECT_EQ(gravity(*again), -3);
    request(*again, [](PanelRequests& r) { r.undo = true; });
    EXPECT_EQ(gravity(*again), -9.81);
    EXPECT_EQ(again->state()->refusal, "");
}

TEST_F(SessionPanelTest, ASaveThatFailsLeavesTheSessionUnsaved)
{
    const auto live = begun();
    request(*live, [](PanelRequests& r) { r.gravity = 3; });
    live->send(Save{folder / "missing/clay.knead", {}});
    for (int i = 0; i < 1000 && live->state()->refused == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_NE(live->state()->refusal.find("clay.knead"), std::string::npos);
    EXPECT_TRUE(live->state()->unsaved);
    EXPECT_EQ(live->state()->saved_as, "");
}

TEST_F(SessionPanelTest, ALogIsRecoveredOrDiscarded)
{
    begun()->wait_for_commands();
    EXPECT_TRUE(recoverable_sessions().empty()) << "nothing was done in it";
    ClayDigest beginning, clay;
    {
        const auto live = begun();
        beginning = live->digest();
        request(*live, [](PanelRequests& r) { r.gravity = 3; });
        live->advance_to(0.2);
        live->send(Undo{}), live->send(Redo{});
        clay = live->digest();
        Image picture{64, 48, std::vector<std::uint8_t>(3 * 64 * 48, 100)};
        live->set_picture(png_bytes(picture));
        live->wait_for_commands();
    }
    const std::vector<Recoverable> found = recoverable_sessions();
    ASSERT_EQ(found.size(), 1u);
    panels.list_recoverable(found);
    ASSERT_EQ(panels.model.recoverable.size(), 1u);
    const RecoverRow row = panels.model.recoverable[0];
    EXPECT_EQ(row.name, "squeeze");
    EXPECT_NE(row.text.find("1 step"), std::string::npos) << row.text;
    ASSERT_TRUE(row.picture);
    EXPECT_EQ(row.picture->width, 64);

    const auto live = begun();
    panels.recover(row.file, *live);
    live->wait_for_commands();
    panels.follow(*live->state());
    EXPECT_EQ(live->state()->refusal, "");
    EXPECT_EQ(live->state()->log.file, row.file) << "it goes on being protected";
    EXPECT_TRUE(panels.model.recoverable.empty()) << "it is open";
    EXPECT_EQ(gravity(*live), -3);
    EXPECT_TRUE(live->state()->unsaved);
    EXPECT_EQ(live->digest().hash, clay.hash) << "that of the step";
    EXPECT_NE(live->digest().hash, beginning.hash);

    // In use: neither opened a second time nor deleted.
    EXPECT_THROW(LiveSession(nullptr, options(row.file)).wait_until_open(), OutputError);
    EXPECT_THROW(load_session_scene(row.file), OutputError);
    panels.list_recoverable(found);
    panels.discard_log(row.file);
    EXPECT_EQ(panels.model.recoverable.size(), 1u);
    EXPECT_NE(panels.model.notice, "");
}

TEST_F(SessionPanelTest, ADiscardedLogIsDeleted)
{
    {
        const auto live = begun();
        request(*live, [](PanelRequests& r) { r.gravity = 3; });
    }
    const std::vector<Recoverable> found = recoverable_sessions();
    ASSERT_EQ(found.size(), 1u);
    panels.list_recoverable(found);
    panels.discard_log(found[0].file);
    EXPECT_TRUE(panels.model.recoverable.empty());
    EXPECT_EQ(panels.model.notice, "");
    EXPECT_FALSE(std::filesystem::exists(found[0].file));
    EXPECT_TRUE(recoverable_sessions().empty());
}

TEST_F(SessionPanelTest, ADamagedSessionIsRefusedByItsKind)
{
    std::ofstream(folder / "bad.knead") << "no session, but long enough to be read";
    EXPECT_FALSE(is_session(folder / "bad.knead"));
    EXPECT_THROW(LiveSession(nullptr, options(folder / "bad.knead")).wait_until_open(), InputError);
}

TEST(StillPicture, IsDrawnWholeOnceWhenNothingMoves)
{
    const auto ball = [](float shift) {
        std::vector<Mesh> meshes(1);
        meshes[0].vertices = {{shift, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        meshes[0].triangles = {{0, 1, 2}};
        return std::make_shared<const std::vector<Mesh>>(meshes);
    };
    PictureContent content;
    content.view.width = 64, content.view.height = 48;
    content.within = 0.001f;
    content.meshes = ball(0);
    StillPicture still;
    still.update(content, 1);
    EXPECT_FALSE(still.due(1.1));
    EXPECT_TRUE(still.due(1 + StillPicture::rest));
    still.drawn_full();
    EXPECT_TRUE(still.full_resolution());
    content.meshes = ball(0.0005f);
    still.update(content, 2);
    EXPECT_TRUE(still.full_resolution()) << "clay that trembles by less than is seen";
    content.meshes = ball(0.01f);
    still.update(content, 3);
    EXPECT_FALSE(still.full_resolution() || still.due(3.1));
    still.drawn_full();
    content.view.position.x = 0.1f;
    still.update(content, 4);
    EXPECT_FALSE(still.full_resolution()) << "the camera moved";
    still.drawn_full();
    content.hands = {1, 2, 3};
    still.update(content, 5);
    EXPECT_FALSE(still.full_resolution()) << "a hand came";
    still.drawn_full();
    content.hidden = {0};
    still.update(content, 5.5);
    EXPECT_FALSE(still.full_resolution()) << "an object was hidden";
    still.drawn_full();
    still.forget();
    still.update(content, 6);
    EXPECT_FALSE(still.full_resolution()) << "what was drawn is lost";
}

}  // namespace
}  // namespace knead
