// Index fingers as the pointer of the panels: what presses, what does not, and how a press ends.
#include "host/vr/finger_pointer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace knead {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// A panel of 0.4 m and 800 pixels, turned and shifted; and a strip that only the right hand
// touches.
TouchPanel main_panel()
{
    TouchPanel panel;
    panel.id = 7;
    panel.pose = {turn_about(Vec3<float>{0, 1, 0}, -0.6f), {0.3f, 0.1f, 0.2f}};
    panel.width = panel.height = 0.4f;
    panel.picture_width = panel.picture_height = 800;
    return panel;
}
TouchPanel strip()
{
    TouchPanel panel;
    panel.id = 8;
    panel.pose = {turn_about(Vec3<float>{1, 0, 0}, -0.5f), {-0.3f, 0, 0.1f}};
    panel.width = 0.075f, panel.height = 0.035f;
    panel.y = 800, panel.picture_width = 150, panel.picture_height = 70;
    panel.touched_by[left] = false;
    return panel;
}

// TwoFingers that move in the frames of panels, at 90 frames a second.
struct TwoFingers {
    FingerPointer pointer;
    std::vector<TouchPanel> panels{main_panel(), strip()};
    FingerTip tips[side_count];
    double time = 0;
    PanelPointer newest;

    // Places a fingertip on a panel: x right, y up from its centre, skin `before` it [m].
    void put(Side side, float x, float y, float before, int panel = 0)
    {
        const Joint<float> pose = panels[std::size_t(panel)].pose;
        tips[side] = {pose.p + rotate(pose.q, {x, y, before + FingerPointer::finger}), true};
    }
    const PanelPointer& frame() { return newest = pointer.frame(time += 1.0 / 90, panels, tips); }
    const PanelPointer& at(float x, float y, float before, Side side = right, int panel = 0)
    {
        put(side, x, y, before, panel);
        return frame();
    }
};

TEST(FingerPointer, gives_the_position_of_a_finger_that_hovers)
{
    TwoFingers f;
    EXPECT_FALSE(f.at(0, 0, 0.06f).inside) << "too far in front";
    const PanelPointer& middle = f.at(0, 0, 0.04f);
    EXPECT_TRUE(middle.inside);
    EXPECT_FALSE(middle.down);
    EXPECT_NEAR(middle.x, 400, 0.01f);
    EXPECT_NEAR(middle.y, 400, 0.01f);
    EXPECT_NEAR(middle.distance, 0.04f, 1e-5f);
    EXPECT_EQ(middle.panel, 7);
    EXPECT_EQ(middle.side, right);
    const PanelPointer& corner = f.at(-0.1f, 0.15f, 0.03f);
    EXPECT_NEAR(corner.x, 200, 0.01f);
    EXPECT_NEAR(corner.y, 100, 0.01f);
    EXPECT_FALSE(f.at(0.21f, 0, 0.03f).inside) << "beside the panel";
    EXPECT_EQ(f.newest.x, PanelPointer::nowhere);
    EXPECT_EQ(f.newest.panel, -1);
    f.tips[right].tracked = false;
    EXPECT_FALSE(f.frame().inside);
}

TEST(FingerPointer, is_pressed_once_by_a_finger_that_comes_from_the_front)
{
    TwoFingers f;
    EXPECT_FALSE(f.at(0, 0, -0.01f).down) << "it appeared behind";
    EXPECT_FALSE(f.at(0, 0, 0.008f).down) << "and is not far enough in front";
    EXPECT_FALSE(f.at(0, 0, -0.004f).down);
    f.at(0, 0, 0.03f);
    EXPECT_FALSE(f.at(0, 0, 0.005f).down) << "not there yet";
    EXPECT_TRUE(f.at(0, 0, -0.002f).down);
    EXPECT_NEAR(f.newest.x, 400, 0.01f);
    EXPECT_TRUE(f.at(0, 0, -0.01f).down) << "still";
    EXPECT_TRUE(f.at(0, 0, 0.005f).down) << "not yet let go";
    const PanelPointer& end = f.at(0, 0, 0.02f);
    EXPECT_FALSE(end.down);
    EXPECT_FALSE(end.cancelled);
    EXPECT_TRUE(end.inside) << "a release on the panel";
    EXPECT_NEAR(end.x, 400, 0.01f);
    EXPECT_TRUE(f.at(0, 0, -0.03f).down) << "in one leap, too";
}

TEST(FingerPointer, presses_where_the_finger_crosses_the_surface)
{
    TwoFingers f;
    f.at(0, 0, 0.02f);
    EXPECT_TRUE(f.at(0.02f, 0, -0.02f).down);
    EXPECT_NEAR(f.newest.x, 420, 0.01f) << "half the way";
    EXPECT_TRUE(f.at(0.021f, 0, -0.02f).down);
    EXPECT_NEAR(f.newest.x, 442, 0.01f) << "it drags";
}

TEST(FingerPointer, does_not_drag_by_a_finger_that_trembles)
{
    TwoFingers f;
    f.at(0.1f, 0.1f, 0.02f);
    f.at(0.1f, 0.1f, -0.002f);
    const float x = f.newest.x, y = f.newest.y;
    for (const float shift : {0.003f, -0.003f, 0.001f}) {
        EXPECT_TRUE(f.at(0.1f + shift, 0.1f, -0.003f).down);
        EXPECT_EQ(f.newest.x, x);
        EXPECT_EQ(f.newest.y, y);
    }
    EXPECT_TRUE(f.at(0.12f, 0.1f, -0.003f).down);
    EXPECT_NEAR(f.newest.x, x + 40, 0.01f);
    EXPECT_TRUE(f.at(0.1f, 0.1f, -0.003f).down);
    EXPECT_NEAR(f.newest.x, x, 0.01f) << "and then follows";
    f.at(0.1f, 0.09f, 0.02f);
    EXPECT_FALSE(f.newest.down);
    EXPECT_NEAR(f.newest.y, y, 0.01f) << "a finger that leaves does not drag";
}

TEST(FingerPointer, is_let_go_without_a_release_by_a_finger_that_is_lost)
{
    for (const int kind : {0, 1, 2, 3, 4}) {
        TwoFingers f;
        f.at(0, 0, 0.02f);
        ASSERT_TRUE(f.at(0, 0, -0.005f).down);
        if (kind == 0) f.tips[right].tracked = false;
        if (kind == 1) f.tips[right].at.y = nan;
        if (kind == 2) f.put(right, 0, 0, -0.065f);
        if (kind == 3) f.put(right, 0.09f, 0, -0.005f);  // jumps on the panel
        if (kind == 4) f.panels.erase(f.panels.begin());
        const PanelPointer end = f.frame();
        EXPECT_TRUE(end.cancelled) << kind;
        EXPECT_FALSE(end.down || end.inside) << kind;
        EXPECT_EQ(end.x, PanelPointer::nowhere) << kind;
        f.panels = {main_panel()};
        EXPECT_FALSE(f.frame().cancelled) << "once";
        EXPECT_FALSE(f.at(0, 0, -0.005f).down) << kind << ": it begins anew";
        EXPECT_FALSE(f.at(0, 0, -0.006f).down) << kind;
        f.at(0, 0, 0.02f);
        f.at(0, 0, 0.02f);
        EXPECT_TRUE(f.at(0, 0, -0.005f).down) << kind;
    }
}

TEST(FingerPointer, is_not_pressed_by_a_finger_that_was_lost_in_front)
{
    TwoFingers f;
    f.at(0, 0, 0.02f);
    f.tips[right].tracked = false;
    f.frame();
    EXPECT_FALSE(f.at(0, 0, -0.005f).down);
    f.at(0, 0, 0.02f);
    EXPECT_FALSE(f.at(0, 0, -0.2f).down) << "far behind is elsewhere";
    EXPECT_FALSE(f.at(0, 0, -0.005f).down);
    f.at(0, 0, 0.02f);
    f.at(nan, 0, 0);
    EXPECT_FALSE(f.at(0, 0, -0.005f).down);
    f.at(0, 0.15f, 0.02f);
    EXPECT_FALSE(f.at(0, -0.15f, -0.01f).down) << "it jumped";
}

TEST(FingerPointer, is_not_pressed_from_behind_nor_from_the_side)
{
    TwoFingers f;
    for (float before = -0.05f; before < 0.04f; before += 0.004f)
        EXPECT_FALSE(f.at(0, 0, before).down) << "through it from behind";
    // Around its edge, and then to its middle from the side.
    f.at(0.25f, 0, 0.02f);
    EXPECT_FALSE(f.at(0.25f, 0, -0.01f).down) << "beside it";
    for (float x = 0.25f; x > 0; x -= 0.02f) EXPECT_FALSE(f.at(x, 0, -0.01f).down) << x;
    EXPECT_FALSE(f.at(0, 0, 0.005f).down);
    EXPECT_FALSE(f.at(0, 0, -0.01f).down);
    // Across the plane beside it, in one frame.
    f.at(0.22f, 0, 0.013f);
    f.at(0.215f, 0, 0.001f);
    EXPECT_FALSE(f.at(0.18f, 0, -0.02f).down);
    // Along its front, and then onto it.
    f.at(0.25f, 0, 0.02f);
    f.at(0.25f, 0, 0.005f);
    for (float x = 0.25f; x > 0.1f; x -= 0.02f)
        EXPECT_FALSE(f.at(x, 0, 0.005f).down) << "it did not touch";
    EXPECT_TRUE(f.at(0.1f, 0, -0.001f).down) << "but now it does";
}

TEST(FingerPointer, slides_off_with_some_slack)
{
    TwoFingers f;
    f.at(0.19f, 0, 0.02f);
    ASSERT_TRUE(f.at(0.19f, 0, -0.005f).down);
    const PanelPointer& beside = f.at(0.208f, 0, -0.005f);
    EXPECT_TRUE(beside.down && beside.inside);
    EXPECT_LT(beside.x, 800);
    EXPECT_GE(beside.x, 799);
    EXPECT_TRUE(f.at(0.19f, 0, -0.005f).down);
    EXPECT_TRUE(f.at(0.212f, 0, -0.005f).cancelled);
    EXPECT_FALSE(f.at(0.19f, 0, -0.005f).down) << "it must come from the front again";
    f.at(0.205f, 0, 0.02f);
    EXPECT_FALSE(f.at(0.205f, 0, -0.005f).down) << "the slack is for what was on it";
}

TEST(FingerPointer, belongs_to_one_finger_at_a_time)
{
    TwoFingers f;
    f.put(left, -0.1f, 0, 0.03f);
    f.at(0.1f, 0, 0.04f);
    EXPECT_EQ(f.newest.side, left) << "the nearer";
    f.put(left, -0.1f, 0, 0.045f);
    EXPECT_EQ(f.frame().side, left) << "which keeps it";
    f.at(0.1f, 0, 0.01f);
    EXPECT_EQ(f.newest.side, left);
    EXPECT_TRUE(f.at(0.1f, 0, -0.002f).down);
    EXPECT_EQ(f.newest.side, right) << "a press takes it";
    EXPECT_NEAR(f.newest.x, 600, 0.01f);
    f.put(left, -0.1f, 0, 0.02f);
    f.frame();
    f.put(left, -0.1f, 0, -0.01f);
    EXPECT_TRUE(f.frame().down);
    EXPECT_EQ(f.newest.side, right);
    EXPECT_NEAR(f.newest.x, 600, 0.01f);
    EXPECT_FALSE(f.at(0.1f, 0, 0.02f).down);
    EXPECT_FALSE(f.frame().down) << "the other came while it was taken";
    f.put(left, -0.1f, 0, 0.02f);
    f.frame();
    f.put(left, -0.1f, 0, -0.01f);
    EXPECT_TRUE(f.frame().down);
    EXPECT_EQ(f.newest.side, left);
    // Both at once: the one that hovered.
    for (const Side owner : {left, right}) {
        TwoFingers both;
        both.put(owner, 0, owner == left ? -0.1f : 0.1f, 0.02f);
        both.frame();
        both.put(owner == left ? right : left, 0, 0, 0.018f);
        both.frame();
        both.put(left, 0, -0.1f, -0.01f), both.put(right, 0, 0.1f, -0.01f);
        EXPECT_EQ(both.frame().down, true);
        EXPECT_EQ(both.newest.side, owner);
    }
}

TEST(FingerPointer, of_a_strip_on_a_palm_is_that_of_the_other_hand)
{
    TwoFingers f;
    f.at(0, 0, 0.03f, left, 1);
    EXPECT_FALSE(f.newest.inside);
    EXPECT_FALSE(f.at(0, 0, -0.005f, left, 1).down);
    f.tips[left].tracked = false;
    const PanelPointer& over = f.at(0.01f, 0, 0.03f, right, 1);
    EXPECT_TRUE(over.inside);
    EXPECT_EQ(over.panel, 8);
    EXPECT_NEAR(over.x, 95, 0.01f);
    EXPECT_NEAR(over.y, 835, 0.01f);
    EXPECT_TRUE(f.at(0.01f, 0, -0.005f, right, 1).down);
    // The palm moves, and the finger with it.
    f.panels[1].pose.p = f.panels[1].pose.p + Vec3<float>{0.01f, 0.02f, 0};
    EXPECT_TRUE(f.at(0.01f, 0, -0.005f, right, 1).down);
    EXPECT_NEAR(f.newest.x, 95, 0.01f);
    // The palm turns away: it is not shown any more.
    f.panels.pop_back();
    EXPECT_TRUE(f.frame().cancelled);
}

TEST(FingerPointer, is_not_pressed_by_a_panel_that_appears_around_a_finger_or_jumps_across_it)
{
    TwoFingers f;
    f.at(0, 0, 0.02f);
    Joint<float>& pose = f.panels[0].pose;
    pose.p = pose.p + rotate(pose.q, Vec3<float>{0, 0, 0.08f});
    EXPECT_FALSE(f.frame().down) << "recentred";
    const TouchPanel moved = f.panels[0];
    f.panels.erase(f.panels.begin());
    f.frame();
    f.panels.insert(f.panels.begin(), moved);
    f.put(right, 0, 0, -0.005f);
    EXPECT_FALSE(f.frame().down);
    EXPECT_FALSE(f.frame().down);
}

// Whatever fingers do: a press begins inside, each ends once, and while there is none nothing is
// down.
TEST(FingerPointer, has_presses_that_begin_and_end)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> share(-1, 1);
    TwoFingers f;
    bool down = false;
    int begun = 0, released = 0, cancelled = 0;
    Vec3<float> at[side_count]{};
    for (int k = 0; k < 20000; ++k) {
        for (const Side side : {left, right}) {
            Vec3<float>& a = at[side];
            a = a + 0.03f * Vec3<float>{share(random), share(random), share(random)};
            a = {clamp(a.x, -0.22f, 0.22f), clamp(a.y, -0.22f, 0.22f), clamp(a.z, -0.03f, 0.05f)};
            f.put(side, a.x, a.y, a.z);
            f.tips[side].tracked = share(random) > -0.98f;
            if (share(random) > 0.999f) f.tips[side].at.x = nan;
        }
        const PanelPointer p = f.frame();
        EXPECT_FALSE(p.down && (!p.inside || p.cancelled));
        EXPECT_FALSE(p.cancelled && !down);
        EXPECT_EQ(p.inside, p.x != PanelPointer::nowhere);
        if (p.inside) {
            EXPECT_TRUE(p.x >= 0 && p.x < 800 && p.y >= 0 && p.y < 800);
            EXPECT_LE(p.distance, FingerPointer::near);
        }
        begun += p.down && !down;
        released += down && !p.down && !p.cancelled;
        cancelled += p.cancelled;
        down = p.down;
    }
    EXPECT_EQ(begun, released + cancelled + int(down));
    EXPECT_GT(released, 100);
    EXPECT_GT(cancelled, 100);
}

}  // namespace
}  // namespace knead
