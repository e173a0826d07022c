// What a live session did, as it did it: enough to compute its clay again to the bit on a simulator
// that is deterministic. The clock decides four things in real time, and the log has them: when
// hands are sampled, after how many substeps a frame is cut, in which frame the result of a
// background task of the splats is taken, and between which frames a new object is prepared.
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
    std::vector<bool> taken;  // of each question whether a background result is taken: the answer
};
// The clay of a new object was begun: it leaves room for the clay as it was then.
struct LoggedPreparation {
    AddObject command;
};
using SessionEvent = std::variant<HandFrame, Command, LoggedPreparation, LoggedFrame>;

// Since the last load or reset.
struct SessionLog {
    std::shared_ptr<const LiveScene> scene;
    std::vector<SessionEvent> events;
};

// Computes the session again with a simulator made by `make`. Throws std::runtime_error with the
// number of the frame in which it differs from the log or ends by a fault.
std::vector<Particle<double>> replayed(
    const SessionLog& log, const std::function<std::unique_ptr<Simulator>(const Setup&)>& make);

}  // namespace knead
