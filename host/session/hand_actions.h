// What was done to a live session beside moving hands: by its panel, and by fists that carry clay.
// A recording's frames know nothing of it; a side file does (docs/reference/recordings.md).
#pragma once
#include <string>
#include <vector>

#include "cuda/mpm/edit.h"
#include "cuda/mpm/material_data.h"
#include "host/hands/hands_options.h"

namespace knead {

enum class ActionType {
    began,     // the recording: by a scene that was loaded, or a reset
    pause,     // time stands still from here on, or no longer; nothing is done on replay
    material,  // of an object; its volume and category stay
    gravity,
    hands,  // which tools they are or hold, and where they stand
    move    // an object, as a whole
};

struct HandAction {
    double time = 0;  // of the recording [s]; before the first frame that ends later
    ActionType act = ActionType::began;
    std::string by;               // began: "scene" or "reset"
    bool on = false;              // pause
    int object = 0;               // material, move
    Material<double> material{};  // without mass, volume and category
    Vec3<double> gravity{};       // [m/s^2]
    HandsOptions hands;           // `held`, `present`, `zoom`, `at`; the rest is the scene's
    RigidMotion<double> motion{};
};

struct HandActions {
    std::string scene;                  // its file, as it was named
    std::vector<std::string> settings;  // with which it was read
    std::string recording;              // hash of the recording's file
    std::vector<HandAction> all;        // times do not fall
};

constexpr std::size_t most_actions = 60000;

// Of a recording's file, its side file: the same name and ".actions".
std::string actions_file(const std::string& recording);
// Throws InputError with file, place, what was expected and found.
HandActions read_actions(const std::string& file);
HandActions parse_actions(const std::string& text, const std::string& file);
// The file appears whole or not at all. Throws OutputError where the disk refuses.
void write_actions(const std::string& file, const HandActions& actions);
std::string to_text(const HandActions& actions);

}  // namespace knead
