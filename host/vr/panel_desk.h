// Applies the panel's commands to a live session, and fills the panel's view from its state.
#pragma once
#include <string>
#include <vector>

#include "host/live/live_session.h"
#include "host/vr/headset_hands.h"
#include "host/vr/headset_panel.h"

namespace knead {

class PanelDesk {
  public:
    // `scene`: path of a scene; the others of its folder can be chosen. `settings`: for all scenes.
    PanelDesk(std::string scene, std::vector<std::string> settings);

    // Executes commands on the session and its hands. Ignores those that the caller executes:
    // pause, recentre, posture, side, hold, quit.
    void apply(const PanelCommand& command, const LiveState& state, LiveSession& live,
               HeadsetHands& hands);
    // The scene's gravity, or the Earth's if that is zero; zero if switched off [m/s^2].
    Vec3<double> gravity_of(const LiveState& state);
    PanelView view(const LiveState& state, const HeadsetHands& hands);

  private:
    void follow(const LiveState& state);
    void choose_scene(int step, LiveSession& live);
    void choose_material(int step, const LiveState& state, LiveSession& live);
    void choose_tool(Side side, int step, LiveSession& live, HeadsetHands& hands);
    void load(LiveSession& live);
    void give(const LiveState& state, LiveSession& live);

    std::vector<std::string> scenes;
    std::size_t scene = 0;
    std::vector<std::string> settings;
    int cells = 0;  // requested; 0: the scene's own
    int history = -1, refused = 0;
    std::string preset;
    Material<double> material{};  // of all objects, once changed
    bool touched = false, gravity = true;
};

// Logarithmic slider: position, 0 to 1, of a value between two limits, and the inverse.
float share_of(double value, double low, double high);
double value_of(float share, double low, double high);

}  // namespace knead
