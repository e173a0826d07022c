// Events of a live session in memory, sufficient to compute its clay again to the bit on a
// deterministic simulator; and that computation, for sessions in files as well.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/session/session_event.h"
#include "host/session/stored_state.h"
#include "host/solver/editable_simulator.h"

namespace knead {

struct LiveScene;

// Since the last load.
struct SessionLog {
    std::shared_ptr<const LiveScene> scene;
    std::vector<SessionEvent> events;
};

// A difference between a session and its replay.
struct ReplayedHash {
    long frame = 0;  // events of frames before
    bool equal = false;
};

struct ReplayOptions {
    std::function<std::unique_ptr<Simulator>(const Setup&)> make_solver;
    bool stepped = false;  // as the session was
    // Of a session in a file.
    std::function<StoredState(std::uint64_t id)> stored_state;
    std::function<void(History&)> read_history;  // all its steps; the first is the current one
    // Of steps that are captured again, because there is no file of them: as LiveOptions::codec of
    // the session.
    Codec codec = Codec::automatic;
    // The events that are replayed end before this step is left, or replaced; none: all.
    std::optional<StepId> to_step;
    // Called after each frame, with the number of frames so far. Return false to stop.
    std::function<bool(long frame, const Simulator&)> after_frame;
    std::function<void(const ReplayedHash&)> compared;  // for each hash in the log
};

// Replays events one by one. Use: add() for each, then the getters. Throws std::runtime_error if a
// command is refused, a frame fails or background tasks do not match.
class SessionReplay {
  public:
    SessionReplay(std::shared_ptr<const LiveScene> scene, ReplayOptions options);
    ~SessionReplay();
    SessionReplay(const SessionReplay&) = delete;

    bool add(const SessionEvent& event);  // false: the replay has stopped
    // Hashes may follow later frames in a log: give all of them before add().
    void expect(const HashEvent& hash);
    long frames() const;
    const Simulator& simulator() const;
    DocumentPtr document() const;
    const Scene& scene() const;  // built

  private:
    struct Work;
    std::unique_ptr<Work> work;
};

// The particles at the end of a log.
std::vector<Particle<double>> replayed(
    const SessionLog& log, const std::function<std::unique_ptr<Simulator>(const Setup&)>& make);

}  // namespace knead
