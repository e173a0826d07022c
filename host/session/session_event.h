// What happens in a session, in order: enough to compute its clay again to the bit on a
// deterministic simulator. Files have these events in chunks of kind EVNT (session_file.h).
#pragma once
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "host/document/command.h"
#include "host/hands/hands.h"
#include "host/solver/simulator.h"

namespace knead {

// A state that undo can return to; 0: the beginning. Rising, never used twice in a session.
using StepId = std::uint64_t;

struct FrameEvent {
    double time = 0;          // of the session, at the frame's end [s]
    double duration = 0;      // simulated; less if cut [s]
    int cut_after = 0;        // substeps; 0: it is whole
    std::vector<bool> taken;  // for each poll of a background result: whether it was taken
    Motion motion;            // as the simulator got it
};
// State of the simulator after the last frame, or at the beginning.
struct HashEvent {
    long frame = 0;  // events before
    std::uint64_t hash = 0;
};
struct CommandEvent {
    Issued issued;  // with ids in place of names
};
// Preparation of a new object began: room is left for the clay of this frame, not of a later one.
struct PreparationEvent {
    AddObject command;
};
// A step was begun by a change; it has no particles yet.
struct StepBegun {
    StepId id = 0, parent = 0;
    std::string label;
};
// The particles of a step are those after the last frame.
struct StepCaptured {
    StepId id = 0;
    bool unchanged = false;  // they are those of its parent: the change was not of clay
};
// The document and the particles of a step replaced the current ones.
struct StepRestored {
    StepId id = 0;
};
// The simulation began, or began again: from the scene, or from a stored state.
struct RunBegun {
    std::uint64_t state = 0;  // id of a STAT chunk; 0: from the scene
    DocumentPtr document;  // of the scene, where commands changed it before; null: as in its file
};

using SessionEvent = std::variant<FrameEvent, HashEvent, CommandEvent, PreparationEvent, StepBegun,
                                  StepCaptured, StepRestored, RunBegun>;

// Events as the payload of a chunk. Joints are differences (XOR) from the frame before in the same
// chunk, which compress well.
class EventWriter {
  public:
    void add(const SessionEvent& event);
    void add(const HandFrame& frame);  // of a chunk that has nothing else
    std::size_t size() const { return bytes.size(); }
    std::string take();  // all so far; the next chunk begins

  private:
    std::string bytes;
    Motion last;
    HandFrame last_hands;
};
// Throw InputError for bytes that EventWriter cannot have written. `file`: for messages.
std::vector<SessionEvent> events_in(const std::string& bytes, const std::string& file);
std::vector<HandFrame> hands_in(const std::string& bytes, const std::string& file);

}  // namespace knead
