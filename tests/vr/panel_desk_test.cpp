// What the panel's commands do to a live session, and what it shows of that.
#include "host/vr/panel_desk.h"

#include <gtest/gtest.h>

#include "host/scene/presets.h"
#include "host/session/backend.h"
#include "host/ui/session_line.h"
#include "host/vr/headset_notices.h"

namespace knead {
namespace {

TEST(PanelSliders, are_even_in_the_ratio)
{
    EXPECT_NEAR(value_of(0.5f, 10, 1000), 100, 1e-9);
    for (const float share : {0.0f, 0.3f, 1.0f})
        EXPECT_NEAR(share_of(value_of(share, 1e3, 1e7), 1e3, 1e7), share, 1e-6);
    EXPECT_EQ(share_of(0, 1, 10), 0);
    EXPECT_EQ(share_of(1e9, 1, 10), 1);
}

// While clay is carried against a wall each frame is refused.
TEST(HeadsetNotices, tell_a_refusal_once_and_show_it_for_some_seconds_after_the_last)
{
    std::vector<std::string> messages;
    HeadsetNotices notices([&](const std::string& text) { messages.push_back(text); });
    LiveState state{};
    notices.follow(state, 0);
    EXPECT_EQ(notices.at(0), "");
    for (int k = 0; k < 90; ++k) {
        state.refused = k + 1;
        state.refusal = "clay at (" + std::to_string(k) + ", 0, 0) m would lie behind a wall";
        notices.follow(state, k / 90.0);
    }
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_EQ(messages[0], "refused: clay at (0, 0, 0) m would lie behind a wall");
    EXPECT_EQ(notices.at(1), "clay would lie behind a wall");
    EXPECT_EQ(notices.at(5.9), "clay would lie behind a wall");
    EXPECT_EQ(notices.at(6), "");
    notices.follow(state, 7);
    EXPECT_EQ(notices.at(7), "") << "nothing new was refused";
    ++state.refused, state.refusal = "there is no object 3";
    notices.follow(state, 8);
    EXPECT_EQ(notices.at(8), "there is no object 3");
    EXPECT_EQ(messages.size(), 2u);
}

// A live session that is stepped, with little clay.
class PanelDeskTest : public testing::Test {
  protected:
    const std::vector<std::string> settings{"domain.cells=16", "surface.nodes=16"};
    LiveSession live{load_live_scene("scenes/squeeze.json", settings), [] {
                         LiveOptions options;
                         options.stepped = true, options.recorded = false;
                         options.make_solver = [](const auto& s) {
                             return make_solver(s, parse_device("cpu"));
                         };
                         return options;
                     }()};
    PanelDesk desk{"scenes/squeeze.json", settings};
    HeadsetHands hands{(live.wait_for_commands(), live.state()->hands)};

    void act(PanelAct what, int step = 0, float value = -1)
    {
        desk.apply({what, step, value}, *live.state(), live, hands);
        live.wait_for_commands();
        EXPECT_EQ(live.state()->refusal, "");
    }
    const SceneObject* ball() { return live.state()->document->find(ObjectId{1}); }
    static double lowest(const LiveState& state)  // of the clay [m]
    {
        double low = 1e30;
        for (const Mesh& mesh : *meshes_of(state))
            for (const Vec3<float>& v : mesh.vertices) low = std::min(low, double(v.y));
        return low;
    }
    SimulationConfig config()
    {
        SimulationConfig found;
        live.inspect_solver([&](const Simulator& solver) { found = solver.editable()->config(); });
        return found;
    }
};

TEST_F(PanelDeskTest, changes_materials_gravity_and_tools)
{
    const SimulationConfig before = config();
    act(PanelAct::gravity);
    EXPECT_EQ(length(config().gravity), 0);
    EXPECT_FALSE(desk.view(*live.state(), hands).gravity);
    act(PanelAct::gravity);
    EXPECT_EQ(config().gravity.y, before.gravity.y);

    act(PanelAct::stiffness, 0, 0.5f);
    EXPECT_NEAR(stated(config().materials[0]).young, 1e5, 1);
    EXPECT_NEAR(config().materials[0].lambda / config().materials[0].mu,
                before.materials[0].lambda / before.materials[0].mu, 1e-9)
        << "Poisson's ratio stays";
    act(PanelAct::yield, 0, 0);
    EXPECT_NEAR(config().materials[0].yield, 10, 1e-6);
    const std::string first = desk.view(*live.state(), hands).material;
    act(PanelAct::material, 1);
    EXPECT_NE(desk.view(*live.state(), hands).material, first);
    act(PanelAct::material, -1);
    EXPECT_NEAR(config().materials[0].mu, preset("clay").mu, 1e-6);

    act(PanelAct::right_tool, -1);
    EXPECT_EQ(hands.options().held[right], "scissors");
    EXPECT_EQ(live.state()->hands.held[right], "scissors");
    act(PanelAct::right_tool, 1);
    EXPECT_EQ(hands.options().held[right], "");
}

// Clay that is put behind a wall stays where it is; the simulation goes on.
TEST_F(PanelDeskTest, knows_a_refusal_from_an_end)
{
    const Vec3<double> behind = ball()->pose.p + Vec3<double>{0.9, 0, 0};
    live.send(PlaceObject{ObjectId{1}, behind, {}});
    live.wait_for_commands();
    const auto refused = live.state();
    EXPECT_EQ(refused->refused, 1);
    EXPECT_NE(refused->refusal.find("between the walls"), std::string::npos) << refused->refusal;
    EXPECT_LT(length(ball()->pose.p - (behind - Vec3<double>{0.9, 0, 0})), 1e-12);
    EXPECT_EQ(refused->failure, "");
    EXPECT_EQ(desk.view(*refused, hands).failure, "");
    live.advance_to(0.05);
    EXPECT_GT(live.state()->frame.number, refused->frame.number);
}

TEST_F(PanelDeskTest, shows_no_gravity_in_a_scene_that_has_none_and_can_give_it_some)
{
    EXPECT_TRUE(desk.view(*live.state(), hands).gravity);
    std::vector<std::string> without = settings;
    without.push_back("gravity=[0,0,0]");
    live.send(Open{"scenes/squeeze.json", without, {}});
    live.wait_for_commands();
    EXPECT_FALSE(desk.view(*live.state(), hands).gravity);
    EXPECT_EQ(length(live.state()->document->scene->gravity), 0);
    EXPECT_EQ(length(config().gravity), 0);
    act(PanelAct::gravity);
    EXPECT_TRUE(desk.view(*live.state(), hands).gravity);
    EXPECT_NEAR(config().gravity.y, -9.81, 1e-6);
    act(PanelAct::gravity);
    EXPECT_EQ(length(config().gravity), 0);
}

// The clay does not hear of its surface: the same frame goes on.
TEST_F(PanelDeskTest, makes_the_surface_finer_while_the_clay_stays)
{
    live.advance_to(0.1);
    const auto before = live.state();
    const int nodes = desk.view(*before, hands).surface;
    act(PanelAct::surface, 1);
    const auto after = live.state();
    EXPECT_EQ(desk.view(*after, hands).surface, nodes + 16);
    EXPECT_EQ(after->history, before->history);
    EXPECT_EQ(after->frame.number, before->frame.number);
    ASSERT_FALSE(after->meshes->empty());
    EXPECT_GT((*after->meshes)[0].triangles.size(), 2 * (*before->meshes)[0].triangles.size());
    EXPECT_NEAR(volume((*after->meshes)[0]), volume((*before->meshes)[0]),
                0.1 * volume((*before->meshes)[0]));
    for (int i = 0; i < 4; ++i) act(PanelAct::surface, -1);
    EXPECT_EQ(desk.view(*live.state(), hands).surface, 16) << "no coarser";
    EXPECT_EQ(live.state()->refused, 0);
    live.send(SetSurface{4000});
    live.wait_for_commands();
    EXPECT_EQ(live.state()->refused, 1);
}

TEST_F(PanelDeskTest, begins_anew_by_reset_cells_and_scene)
{
    const int before = live.state()->history;
    act(PanelAct::gravity);
    act(PanelAct::reset);
    EXPECT_EQ(live.state()->history, before + 1);
    EXPECT_TRUE(desk.view(*live.state(), hands).gravity) << "that of the scene";
    EXPECT_EQ(desk.view(*live.state(), hands).material, "clay");
    const int nodes = desk.view(*live.state(), hands).nodes;
    act(PanelAct::cells, 1);
    EXPECT_GT(desk.view(*live.state(), hands).nodes, nodes);
    act(PanelAct::scene, 1);
    EXPECT_NE(desk.view(*live.state(), hands).scene, "squeeze");
    EXPECT_EQ(live.state()->failure, "");
    act(PanelAct::scene, -1);
    EXPECT_EQ(desk.view(*live.state(), hands).scene, "squeeze");
}

TEST_F(PanelDeskTest, takes_back_a_command_and_shows_what_is_not_available)
{
    const PanelView before = desk.view(*live.state(), hands);
    EXPECT_EQ(before.no_undo, "there is nothing to undo");
    EXPECT_EQ(before.no_redo, "there is nothing to redo");
    EXPECT_NE(before.no_save, "") << "this session has no log";
    act(PanelAct::gravity);
    EXPECT_EQ(desk.view(*live.state(), hands).no_undo, "");
    act(PanelAct::undo);
    EXPECT_LT(config().gravity.y, 0);
    EXPECT_TRUE(desk.view(*live.state(), hands).gravity);
    EXPECT_EQ(desk.view(*live.state(), hands).no_redo, "");
    act(PanelAct::redo);
    EXPECT_EQ(length(config().gravity), 0);
    desk.apply({PanelAct::redo}, *live.state(), live, hands);
    live.wait_for_commands();
    HeadsetNotices notices([](const std::string&) {});
    notices.follow(*live.state(), 1);
    EXPECT_EQ(notices.at(1), "Redo: there is nothing to redo");
}

TEST(HeadsetNotices, tell_of_sessions_to_recover_and_of_a_save)
{
    std::vector<std::string> messages;
    HeadsetNotices notices([&](const std::string& text) { messages.push_back(text); });
    notices.tell(recovery_line(0), 0);
    EXPECT_TRUE(messages.empty());
    notices.tell(recovery_line(2), 0);
    EXPECT_EQ(notices.at(1), "2 sessions to recover: knead view, knead session list");
    LiveState state{};
    state.unsaved = true;
    notices.follow(state, 6);
    EXPECT_EQ(notices.at(6), "");
    state.unsaved = false, state.saved_as = "/clay.knead";
    notices.follow(state, 7);
    EXPECT_EQ(notices.at(7), "saved as /clay.knead");
    EXPECT_EQ(messages.size(), 2u);
}

// What another lattice would lose is kept; a reset makes way for it.
TEST_F(PanelDeskTest, refuses_another_lattice_while_work_would_be_lost)
{
    act(PanelAct::gravity);
    const auto before = live.state();
    desk.apply({PanelAct::cells, 1}, *before, live, hands);
    live.wait_for_commands();
    const auto after = live.state();
    EXPECT_EQ(after->history, before->history);
    EXPECT_EQ(after->refused, 1);
    EXPECT_NE(after->refusal.find("would be lost"), std::string::npos) << after->refusal;
    EXPECT_FALSE(desk.view(*after, hands).gravity) << "no part of it is lost";
    HeadsetNotices notices([](const std::string&) {});
    notices.follow(*after, 1);
    EXPECT_EQ(notices.at(1), after->refusal);
}

TEST_F(PanelDeskTest, shows_why_a_locked_object_keeps_its_material)
{
    live.send(SetFlags{ObjectId{1}, true, {}});
    live.wait_for_commands();
    const double before = config().materials[0].mu;
    const PanelView shown = desk.view(*live.state(), hands);
    desk.apply({PanelAct::stiffness, 0, 0.1f, 1}, *live.state(), live, hands);
    live.wait_for_commands();
    const auto after = live.state();
    HeadsetNotices notices([](const std::string&) {});
    notices.follow(*after, 1);
    EXPECT_NE(notices.at(1).find("\"ball\" is locked"), std::string::npos) << notices.at(1);
    EXPECT_EQ(config().materials[0].mu, before);
    EXPECT_EQ(desk.view(*after, hands).stiffness, shown.stiffness);
    EXPECT_EQ(desk.view(*after, hands).material, shown.material);
}

// Between the beginning and the end of carrying, clay goes with the palm and does not fall.
TEST_F(PanelDeskTest, clay_that_is_carried_follows_the_palm_without_gravity)
{
    SetHands away;
    away.left.present = away.right.present = false;
    live.send(away);
    double time = 0;
    const auto hold = [&](double seconds, Vec3<float> at) {
        for (const double end = time + seconds; time < end;) {
            time += 1.0 / 90;
            HandFrame frame;
            frame.time = time;
            frame.hand[right] = open_hand(right);
            for (auto& joint : frame.hand[right].joints) joint.p = joint.p + at;
            frame.hand[right].tracked = true;
            frame.hand[right].valid.fill(true);
            live.push(frame);
            live.advance_to(time);
        }
    };
    hold(0.5, {0, 0, 0});
    const Vec3<double> before = ball()->pose.p;
    const double gravity = config().gravity.y;
    EXPECT_LT(gravity, 0);
    live.send(Carry{{ObjectId{1}}, right, true}, Origin::headset);
    hold(0.1, {0, 0, 0});
    EXPECT_EQ(length(config().gravity), 0);
    hold(0.5, {0.02f, 0.04f, 0});
    hold(1, {0.02f, 0.04f, 0});
    EXPECT_EQ(live.state()->refused, 0) << live.state()->refusal;
    const Vec3<double> wanted = live.state()->hands.zoom * Vec3<double>{0.02, 0.04, 0};
    EXPECT_LT(length(ball()->pose.p - before - wanted), 0.02 * length(wanted));
    const double low = lowest(*live.state());
    EXPECT_GT(low, 0.046875 + 0.9 * wanted.y) << "it does not fall";
    live.send(Carry{{ObjectId{1}}, right, false}, Origin::headset);
    hold(0.2, {0, 0, 0});
    EXPECT_EQ(config().gravity.y, gravity);
    EXPECT_LT(lowest(*live.state()), low - 0.05) << "it falls";
    EXPECT_LT(length(ball()->pose.p - before - wanted), 0.02 * length(wanted));
}

}  // namespace
}  // namespace knead
