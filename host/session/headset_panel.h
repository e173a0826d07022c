// The panel beside the clay: what is on it, where, and what a finger that pokes it asks for. Knows
// no OpenGL and no simulation.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/session/headset_figures.h"
#include "host/session/headset_view.h"
#include "host/session/panel_text.h"

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
    std::string scene, material, left_tool, right_tool, trouble;
    float stiffness = 0, yield = -1;  // of their sliders, 0 to 1; negative: the material has none
    int nodes = 0;                    // of the lattice, along x
    int surface = 0;                  // of the surface's, along its longest side
    bool gravity = true, paused = false, holding = false, standing = false;
};

struct PanelItem {
    PanelRect rect;
    PanelCommand command;
    bool slider = false;
};

class HeadsetPanel {
  public:
    static constexpr int width = 240, height = 224;  // [pixels]
    static constexpr float pixel = 0.0016f;          // [m]
    static constexpr float finger = 0.007f;          // from the tip's joint to what presses [m]

    HeadsetPanel();
    const std::vector<PanelItem>& items() const { return all; }

    // Where it stands in the frame of the hands: x right, y up, z towards the user. On the left
    // or the right of the clay, within reach, facing the eyes of who sits before it.
    static Joint<float> pose(const Workplace& usual, Side side);

    // The tip of a side's index finger in the panel's frame, the middle being the origin [m]. A
    // press is a way through the surface from before; it is over when the finger is back, and does
    // not begin behind. Sliders follow the finger.
    std::optional<PanelCommand> poke(Side side, Vec3<float> tip, bool tracked);

    void draw(PanelCanvas& canvas, const PanelView& view, const FrameFigures& figures) const;

  private:
    const PanelItem* at(Vec3<float> tip) const;
    void draw_item(PanelCanvas& canvas, const PanelItem& item, const PanelView& view) const;
    void draw_graph(PanelCanvas& canvas, const FrameFigures& figures) const;

    std::vector<PanelItem> all;
    struct Finger {
        bool armed = false;  // it is before the panel
        const PanelItem* pressed = nullptr;
        float value = -1;  // of the slider that is pressed, as it was told last
    };
    Finger fingers[side_count];
};

}  // namespace knead
