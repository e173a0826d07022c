// Actions in a live session other than hand motion: commands of its panel, and clay moved by closed
// fists. Stored in a side file of the recording (docs/reference/recordings.md).
#pragma once
#include <string>
#include <vector>

#include "cuda/mpm/edit.h"
#include "cuda/mpm/material_data.h"
#include "host/hands/hands_options.h"

namespace knead {

enum class ActionType {
    began,     // start of the recording: a scene was loaded, or reset
    pause,     // begin or end of a pause; ignored on replay
    material,  // of an object; its volume and category are kept
    gravity,
    hands,  // tools of the hands, their zoom and offset
    move    // an object, as a rigid body
};

struct HandAction {
    double time = 0;  // of the recording [s]; applied before the first frame with a later end
    ActionType act = ActionType::began;
    std::string by;               // began: "scene" or "reset"
    bool on = false;              // pause
    int object = 0;               // material, move
    Material<double> material{};  // without mass, volume and category
    Vec3<double> gravity{};       // [m/s^2]
    HandsOptions hands;           // only `held`, `present`, `zoom`, `at`; otherwise as in the scene
    RigidMotion<double> motion{};
};

struct HandActions {
    std::string scene;                  // its file, as given
    std::vector<std::string> settings;  // --set, as given
    std::string recording;              // hash of the recording's file
    std::vector<HandAction> all;        // in order of time
};

constexpr std::size_t most_actions = 60000;

// The side file of a recording: its name and ".actions".
std::string actions_file(const std::string& recording);
// Throw InputError with file, JSON pointer, expected and found.
HandActions read_actions(const std::string& file);
HandActions parse_actions(const std::string& text, const std::string& file);
// Writes the file atomically. Throws OutputError if it cannot be written.
void write_actions(const std::string& file, const HandActions& actions);
std::string to_text(const HandActions& actions);

}  // namespace knead
