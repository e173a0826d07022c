// The panel in the headset: where it is, what a finger asks for, and what that does.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "host/scene/presets.h"
#include "host/session/device.h"
#include "host/session/panel_desk.h"

namespace knead {
namespace {

Vec3<float> tip_on(const PanelItem& item, float before, float along = 0.5f)
{
    const float x = item.rect.x + along * item.rect.width - 0.5f * HeadsetPanel::width;
    const float y = 0.5f * HeadsetPanel::height - item.rect.y - 0.5f * item.rect.height;
    return {HeadsetPanel::pixel * x, HeadsetPanel::pixel * y, before + HeadsetPanel::finger};
}

const PanelItem& item_of(const HeadsetPanel& panel, PanelAct act, int step = 0)
{
    for (const PanelItem& item : panel.items())
        if (item.command.act == act && item.command.step == step) return item;
    throw std::logic_error("no such item");
}

TEST(Panel, has_items_that_a_finger_can_tell_apart)
{
    const HeadsetPanel panel;
    const PanelRect whole{0, 0, HeadsetPanel::width, HeadsetPanel::height};
    for (const PanelItem& a : panel.items()) {
        EXPECT_TRUE(whole.holds(a.rect.x, a.rect.y));
        EXPECT_LE(a.rect.x + a.rect.width, whole.width);
        EXPECT_LE(a.rect.y + a.rect.height, whole.height);
        EXPECT_GE(a.rect.height * HeadsetPanel::pixel, 0.02f) << "two centimetres";
        EXPECT_GE(a.rect.width * HeadsetPanel::pixel, 0.02f);
        for (const PanelItem& b : panel.items()) {
            if (&a == &b) continue;
            const bool apart =
                a.rect.x + a.rect.width <= b.rect.x || b.rect.x + b.rect.width <= a.rect.x ||
                a.rect.y + a.rect.height <= b.rect.y || b.rect.y + b.rect.height <= a.rect.y;
            EXPECT_TRUE(apart);
        }
    }
}

TEST(Panel, is_within_reach_faces_the_eyes_and_has_no_letter_below_a_degree)
{
    const Workplace usual;
    const Vec3<float> head = -cast<float>(usual.at);
    for (const Side side : {left, right}) {
        const Joint<float> pose = HeadsetPanel::pose(usual, side);
        const Vec3<float> to_head = head - pose.p;
        EXPECT_LT(length(to_head), 0.65f);
        EXPECT_GT(length(to_head), 0.3f);
        EXPECT_GT(dot(rotate(pose.q, Vec3<float>{0, 0, 1}), to_head), 0.999f * length(to_head));
        EXPECT_GT(rotate(pose.q, Vec3<float>{0, 1, 0}).y, 0.7f) << "it is read upright";
        const double seen = std::atan(letter_height * HeadsetPanel::pixel / length(to_head));
        EXPECT_GE(seen * 180 / std::numbers::pi, 1) << "degrees";
        EXPECT_EQ(pose.p.x < 0, side == left);
    }
}

TEST(Panel, is_pressed_once_by_a_finger_that_comes_from_before)
{
    HeadsetPanel panel;
    const PanelItem& pause = item_of(panel, PanelAct::pause);
    EXPECT_FALSE(panel.poke(right, tip_on(pause, -0.01f), true)) << "it appeared behind";
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.05f), true));
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.005f), true));
    const auto pressed = panel.poke(right, tip_on(pause, -0.002f), true);
    ASSERT_TRUE(pressed);
    EXPECT_EQ(pressed->act, PanelAct::pause);
    EXPECT_FALSE(panel.poke(right, tip_on(pause, -0.01f), true)) << "it is still pressed";
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.005f), true)) << "not yet let go";
    EXPECT_FALSE(panel.poke(right, tip_on(pause, -0.002f), true));
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.02f), true));
    EXPECT_TRUE(panel.poke(right, tip_on(pause, -0.03f), true)) << "in one leap, too";
}

TEST(Panel, is_not_pressed_by_a_hand_that_is_lost_nor_beside_its_items)
{
    HeadsetPanel panel;
    const PanelItem& quit = item_of(panel, PanelAct::quit);
    panel.poke(left, tip_on(quit, 0.05f), true);
    panel.poke(left, tip_on(quit, 0.05f), false);
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.01f), true));
    panel.poke(left, {0.5f, 0.5f, 0.05f}, true);
    EXPECT_FALSE(panel.poke(left, {0.5f, 0.5f, -0.01f}, true));
    panel.poke(left, tip_on(quit, 0.05f), true);
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.2f), true)) << "far behind is elsewhere";
    panel.poke(left, tip_on(quit, 0.05f), true);
    EXPECT_FALSE(panel.poke(left, {std::nanf(""), 0, 0}, true));
}

TEST(Panel, has_sliders_that_follow_the_finger_in_steps_that_matter)
{
    HeadsetPanel panel;
    const PanelItem& slider = item_of(panel, PanelAct::stiffness);
    panel.poke(right, tip_on(slider, 0.05f), true);
    const auto begun = panel.poke(right, tip_on(slider, -0.005f, 0.25f), true);
    ASSERT_TRUE(begun);
    EXPECT_NEAR(begun->value, 0.25f, 1e-4f);
    EXPECT_FALSE(panel.poke(right, tip_on(slider, -0.005f, 0.252f), true));
    const auto moved = panel.poke(right, tip_on(slider, -0.005f, 0.75f), true);
    ASSERT_TRUE(moved);
    EXPECT_NEAR(moved->value, 0.75f, 1e-4f);
    EXPECT_FLOAT_EQ(panel.poke(right, tip_on(slider, -0.005f, 1.3f), true)->value, 1);
}

TEST(Panel, shows_what_it_is_told)
{
    const HeadsetPanel panel;
    const auto drawn = [&](const PanelView& view, const FrameFigures& figures) {
        PanelCanvas canvas(HeadsetPanel::width, HeadsetPanel::height, 1);
        panel.draw(canvas, view, figures);
        return std::string(canvas.rgba().begin(), canvas.rgba().end());
    };
    PanelView view;
    view.scene = "squeeze", view.material = "clay";
    FrameFigures figures;
    const auto before = drawn(view, figures);
    EXPECT_EQ(before, drawn(view, figures));
    std::set<std::string> all{before};
    view.paused = true, all.insert(drawn(view, figures));
    view.gravity = false, all.insert(drawn(view, figures));
    view.stiffness = 0.6f, all.insert(drawn(view, figures));
    view.left_tool = "knife", all.insert(drawn(view, figures));
    view.trouble = "a particle was lost", all.insert(drawn(view, figures));
    FrameParts late;
    late.period = 0.01, late.draw = 0.02;
    figures.add(late), all.insert(drawn(view, figures));
    EXPECT_EQ(all.size(), 7u);
}

TEST(PanelText, writes_capitals_and_boxes_for_what_it_does_not_know)
{
    const auto ink = [](const std::string& words) {
        PanelCanvas canvas(40, 10, 2);
        canvas.text(1, 1, words, {255, 255, 255});
        int count = 0;
        for (std::size_t i = 3; i < canvas.rgba().size(); i += 4) count += canvas.rgba()[i] > 0;
        return count;
    };
    std::set<int> seen;
    for (const char c : std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.,:-+/%()<>_"))
        EXPECT_GT(ink(std::string(1, c)), 0) << c;
    EXPECT_EQ(ink("a"), ink("A"));
    EXPECT_EQ(ink(" "), 0);
    EXPECT_EQ(ink("\x01"), ink("\xff"));
    EXPECT_GT(ink("\xff"), 0);
    EXPECT_GT(ink(std::string(100, 'W')), 0) << "cut at the edge";
}

TEST(Panel, puts_corners_where_the_eye_sees_them)
{
    EyeView view;
    view.left = -1, view.right = 0.5f, view.down = -0.8f, view.up = 0.6f, view.near = 0.1f;
    view.position = {1, 2, 3};
    view.width = view.height = 100;
    // Points on the frustum's corners, two metres away, are the corners of the picture.
    for (const float x : {view.left, view.right})
        for (const float y : {view.down, view.up}) {
            const auto clip = clip_of(view, view.position + Vec3<float>{2 * x, 2 * y, -2});
            EXPECT_NEAR(clip[0] / clip[3], x == view.left ? -1 : 1, 1e-5);
            EXPECT_NEAR(clip[1] / clip[3], y == view.down ? -1 : 1, 1e-5);
            EXPECT_NEAR(clip[2] / clip[3], view.near / 2, 1e-6) << "near over distance";
        }
}

TEST(PanelSliders, are_even_in_the_ratio)
{
    EXPECT_NEAR(value_of(0.5f, 10, 1000), 100, 1e-9);
    for (const float share : {0.0f, 0.3f, 1.0f})
        EXPECT_NEAR(share_of(value_of(share, 1e3, 1e7), 1e3, 1e7), share, 1e-6);
    EXPECT_EQ(share_of(0, 1, 10), 0);
    EXPECT_EQ(share_of(1e9, 1, 10), 1);
}

// A live session that is stepped, with little clay.
using Rules = Setup;  // GoogleTest has another meaning for the word
class PanelDeskTest : public testing::Test {
  protected:
    const std::vector<std::string> settings{"domain.cells=16", "surface.nodes=16"};
    LiveSession live{load_live_scene("scenes/squeeze.json", settings), [] {
                         LiveRule rule;
                         rule.stepped = true, rule.recorded = false;
                         rule.make = [](const Rules& s) {
                             return make_solver(s, parse_device("cpu"));
                         };
                         return rule;
                     }()};
    PanelDesk desk{"scenes/squeeze.json", settings};
    HeadsetHands hands{(live.settle(), live.state()->hands)};

    void act(PanelAct what, int step = 0, float value = -1)
    {
        desk.apply({what, step, value}, *live.state(), live, hands);
        live.settle();
        EXPECT_EQ(live.state()->refusal, "");
    }
    Rules rules()
    {
        Rules found;
        live.ask([&](const Solver& solver) { found = solver.rules(); });
        return found;
    }
};

TEST_F(PanelDeskTest, changes_materials_gravity_and_tools)
{
    const Rules before = rules();
    act(PanelAct::gravity);
    EXPECT_EQ(length(rules().gravity), 0);
    EXPECT_FALSE(desk.view(*live.state(), hands).gravity);
    act(PanelAct::gravity);
    EXPECT_EQ(rules().gravity.y, before.gravity.y);

    act(PanelAct::stiffness, 0, 0.5f);
    EXPECT_NEAR(stated(rules().materials[0]).young, 1e5, 1);
    EXPECT_NEAR(rules().materials[0].lambda / rules().materials[0].mu,
                before.materials[0].lambda / before.materials[0].mu, 1e-9)
        << "Poisson's ratio stays";
    act(PanelAct::yield, 0, 0);
    EXPECT_NEAR(rules().materials[0].yield, 10, 1e-6);
    const std::string first = desk.view(*live.state(), hands).material;
    act(PanelAct::material, 1);
    EXPECT_NE(desk.view(*live.state(), hands).material, first);
    act(PanelAct::material, -1);
    EXPECT_NEAR(rules().materials[0].mu, preset("clay").mu, 1e-6);

    act(PanelAct::right_tool, -1);
    EXPECT_EQ(hands.rule().held[right], "scissors");
    EXPECT_EQ(live.state()->hands.held[right], "scissors");
    act(PanelAct::right_tool, 1);
    EXPECT_EQ(hands.rule().held[right], "");
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
    live.set_surface(4000);
    live.settle();
    EXPECT_EQ(live.state()->refused, 1);
}

TEST_F(PanelDeskTest, begins_anew_by_reset_cells_and_scene)
{
    const int before = live.state()->history;
    act(PanelAct::gravity);
    act(PanelAct::reset);
    EXPECT_EQ(live.state()->history, before + 1);
    EXPECT_TRUE(desk.view(*live.state(), hands).gravity) << "that of the scene";
    const int nodes = desk.view(*live.state(), hands).nodes;
    act(PanelAct::cells, 1);
    EXPECT_GT(desk.view(*live.state(), hands).nodes, nodes);
    act(PanelAct::scene, 1);
    EXPECT_NE(desk.view(*live.state(), hands).scene, "squeeze");
    EXPECT_EQ(live.state()->trouble, "");
    act(PanelAct::scene, -1);
    EXPECT_EQ(desk.view(*live.state(), hands).scene, "squeeze");
}

}  // namespace
}  // namespace knead
