// The panel in the headset: where it is, what it shows, and what a finger asks for.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "host/vr/headset_notices.h"
#include "host/vr/headset_panel.h"

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
    EXPECT_FALSE(panel.poke(right, tip_on(pause, -0.01f), true, 0)) << "it appeared behind";
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.05f), true, 0));
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.005f), true, 0));
    const auto pressed = panel.poke(right, tip_on(pause, -0.002f), true, 0);
    ASSERT_TRUE(pressed);
    EXPECT_EQ(pressed->act, PanelAct::pause);
    EXPECT_FALSE(panel.poke(right, tip_on(pause, -0.01f), true, 0)) << "it is still pressed";
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.005f), true, 0)) << "not yet let go";
    EXPECT_FALSE(panel.poke(right, tip_on(pause, -0.002f), true, 0));
    EXPECT_FALSE(panel.poke(right, tip_on(pause, 0.02f), true, 0));
    EXPECT_TRUE(panel.poke(right, tip_on(pause, -0.03f), true, 0)) << "in one leap, too";
}

// A finger that comes to an item, stays in it for so many seconds, and goes; what it asked for.
int presses(HeadsetPanel& panel, const PanelItem& item, double seconds, Vec3<float> slide = {})
{
    int triggered = 0;
    double time = 10;
    const auto at = [&](float before, Vec3<float> aside) {
        triggered += bool(panel.poke(right, tip_on(item, before) + aside, true, time += 1.0 / 90));
    };
    at(0.03f, {});
    const int frames = int(std::lround(90 * seconds));
    for (int k = 0; k < frames; ++k) at(-0.005f, (float(k) / float(frames)) * slide);
    at(0.03f, {});
    return triggered;
}

TEST(Panel, is_asked_for_what_loses_work_by_a_finger_that_stays_for_a_second)
{
    HeadsetPanel panel;
    for (const PanelAct act : {PanelAct::reset, PanelAct::quit, PanelAct::scene, PanelAct::cells}) {
        const bool arrow = act == PanelAct::scene || act == PanelAct::cells;
        const PanelItem& item = item_of(panel, act, arrow ? 1 : 0);
        EXPECT_TRUE(item.held);
        EXPECT_EQ(presses(panel, item, 0.1), 0) << "a hand on its way to the clay";
        EXPECT_EQ(presses(panel, item, 0.9), 0);
        EXPECT_EQ(presses(panel, item, 1.1), 1);
        EXPECT_EQ(presses(panel, item, 5), 1) << "once";
        EXPECT_EQ(presses(panel, item, 1.1, {0, 0.1f, 0}), 0) << "it slid off";
        EXPECT_EQ(presses(panel, item, 1.1, {0, 0.008f, 0}), 1) << "it trembled";
    }
    EXPECT_EQ(presses(panel, item_of(panel, PanelAct::pause), 0.1), 1) << "nothing is lost by it";
    // One that is lost meanwhile begins again.
    const PanelItem& quit = item_of(panel, PanelAct::quit);
    panel.poke(left, tip_on(quit, 0.05f), true, 0);
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.005f), true, 0.1));
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.005f), false, 0.5));
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.005f), true, 1.5));
}

std::string drawn_by(const HeadsetPanel& panel, const PanelView& view,
                     const FrameFigures& figures = {})
{
    PanelCanvas canvas(HeadsetPanel::width, HeadsetPanel::height, 1);
    panel.draw(canvas, view, figures);
    return std::string(canvas.rgba().begin(), canvas.rgba().end());
}

TEST(Panel, shows_how_long_an_item_has_been_held_and_that_it_is_to_be)
{
    HeadsetPanel panel;
    const PanelItem& quit = item_of(panel, PanelAct::quit);
    const auto poke = [&](float before, double time) {
        panel.poke(right, tip_on(quit, before), true, time);
    };
    poke(0.05f, 0);
    const std::string before = drawn_by(panel, {});
    EXPECT_FALSE(panel.moves());
    std::set<std::string> all{before};
    for (const double time : {0.1, 0.3, 0.6}) {
        poke(-0.005f, time);
        EXPECT_TRUE(panel.moves());
        all.insert(drawn_by(panel, {}));
    }
    EXPECT_EQ(all.size(), 4u);
    poke(0.05f, 0.7);
    EXPECT_TRUE(panel.moves());
    EXPECT_NE(drawn_by(panel, {}), before) << "that it is to be held";
    poke(0.05f, 4);
    EXPECT_FALSE(panel.moves());
    EXPECT_EQ(drawn_by(panel, {}), before);
}

TEST(Panel, shows_a_refusal_for_some_seconds_and_an_end_for_good)
{
    const std::string refusal = "clay at (0.912000, 0.500000, 0.300000) m would lie behind a wall";
    EXPECT_EQ(short_refusal(refusal), "clay would lie behind a wall");
    EXPECT_EQ(short_refusal("there is no object 3"), "there is no object 3");
    Notice notice;
    EXPECT_EQ(notice.at(0), "");
    notice.show(short_refusal(refusal), 10);
    EXPECT_EQ(notice.at(10.1), "clay would lie behind a wall");
    EXPECT_EQ(notice.at(10 + Notice::lasting), "");

    const HeadsetPanel panel;
    PanelView refused, ended;
    refused.notice = ended.failure = "clay would lie behind a wall";
    const std::string plain = drawn_by(panel, {});
    EXPECT_NE(drawn_by(panel, refused), plain);
    EXPECT_NE(drawn_by(panel, ended), drawn_by(panel, refused));
    const auto red = [](const std::string& rgba) {  // in the uppermost row
        int count = 0;
        for (std::size_t i = 0; i < 4 * 16 * HeadsetPanel::width; i += 4)
            count += std::uint8_t(rgba[i]) > 2 * std::uint8_t(rgba[i + 1]);
        return count;
    };
    EXPECT_EQ(red(drawn_by(panel, refused)), 0);
    EXPECT_GT(red(drawn_by(panel, ended)), 20);
}

TEST(Panel, is_not_pressed_by_a_hand_that_is_lost_nor_beside_its_items)
{
    HeadsetPanel panel;
    const PanelItem& quit = item_of(panel, PanelAct::quit);
    panel.poke(left, tip_on(quit, 0.05f), true, 0);
    panel.poke(left, tip_on(quit, 0.05f), false, 0);
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.01f), true, 0));
    panel.poke(left, {0.5f, 0.5f, 0.05f}, true, 0);
    EXPECT_FALSE(panel.poke(left, {0.5f, 0.5f, -0.01f}, true, 0));
    panel.poke(left, tip_on(quit, 0.05f), true, 0);
    EXPECT_FALSE(panel.poke(left, tip_on(quit, -0.2f), true, 0)) << "far behind is elsewhere";
    panel.poke(left, tip_on(quit, 0.05f), true, 0);
    EXPECT_FALSE(panel.poke(left, {std::nanf(""), 0, 0}, true, 0));
}

TEST(Panel, has_sliders_that_follow_the_finger_in_steps_that_matter)
{
    HeadsetPanel panel;
    const PanelItem& slider = item_of(panel, PanelAct::stiffness);
    panel.poke(right, tip_on(slider, 0.05f), true, 0);
    const auto begun = panel.poke(right, tip_on(slider, -0.005f, 0.25f), true, 0);
    ASSERT_TRUE(begun);
    EXPECT_NEAR(begun->value, 0.25f, 1e-4f);
    EXPECT_FALSE(panel.poke(right, tip_on(slider, -0.005f, 0.252f), true, 0));
    const auto moved = panel.poke(right, tip_on(slider, -0.005f, 0.75f), true, 0);
    ASSERT_TRUE(moved);
    EXPECT_NEAR(moved->value, 0.75f, 1e-4f);
    EXPECT_FLOAT_EQ(panel.poke(right, tip_on(slider, -0.005f, 1.3f), true, 0)->value, 1);
}

TEST(Panel, numbers_the_drags_of_its_sliders)
{
    HeadsetPanel panel;
    const PanelItem& slider = item_of(panel, PanelAct::yield);
    const auto drag = [&](Side side, float along) {
        const auto pressed = panel.poke(side, tip_on(slider, -0.005f, along), true, 0);
        return pressed ? pressed->drag : 0;
    };
    panel.poke(right, tip_on(slider, 0.05f), true, 0);
    const unsigned first = drag(right, 0.2f);
    EXPECT_GT(first, 0u);
    EXPECT_EQ(drag(right, 0.4f), first);
    panel.poke(left, tip_on(slider, 0.05f), true, 0);
    const unsigned other = drag(left, 0.3f);
    EXPECT_GT(other, first);
    EXPECT_EQ(drag(right, 0.6f), first) << "it is still held";
    panel.poke(right, tip_on(slider, 0.05f), true, 0);
    EXPECT_GT(drag(right, 0.6f), other) << "let go and pressed again";
    const PanelItem& pause = item_of(panel, PanelAct::pause);
    panel.poke(right, tip_on(pause, 0.05f), true, 0);
    EXPECT_EQ(panel.poke(right, tip_on(pause, -0.005f), true, 0)->drag, 0u) << "no slider";
}

TEST(Panel, shows_what_it_is_told)
{
    const HeadsetPanel panel;
    const auto drawn = [&](const PanelView& view, const FrameFigures& figures) {
        return drawn_by(panel, view, figures);
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
    view.failure = "a particle was lost", all.insert(drawn(view, figures));
    FrameParts late;
    late.period = 0.01, late.draw = 0.02;
    figures.add(late), all.insert(drawn(view, figures));
    EXPECT_EQ(all.size(), 7u);
}

TEST(Panel, greys_out_what_is_not_available)
{
    const HeadsetPanel panel;
    std::set<std::string> all{drawn_by(panel, {})};
    PanelView view;
    view.no_undo = "there is nothing to undo", all.insert(drawn_by(panel, view));
    view.no_redo = "there is nothing to redo", all.insert(drawn_by(panel, view));
    view.no_save = "this session keeps no log", all.insert(drawn_by(panel, view));
    EXPECT_EQ(all.size(), 4u);
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

}  // namespace
}  // namespace knead
