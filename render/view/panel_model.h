// Data shown by the window's panels, and the requests they return. Independent of the simulation:
// the caller fills the model and executes the requests.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/files/image.h"
#include "render/view/time_graph.h"

namespace knead {

// A number set by a slider.
struct Slider {
    std::string name, unit;
    double value = 0, low = 0, high = 1;
    bool logarithmic = false;
};

struct ObjectPanel {
    std::string name;
    int preset = 0;               // index into PanelModel::presets
    std::vector<Slider> sliders;  // material quantities
};

struct CommandButton {
    std::string label;
    std::string why_not;  // why it is not available; "": it is
};
struct StepRow {
    int id = 0;
    std::string label;
    bool current = false;
    bool on_line = true;  // reached by undo and redo alone
};
// A session that ended without being saved.
struct RecoverRow {
    std::string file, name, text;
    std::shared_ptr<const Image> picture;  // null: none
};

struct PanelModel {
    bool open = true;                 // all panels
    bool pressed = false;             // a control is held
    unsigned drag = 0;                // number of the last press of a control
    std::vector<std::string> scenes;  // names
    int scene = -1;
    std::vector<std::string> presets;
    std::vector<ObjectPanel> objects;
    int object = 0;                     // selected
    std::vector<std::string> tools;     // names; the first is the bare hand
    std::vector<std::string> postures;  // names
    int tool = 0, posture = 1;
    bool hand = false;  // the mouse controls a hand
    double curl[5] = {0, 0, 0, 0, 0};
    double tilt = 0, roll = 0, press = 0.1;  // [rad], [m]
    bool paused = false, recorded = false, has_recording = false, filming = false;
    CommandButton undo, redo, save;
    std::string session;  // one line: saved, unsaved, trouble
    std::vector<StepRow> steps;
    bool steps_changed = false;  // since they were drawn
    std::vector<RecoverRow> recoverable;
    double gravity = 9.81;  // downwards [m/s^2]
    TimeGraph graph;
    std::vector<std::string> facts;  // lines of text: solver, renderer, frames, lag
    std::string failure, notice;     // "" none
    double noticed = 0;              // time that the notice has been shown [s]
    // A question to confirm, the labels of its buttons; "": none.
    std::string question, answer, decline;

    void note(const std::string& text) { notice = text, noticed = 0; }
    // Call every frame: clears the notice after 6 s.
    void pass(double seconds)
    {
        noticed += seconds;
        if (noticed > 6) notice.clear();
    }
};

// User requests of one frame.
struct PanelRequests {
    std::optional<int> load, tool;
    std::optional<int> go_to;                 // id of a step
    std::optional<int> recover, discard_log;  // rows
    bool undo = false, redo = false, save = false, hide_recoverable = false;
    std::optional<bool> pause, recorded;
    std::optional<double> gravity;
    bool reset = false, step = false, fit_camera = false, screenshot = false, film = false;
    std::optional<bool> confirm;  // the answer to the question
    // Of the selected object: preset chosen, slider moved.
    bool preset = false, material = false;
    unsigned drag = 0;  // of `gravity` and `material`: number of the press, rising from 1
};

}  // namespace knead
