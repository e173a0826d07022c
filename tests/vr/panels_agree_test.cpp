// One script of controls, done with the mouse in the window's panel and with a finger in the
// headset's: both give equal commands.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "tests/folder.h"
#include "tests/vr/panel_drivers.h"

namespace knead {
namespace {

constexpr const char* two_objects = R"({"schema": "knead.scene/1", "name": "two",
    "domain": {"edge": 1.0, "cells": 16}, "surface": {"nodes": 16},
    "walls": {"min": [0.13, 0.13, 0.13], "max": [0.87, 0.87, 0.87]},
    "gravity": [0, -9.81, 0],
    "hands": {"zoom": 1, "at": [0.5, 0.3, 0.5]},
    "objects": [
      {"name": "ball", "shape": "sphere", "diameter": 0.2, "centre": [0.35, 0.25, 0.5],
       "material": "clay"},
      {"name": "block", "shape": "box", "size": [0.2, 0.2, 0.2], "centre": [0.65, 0.25, 0.5],
       "material": "jelly"}]})";

struct Both {
    Folder folder;
    std::string scene = [this] {
        std::ofstream(folder / "two.json") << two_objects;
        return folder / "two.json";
    }();
    PanelSession window{in_window, false, "", scene}, headset{in_headset, false, "", scene};
    MouseDriver mouse{window};
    FingerDriver finger{headset};
};

// A number of a command that a slider gave: equal to a share of its range, because the sliders of
// window and headset have different numbers of pixels.
void expect_alike(const nlohmann::json& a, const nlohmann::json& b, double within,
                  const std::string& what)
{
    ASSERT_EQ(a.type(), b.type()) << what << ": " << a << " and " << b;
    if (a.is_number_float()) {
        const double x = a, y = b;
        EXPECT_NEAR(x, y, within * std::max({1e-6, std::abs(x), std::abs(y)})) << what;
    } else if (a.is_object()) {
        ASSERT_EQ(a.size(), b.size()) << what;
        for (const auto& [key, value] : a.items())
            expect_alike(value, b.value(key, nlohmann::json()), within, what + "." + key);
    } else if (a.is_array()) {
        ASSERT_EQ(a.size(), b.size()) << what;
        for (std::size_t i = 0; i < a.size(); ++i) expect_alike(a[i], b[i], within, what);
    } else {
        EXPECT_EQ(a, b) << what;
    }
}

TEST(Panels, OfWindowAndHeadsetGiveEqualCommandsForOneScript)
{
    if (!open_layout({})) GTEST_SKIP() << no_panel;
    Both both;
    const int young = PanelSession::quantity("young"), yield = PanelSession::quantity("yield");
    const auto press = [](Control control) {
        return [control](PanelDriver& hand, PanelSession&) { hand.press({control, 0}); };
    };
    const auto slide = [](Control control, float share, int index = 0) {
        return [control, share, index](PanelDriver& hand, PanelSession&) {
            hand.slide({control, index}, share);
        };
    };
    const auto choose = [](Control control, const char* name) {
        return [control, name](PanelDriver& hand, PanelSession& session) {
            hand.choose({control, 0}, session.choice(control, name));
        };
    };
    const auto object = [](int place) {
        return [place](PanelDriver& hand, PanelSession&) { hand.choose_object(place); };
    };
    // At the ends of a slider commands are equal to the bit; between, to some pixels.
    constexpr double exact = 1e-12, pixels = 0.25;
    const struct {
        const char* what;
        std::function<void(PanelDriver&, PanelSession&)> act;
        int commands = 1;  // at least
        double within = exact;
    } script[] = {
        {"stiffness to its end", slide(Control::quantity, 1.05f, young)},
        {"stiffness to its beginning", slide(Control::quantity, -0.05f, young)},
        {"stiffness to its middle", slide(Control::quantity, 0.6f, young), 1, pixels},
        {"yield to its end", slide(Control::quantity, 1.05f, yield)},
        {"material", choose(Control::preset, "plasticine")},
        {"the other object", object(1), 0},
        {"its material", choose(Control::preset, "wet-sand")},
        {"locked", press(Control::lock)},
        {"locked, no material", choose(Control::preset, "clay"), 0},
        {"unlocked", press(Control::lock)},
        {"hidden", press(Control::hide)},
        {"shown", press(Control::hide)},
        {"its colour", choose(Control::colour, "orange")},
        {"a copy of it", press(Control::duplicate)},
        {"the copy in the middle", press(Control::centre)},
        {"the copy as it was made", press(Control::reset_object)},
        {"no gravity", slide(Control::gravity, -0.05f)},
        {"much gravity", slide(Control::gravity, 1.05f)},
        {"right tool", choose(Control::right_tool, "knife")},
        {"left tool", choose(Control::left_tool, "cone")},
        {"bare right hand", choose(Control::right_tool, "bare hand")},
        {"a box is added", choose(Control::add, "box")},
        {"a torus is added", choose(Control::add, "torus")},
        {"finer surface",
         [](PanelDriver& hand, PanelSession&) {
             hand.press({Control::surface, 0}, 1);
         }},
        {"coarser surface",
         [](PanelDriver& hand, PanelSession&) {
             hand.press({Control::surface, 0}, 0);
         },
         0},
        {"pause", press(Control::pause)},
        {"go on", press(Control::pause)},
        {"undo", press(Control::undo)},
        {"undo again", press(Control::undo)},
        {"redo", press(Control::redo)},
        {"the first step", slide(Control::go_to, -0.05f)},
        {"the last step", slide(Control::go_to, 1.05f)},
        {"no redo", press(Control::redo), 0},
        {"no save", press(Control::save), 0},
        {"cells are kept",
         [](PanelDriver& hand, PanelSession&) {
             hand.press({Control::cells, 0}, 1);
         },
         0},
        {"the first object", object(0), 0},
        {"deleted", press(Control::remove)},
        {"reset", press(Control::reset)},
        {"more cells",
         [](PanelDriver& hand, PanelSession&) {
             hand.press({Control::cells, 0}, 1);
         }},
        {"another scene", [&](PanelDriver& hand, PanelSession&) { hand.open(both.scene); }},
        {"quit", press(Control::quit), 0},
    };
    both.window.commands(), both.headset.commands();
    for (const auto& one : script) {
        SCOPED_TRACE(one.what);
        if (std::string(one.what) == "quit")
            both.window.act(Control::quit);  // in the window: in the menu
        else
            one.act(both.mouse, both.window);
        one.act(both.finger, both.headset);
        const std::vector<std::string> a = both.window.commands(), b = both.headset.commands();
        EXPECT_GE(int(a.size()), one.commands);
        if (one.commands == 1 && (a.empty() || b.empty())) {
            ADD_FAILURE() << a.size() << " commands of the window, " << b.size();
            continue;
        }
        // A drag gives as many commands as it has frames; the last decides.
        if (!a.empty() && !b.empty())
            expect_alike(nlohmann::json::parse(a.back()), nlohmann::json::parse(b.back()),
                         one.within, one.what);
        else
            EXPECT_EQ(a.size(), b.size());
        EXPECT_EQ(both.window.live.state()->refused, both.headset.live.state()->refused)
            << both.window.live.state()->refusal << both.headset.live.state()->refusal;
        if (one.within == exact) continue;
        // The rest of the script begins with equal documents.
        const int y = young;
        both.window.act(Control::quantity, 2e5, y), both.headset.act(Control::quantity, 2e5, y);
        both.window.commands(), both.headset.commands();
    }
    EXPECT_EQ(both.window.executed, both.headset.executed);
    EXPECT_TRUE(equal(*both.window.live.state()->document, *both.headset.live.state()->document));
}

// Each control that both have is laid out in both, with the same label and the same reason.
TEST(Panels, HaveTheSameControls)
{
    if (!open_layout({})) GTEST_SKIP() << no_panel;
    Both both;
    for (PanelSession* one : {&both.window, &both.headset}) one->act(Control::gravity, 3.0);
    const PanelModel window = both.window.panel.model(), headset = both.headset.panel.model();
    int common = 0;
    for (const PanelSection& section : headset.sections)
        for (const ControlState& one : section.controls) {
            if (!(one.row().shown & in_window)) {
                both.finger.show(one.id.control);
                EXPECT_TRUE(both.finger.drawing->place_of(one.id)) << one.row().name;
                continue;
            }
            const ControlState* const other = window.find(one.id);
            ASSERT_NE(other, nullptr) << one.row().name;
            EXPECT_EQ(one, *other) << one.row().name;
            ++common;
            // Open is a list and a button, objects are one list.
            if (one.id.control == Control::open || one.id.control == Control::object) continue;
            both.finger.show(one.id.control);
            EXPECT_TRUE(both.finger.drawing->place_of(one.id)) << one.row().name;
        }
    EXPECT_GT(common, 20);
    for (const PanelSection& section : window.sections)
        for (const ControlState& one : section.controls)
            EXPECT_TRUE(headset.find(one.id) || !(one.row().shown & in_headset)) << one.row().name;
}

TEST(WindowPanel, ANoticeDoesNotCloseAnOpenList)
{
    PanelSession session(in_window);
    MouseDriver mouse(session);
    if (!mouse.drawing) GTEST_SKIP() << no_panel;
    const int item = session.choice(Control::preset, "snow");
    mouse.press({Control::preset, 0});
    ASSERT_TRUE(mouse.drawing->place_of({Control::preset, 0}, item));
    session.panel.note("Wrote knead_0001.png");
    for (int i = 0; i < 5; ++i) mouse.frame(0, 0, false);
    EXPECT_TRUE(mouse.drawing->popup_open());
    mouse.press({Control::preset, 0}, item);
    EXPECT_EQ(session.live.state()->document->objects[0]->material.name, "snow");
    EXPECT_FALSE(mouse.drawing->popup_open());
}

TEST(WindowPanel, IsClosedByItsButtonAndANameIsTyped)
{
    PanelSession session(in_window);
    MouseDriver mouse(session);
    if (!mouse.drawing) GTEST_SKIP() << no_panel;
    EXPECT_GT(mouse.drawing->covered(), 200);
    mouse.drawing->begin(Control::rename);
    for (int i = 0; i < 3; ++i) mouse.frame(0, 0, false);
    EXPECT_TRUE(mouse.drawing->keys_taken());
    mouse.type("Schneeball \xc3\xa4");
    mouse.key(PanelKey::enter);
    for (int i = 0; i < 3; ++i) mouse.frame(0, 0, false);
    EXPECT_EQ(session.live.state()->document->objects[0]->name, "Schneeball \xc3\xa4");
    EXPECT_FALSE(mouse.drawing->keys_taken());
    session.act(Control::panels, false);
    for (int i = 0; i < 3; ++i) mouse.frame(0, 0, false);
    EXPECT_EQ(mouse.drawing->covered(), 0);
    EXPECT_FALSE(mouse.drawing->place_of({Control::undo, 0}));
}

TEST(HeadsetPanel, AListOfAnyLengthFitsIntoIt)
{
    PanelSession session(in_headset);
    for (int i = 0; i < 30; ++i)
        session.panel.ui.beside.push_back("scenes/" + std::to_string(i) + ".json");
    FingerDriver finger(session);
    if (!finger.drawing) GTEST_SKIP() << no_panel;
    const int last = int(session.panel.model().files.size()) - 1;
    ASSERT_GE(last, 30);
    finger.press({Control::open, 1});
    const auto first = finger.drawing->place_of({Control::open, 1}, 0),
               end = finger.drawing->place_of({Control::open, 1}, last);
    ASSERT_TRUE(first && end);
    const float row = first->height, bottom = float(HeadsetPanel::layout(1).height);
    EXPECT_LT(end->y + end->height + row, bottom) << "below is the button that closes the list";
    EXPECT_LE(end->x + end->width, float(HeadsetPanel::layout(1).width));
}

// From where the head is, letters of the headset's panel are at least a degree high, in all of it.
TEST(HeadsetPanel, LettersAreAtLeastADegreeHigh)
{
    PanelSession session(in_headset);
    HeadsetPanel panel(session.panel);
    for (const Side side : {left, right}) {
        session.panel.ui.panel_side = side;
        const Workplace workplace;
        panel.place(workplace, empty_box<double>(), HandsOptions{});
        const auto drawing = open_layout(HeadsetPanel::layout(panel.distance()));
        if (!drawing) GTEST_SKIP() << no_panel;
        const float high = drawing->capital() * HeadsetPanel::pixel;  // [m]
        // At the farthest corner, seen from the head, which the panel faces.
        const float corner =
            std::hypot(0.5f * HeadsetPanel::size.width, 0.5f * HeadsetPanel::size.height);
        const float farthest = std::hypot(panel.distance(), corner);
        const float slant = panel.distance() / farthest;
        EXPECT_GE(std::atan(high * slant / farthest) * 180 / 3.14159265f, 1) << side;
        EXPECT_LT(high, 0.02f);
    }
}

TEST(HeadsetPanel, IsLaidOutAgainOnlyWhenSomethingChanges)
{
    PanelSession session(in_headset);
    FingerDriver finger(session);
    if (!finger.drawing) GTEST_SKIP() << no_panel;
    for (int i = 0; i < 20; ++i) finger.frame({}, false);
    finger.panel.take_changed();
    for (int i = 0; i < 90; ++i) finger.frame({}, false);
    EXPECT_FALSE(finger.panel.take_changed());
    finger.frame({5, 5, 5}, true);
    EXPECT_FALSE(finger.panel.take_changed()) << "a finger that is far away";
    session.act(Control::gravity, 3.0);
    finger.frame({}, false);
    EXPECT_TRUE(finger.panel.take_changed());
}

TEST(HeadsetPanel, AHeldItemThatIsReleasedEarlyDoesNothing)
{
    PanelSession session(in_headset);
    FingerDriver finger(session);
    if (!finger.drawing) GTEST_SKIP() << no_panel;
    finger.show(Control::quit);
    const auto quit = finger.drawing->place_of({Control::quit, 0});
    ASSERT_TRUE(quit);
    finger.poke(*quit, 0.5f, 0.5f, 0.7);
    EXPECT_TRUE(session.executed.empty());
    finger.poke(*quit, 0.5f, 2.5f, 1.4);
    EXPECT_TRUE(session.executed.empty()) << "it slides off";
    finger.poke(*quit, 0.5f, 0.5f, 1.3);
    EXPECT_EQ(session.executed, std::vector{Control::quit}) << "once";
}

}  // namespace
}  // namespace knead
