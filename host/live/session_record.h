// Recording of a session in a headset or a window since the last load or reset: hands as the
// simulation received them, and the other actions.
#pragma once
#include <functional>
#include <string>

#include "host/live/live_session.h"

namespace knead {

class SessionRecord {
  public:
    // `by`: receives messages for the user.
    explicit SessionRecord(std::function<void(const std::string&)> by) : notify(std::move(by)) {}

    // Starts a new recording at `now` [s of the session] and discards the previous one.
    void begin(const LiveScene& scene, double now);
    // Cause of the next begin(): "scene" or "reset".
    void begins_by(const std::string& act) { began_by = act; }
    // Records hands pushed to the simulation at `now` [s]; false if not later than the last frame.
    bool frame(HandFrame given, double now);
    // The simulation has reached `now` [s]; later actions are recorded with this time.
    void simulated(double now) { done_to = now; }
    void act(HandAction done);
    void pause(bool on);

    Recording hands;
    HandActions actions;

  private:
    std::function<void(const std::string&)> notify;
    std::string began_by;           // "": the program's start
    double began = 0, done_to = 0;  // of the session [s]
    bool hands_full = false, actions_full = false;
};

}  // namespace knead
