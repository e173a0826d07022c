// What the panels of the window show, and what was asked for by them. Neither knows the other side:
// who runs the window fills the one and does the other.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "render/view/time_graph.h"

namespace knead {

// A number that may be dragged.
struct Slider {
    std::string name, unit;
    double value = 0, low = 0, high = 1;
    bool logarithmic = false;
};

struct ObjectPanel {
    std::string name;
    int preset = 0;               // of PanelModel::presets
    std::vector<Slider> sliders;  // of the material
};

struct PanelModel {
    bool open = true;                 // all panels
    std::vector<std::string> scenes;  // names
    int scene = -1;
    std::vector<std::string> presets;
    std::vector<ObjectPanel> objects;
    int object = 0;                     // selected
    std::vector<std::string> tools;     // names; the first is the bare hand
    std::vector<std::string> postures;  // names
    int tool = 0, posture = 1;
    bool hand = false;  // the mouse leads one
    double curl[5] = {0, 0, 0, 0, 0};
    double tilt = 0, roll = 0, press = 0.1;  // [rad], [m]
    bool paused = false, recorded = false, has_recording = false, filming = false;
    double gravity = 9.81;  // downwards [m/s^2]
    TimeGraph graph;
    std::vector<std::string> facts;  // lines: solver, renderer, frames, what falls behind
    std::string trouble, notice;     // "" none
    double noticed = 0;              // for how long the notice has been seen [s]
    std::string question, answer;    // what must be confirmed, by a button so named; "" nothing

    void note(const std::string& text) { notice = text, noticed = 0; }
    // A notice is taken away after a while.
    void pass(double seconds)
    {
        noticed += seconds;
        if (noticed > 6) notice.clear();
    }
};

// What was asked for in a frame.
struct PanelRequests {
    std::optional<int> load, tool;
    std::optional<bool> pause, recorded;
    std::optional<double> gravity;
    bool reset = false, step = false, frame_camera = false, screenshot = false, film = false;
    std::optional<bool> confirm;            // the answer to the question
    bool preset = false, material = false;  // of the selected object: chosen, or a slider moved
};

}  // namespace knead
