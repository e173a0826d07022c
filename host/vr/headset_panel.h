// The panel beside the clay: its items, their layout, and the commands of a finger that pokes them.
// Independent of OpenGL and the simulation.
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
    undo,
    redo,
    save,
    quit
};
struct PanelCommand {
    PanelAct act;
    int step = 0;       // -1, 1: previous, next; 0: a button or a slider
    float value = -1;   // of a slider, 0 to 1; negative: no slider
    unsigned drag = 0;  // of a slider: number of the press, rising from 1
};

// What the panel shows.
struct PanelView {
    std::string scene, material, left_tool, right_tool;
    std::string failure;              // why the simulation has ended; "": it has not
    std::string notice;               // shown for some seconds; "": none
    float stiffness = 0, yield = -1;  // slider positions, 0 to 1; negative: the material has none
    int nodes = 0;                    // of the solver's lattice, along x
    int surface = 0;                  // of the surface's lattice, along its longest side
    bool gravity = true, paused = false, carrying = false, standing = false;
    std::string no_undo, no_redo, no_save;  // why these are not available; "": they are
};

struct PanelItem {
    PanelRect rect;
    PanelCommand command;
    bool slider = false;
    bool held = false;  // discards work: must be pressed for HeadsetPanel::held_for
};

class HeadsetPanel {
  public:
    static constexpr int width = 240, height = 224;  // [pixels]
    static constexpr float pixel = 0.0016f;          // [m]
    static constexpr float finger = 0.007f;          // from the tip's joint to the skin [m]
    static constexpr double held_for = 1;            // [s]

    HeadsetPanel();
    const std::vector<PanelItem>& items() const { return all; }

    // Pose in the frame of the hands, x right, y up, z towards the user: left or right of the clay,
    // within reach, facing a user seated before it.
    static Joint<float> pose(const Workplace& usual, Side side);

    // Call each frame for each side. `tip`: tip of the index finger in the panel's frame, with the
    // origin at its centre [m]; `time` [s] ascends. A press begins when the finger crosses the
    // surface from the front and ends when it is back. Sliders follow the finger. A held item is
    // triggered after `held_for`; a finger that leaves or is lost before triggers nothing.
    std::optional<PanelCommand> poke(Side side, Vec3<float> tip, bool tracked, double time);
    // Whether the picture is animated: an item is being held, or was released too early.
    bool moves() const;

    void draw(PanelCanvas& canvas, const PanelView& view, const FrameFigures& figures) const;

  private:
    const PanelItem* at(Vec3<float> tip) const;
    void draw_item(PanelCanvas& canvas, const PanelItem& item, const PanelView& view) const;
    void draw_graph(PanelCanvas& canvas, const FrameFigures& figures) const;

    std::vector<PanelItem> all;
    struct Finger {
        bool armed = false;  // in front of the panel
        const PanelItem* pressed = nullptr;
        unsigned press = 0;  // its number
        float value = -1;    // last reported value of the pressed slider
        double since = 0;    // beginning of the press [s]
        bool done = false;   // the pressed held item was triggered
    };
    std::optional<PanelCommand> hold(Finger& of, Vec3<float> tip);
    void let_go(Finger& of);
    float progress(const PanelItem& item) const;  // of holding, 0 to 1; negative: not held
    std::string words_on(const PanelItem& item, const PanelView& view) const;

    Finger fingers[side_count];
    unsigned presses = 0;                   // so far
    double now = 0;                         // [s]
    const PanelItem* left_early = nullptr;  // held item that was released too early,
    double left_at = -1e30;                 // and when [s]
};

}  // namespace knead
