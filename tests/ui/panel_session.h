// A stepped session of little clay with a panel, for tests.
#pragma once
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/document/command_text.h"
#include "host/session/backend.h"
#include "host/ui/panel_controller.h"

namespace knead {

class PanelSession {
  public:
    static std::vector<std::string> small() { return {"domain.cells=16", "surface.nodes=16"}; }
    static LiveOptions options(bool protects = false, const std::string& session = "")
    {
        LiveOptions by;
        by.make_solver = [](const auto& setup) { return cpu_solver(setup); };
        by.stepped = true, by.recorded = false, by.protects = protects, by.session = session;
        return by;
    }

    explicit PanelSession(unsigned place = in_window, bool protects = false,
                          const std::string& session = "",
                          const std::string& scene = "scenes/squeeze.json")
        : panel(place, session.empty() ? scene : session, small()),
          live(session.empty() ? load_live_scene(scene, small()) : nullptr,
               options(protects, session))
    {
        panel.execute = [this](const ControlEvent& event) {
            executed.push_back(event.id.control);
            if (const bool* on = std::get_if<bool>(&event.value);
                on && event.id.control == Control::pause)
                panel.ui.paused = *on, panel.send(Pause{*on}, live);
        };
        if (protects) panel.remember_files();
        live.wait_until_open();
        settle();
    }

    // Lets the session answer, and shows what became of it.
    const PanelModel& settle()
    {
        live.wait_for_commands();
        panel.follow(*live.state(), live, now += 0.01);
        live.wait_for_commands();
        panel.follow(*live.state(), live, now += 0.01);
        return panel.model();
    }
    // Whether nothing was refused.
    bool act(Control control, ControlValue value = {}, int index = 0, unsigned drag = 0)
    {
        const int before = live.state()->refused;
        panel.apply({{control, index}, std::move(value), drag}, live);
        settle();
        return live.state()->refused == before;
    }
    const ControlState& shown(Control control, int index = 0)
    {
        static const ControlState none;
        const ControlState* const found = panel.model().find({control, index});
        if (found) return *found;
        ADD_FAILURE() << row_of(control).name << " " << index << " is not shown";
        return none;
    }
    double number(Control control, int index = 0)
    {
        return std::get<double>(shown(control, index).value);
    }
    int whole(Control control) { return std::get<int>(shown(control).value); }
    static int quantity(const std::string& key)
    {
        const auto all = material_quantities();
        for (std::size_t i = 0; i < all.size(); ++i)
            if (all[i].key == key) return int(i);
        throw std::out_of_range(key);
    }
    // The place of a name among the choices of a control.
    int choice(Control control, const std::string& name)
    {
        const std::vector<std::string>& all = shown(control).choices;
        const auto at = std::find(all.begin(), all.end(), name);
        EXPECT_NE(at, all.end()) << name;
        return int(at - all.begin());
    }
    SimulationConfig config()
    {
        SimulationConfig found;
        live.inspect_solver([&](const Simulator& s) { found = s.editable()->config(); });
        return found;
    }
    double young() { return stated(config().materials[0]).young; }
    // Waits for the log's thread.
    bool saved()
    {
        for (int i = 0; i < 1000 && live.state()->unsaved; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        settle();
        return !live.state()->unsaved;
    }
    // What was applied since the last call.
    std::vector<std::string> commands()
    {
        live.wait_for_commands();
        std::vector<std::string> texts;
        for (const AppliedCommand& one : live.take_applied())
            texts.push_back(json_of(one.issued.command).dump());
        return texts;
    }

    PanelController panel;
    LiveSession live;
    std::vector<Control> executed;
    double now = 0;
};

}  // namespace knead
