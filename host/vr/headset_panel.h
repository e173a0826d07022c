// The panel beside the clay: what is on it, where, and what a finger that pokes it asks for. Knows
// no OpenGL and no simulation.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/vr/headset_figures.h"
#include "host/vr/headset_view.h"
#include "host/vr/panel_text.h"

namespace knead {

enum class PanelAct {
    scene,
    material,
    stiffness,
    yield,
    left_tool,
    right_tool,
    cells,
    surface,
    gravity,
    pause,
    reset,
    recentre,
    posture,
    side,
    hold,
    quit
};
struct PanelCommand {
    PanelAct act;
    int step = 0;      // -1, 1: the one before, the one behind; 0: a plain button or a slider
    float value = -1;  // of a slider: 0 to 1; negative: none
};

// What the panel shows.
struct PanelView {
    std::string scene, material, left_tool, right_tool;
    std::string trouble;              // why the simulation has ended; "": it has not
    std::string notice;               // shown for some seconds; "": none
    float stiffness = 0, yield = -1;  // of their sliders, 0 to 1; negative: the material has none
    int nodes = 0;                    // of the lattice, along x
    int surface = 0;                  // of the surface's, along its longest side
    bool gravity = true, paused = false, holding = false, standing = false;
};

struct PanelItem {
    PanelRect rect;
    PanelCommand command;
    bool slider = false;
    bool held = false;  // throws work away: is pressed for HeadsetPanel::held_for
};

class HeadsetPanel {
  public:
    static constexpr int width = 240, height = 224;  // [pixels]
    static constexpr float pixel = 0.0016f;          // [m]
    static constexpr float finger = 0.007f;          // from the tip's joint to what presses [m]
    static constexpr double held_for = 1;            // [s]

    HeadsetPanel();
    const std::vector<PanelItem>& items() const { return all; }

    // Where it stands in the frame of the hands: x right, y up, z towards the user. On the left
    // or the right of the clay, within reach, facing the eyes of who sits before it.
    static Joint<float> pose(const Workplace& usual, Side side);

    // The tip of a side's index finger in the panel's frame, the middle being the origin [m]. A
    // press is a way through the surface from before; it is over when the finger is back, and does
    // not begin behind. Sliders follow the finger. A held item answers once the finger has been on
    // it for `held_for`; one that leaves it before, or is lost, has asked for nothing. `time` [s]
    // rises.
    std::optional<PanelCommand> poke(Side side, Vec3<float> tip, bool tracked, double time);
    // The picture changes with time: a finger holds an item, or has let go of one too early.
    bool moves() const;

    void draw(PanelCanvas& canvas, const PanelView& view, const FrameFigures& figures) const;

  private:
    const PanelItem* at(Vec3<float> tip) const;
    void draw_item(PanelCanvas& canvas, const PanelItem& item, const PanelView& view) const;
    void draw_graph(PanelCanvas& canvas, const FrameFigures& figures) const;

    std::vector<PanelItem> all;
    struct Finger {
        bool armed = false;  // it is before the panel
        const PanelItem* pressed = nullptr;
        float value = -1;   // of the slider that is pressed, as it was told last
        double since = 0;   // when the press began [s]
        bool done = false;  // the held item that is pressed has answered
    };
    std::optional<PanelCommand> hold(Finger& of, Vec3<float> tip);
    void let_go(Finger& of);
    float progress(const PanelItem& item) const;  // of its being held; negative: it is not
    std::string words_on(const PanelItem& item, const PanelView& view) const;

    Finger fingers[side_count];
    double now = 0;                         // [s]
    const PanelItem* left_early = nullptr;  // the held item that a finger has left before its time,
    double left_at = -1e30;                 // and when [s]
};

}  // namespace knead
