// What the panel's commands do to a live session, and what it shows of it.
#pragma once
#include <string>
#include <vector>

#include "host/live/live_session.h"
#include "host/vr/headset_hands.h"
#include "host/vr/headset_panel.h"

namespace knead {

class PanelDesk {
  public:
    // `scene` is a scene's file; the others of its folder are offered, too. `settings` go with all.
    PanelDesk(std::string scene, std::vector<std::string> settings);

    // Does what belongs to the session and its hands. Pause, recentre, side and quit are the
    // caller's.
    void apply(const PanelCommand& command, const LiveState& state, LiveSession& live,
               HeadsetHands& hands);
    // The scene's gravity, or that of the Earth where it has none; none where it is switched off.
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
    int cells = 0;  // asked for; 0: the scene's own
    int history = -1, refused = 0;
    std::string preset;
    Material<double> material{};  // of all objects, once it was touched
    bool touched = false, gravity = true;
};

// A slider's share for a value between two, in even steps of the ratio, and back.
float share_of(double value, double low, double high);
double value_of(float share, double low, double high);

}  // namespace knead
