// The window's panels and the headset's panel: the same controls give equal commands.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/desktop/view_panels.h"
#include "host/document/command_text.h"
#include "host/session/backend.h"
#include "host/vr/panel_desk.h"

namespace knead {
namespace {

// A stepped session of little clay, and what was done in it.
class PanelSession {
  public:
    const std::vector<std::string> settings{"domain.cells=16", "surface.nodes=16"};
    LiveSession live{load_live_scene("scenes/squeeze.json", settings), [] {
                         LiveOptions options;
                         options.stepped = true, options.recorded = false;
                         options.make_solver = [](const auto& s) {
                             return make_solver(s, parse_device("cpu"));
                         };
                         return options;
                     }()};
    std::vector<std::string> done()
    {
        live.wait_for_commands();
        EXPECT_EQ(live.state()->refusal, "");
        std::vector<std::string> texts;
        for (const AppliedCommand& one : live.take_applied())
            texts.push_back(json_of(one.issued.command).dump() + " drag " +
                            std::to_string(one.issued.drag));
        return texts;
    }
};

TEST(Panels, OfWindowAndHeadsetGiveEqualCommands)
{
    PanelSession window, headset;
    window.live.wait_for_commands(), headset.live.wait_for_commands();
    ViewPanels panels("scenes/squeeze.json", window.settings);
    PanelDesk desk("scenes/squeeze.json", headset.settings);
    HeadsetHands hands(headset.live.state()->hands);

    unsigned drag = 0;
    const auto slide = [&](const std::string& key, float share) {
        return [&panels, &drag, key, share](PanelRequests& r) {
            const MaterialQuantity& q = material_quantity(key);
            for (Slider& s : panels.model.objects.at(0).sliders)
                if (s.name == q.name) s.value = value_of(share, q.slider.low, q.slider.high);
            r.material = true, r.drag = ++drag;
        };
    };
    const auto preset = [&](int step) {
        return [&panels, step](PanelRequests& r) {
            const int count = int(panels.model.presets.size());
            int& chosen = panels.model.objects.at(0).preset;
            chosen = (chosen + count + step) % count;
            r.preset = true;
        };
    };
    const struct {
        const char* what;
        std::function<void(PanelRequests&)> window;
        PanelCommand headset;
    } controls[] = {
        {"stiffness", slide("young", 0.25f), {PanelAct::stiffness, 0, 0.25f, 1}},
        {"stiffness, from one end", slide("young", 0), {PanelAct::stiffness, 0, 0, 2}},
        {"yield", slide("yield", 0.5f), {PanelAct::yield, 0, 0.5f, 3}},
        {"next preset", preset(1), {PanelAct::material, 1}},
        {"previous preset", preset(-1), {PanelAct::material, -1}},
        {"yield of it", slide("yield", 0.75f), {PanelAct::yield, 0, 0.75f, 4}},
        {"no gravity", [](PanelRequests& r) { r.gravity = 0; }, {PanelAct::gravity}},
        {"gravity", [](PanelRequests& r) { r.gravity = 9.81; }, {PanelAct::gravity}},
        {"undo", [](PanelRequests& r) { r.undo = true; }, {PanelAct::undo}},
        {"undo again", [](PanelRequests& r) { r.undo = true; }, {PanelAct::undo}},
        {"redo", [](PanelRequests& r) { r.redo = true; }, {PanelAct::redo}},
    };
    for (const auto& control : controls) {
        const auto before = headset.live.state();
        panels.follow(*window.live.state());
        PanelRequests requests;
        control.window(requests);
        panels.apply(requests, window.live);
        desk.apply(control.headset, *before, headset.live, hands);
        const std::vector<std::string> one = window.done(), other = headset.done();
        EXPECT_EQ(one.size(), 1u) << control.what;
        EXPECT_EQ(one, other) << control.what;
        EXPECT_TRUE(equal(*window.live.state()->document, *headset.live.state()->document))
            << control.what;
    }
}

TEST(Panels, OfWindowAndHeadsetOpenScenesAlike)
{
    PanelSession window, headset;
    window.live.wait_for_commands(), headset.live.wait_for_commands();
    ViewPanels panels("scenes/squeeze.json", window.settings);
    PanelDesk desk("scenes/squeeze.json", headset.settings);
    HeadsetHands hands(headset.live.state()->hands);
    panels.follow(*window.live.state());
    panels.load((panels.model.scene + 1) % int(panels.paths.size()), window.live);
    desk.apply({PanelAct::scene, 1}, *headset.live.state(), headset.live, hands);
    window.live.wait_for_commands(), headset.live.wait_for_commands();
    const auto text = [](LiveSession& live) {
        const std::vector<AppliedCommand> all = live.take_applied();
        return all.empty() ? "" : json_of(all.back().issued.command).dump();
    };
    const std::string opened = text(window.live);
    EXPECT_NE(opened.find("\"open\""), std::string::npos) << opened;
    EXPECT_EQ(opened, text(headset.live));
    EXPECT_EQ(window.live.state()->scene->scene.path, headset.live.state()->scene->scene.path);
}

}  // namespace
}  // namespace knead
