// Converts the panel's presses to commands of a live session, and fills the panel's view from its
// state.
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

    // Sends what a press asks for to the session, and changes the tools of the hands that are
    // drawn. Ignores presses that the caller executes: pause, recentre, posture, side, hold, quit.
    void apply(const PanelCommand& command, const LiveState& state, LiveSession& live,
               HeadsetHands& hands);
    PanelView view(const LiveState& state, const HeadsetHands& hands) const;

  private:
    void choose_scene(int step, LiveSession& live);
    void choose_tool(Side side, int step, LiveSession& live, HeadsetHands& hands);

    std::vector<std::string> scenes;
    std::size_t scene = 0;
    std::vector<std::string> settings;
};

// Logarithmic slider: position, 0 to 1, of a value between two limits, and the inverse.
float share_of(double value, double low, double high);
double value_of(float share, double low, double high);

}  // namespace knead
