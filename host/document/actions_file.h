// Reads .actions files: what older versions wrote beside a recording in place of a log of commands.
// docs/reference/recordings.md.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "host/document/command_text.h"

namespace knead {

// A step of an object that a fist carried: a rigid motion in the simulation's frame.
struct Moved {
    ObjectId object;
    RigidMotion<double> motion{};
};

// What is done after a frame of a run.
struct LogEntry {
    long frame = 0;
    std::variant<Command, Moved> done;
    int line = 0;  // of the log's file; 0: unknown
};

struct ActionsFile {
    std::string scene;                  // its file, as given
    std::vector<std::string> settings;  // --set, as given
    std::string recording;              // hash of the recording's file
    std::vector<LogEntry> all;          // in order of frames
};

constexpr std::size_t most_actions = 60000;

// The side file of a recording: its name and ".actions".
std::string actions_file(const std::string& recording);
// `rate`: frames per second of a run that plays the recording. `origin`: Scene::origin [m]. Throw
// InputError with file, JSON pointer, expected and found.
ActionsFile read_actions(const std::string& file, double rate, Vec3<double> origin);
ActionsFile parse_actions(const std::string& text, const std::string& file, double rate,
                          Vec3<double> origin);

}  // namespace knead
