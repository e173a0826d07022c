// Events of a live session, sufficient to compute its clay again to the bit on a deterministic
// simulator. Four kinds depend on the clock in real time: sampling times of the hands, cuts of
// frames, frames in which background results are taken, and the preparation of new objects.
#pragma once
#include <memory>
#include <variant>
#include <vector>

#include "host/document/command.h"
#include "host/hands/hands.h"
#include "host/solver/editable_simulator.h"

namespace knead {

struct LiveScene;

struct LoggedFrame {
    double sampled = 0;       // when its hands were sampled, of the session [s]
    int cut_after = 0;        // substeps; 0: it is whole
    std::vector<bool> taken;  // for each poll of a background result: whether it was taken
};
// Preparation of a new object began: room is left for the clay of this frame, not of a later one.
struct LoggedPreparation {
    AddObject command;
};
using SessionEvent = std::variant<HandFrame, Command, LoggedPreparation, LoggedFrame>;

// Since the last load or reset.
struct SessionLog {
    std::shared_ptr<const LiveScene> scene;
    std::vector<SessionEvent> events;
};

// Computes the session again with a simulator made by `make`, and returns the particles. Throws
// std::runtime_error if a command is refused, a frame fails or background tasks do not match.
std::vector<Particle<double>> replayed(
    const SessionLog& log, const std::function<std::unique_ptr<Simulator>(const Setup&)>& make);

}  // namespace knead
