// What is kept of a session in a headset or a window: hands as the simulation had them, and what
// was done beside them, since the clay's history began.
#pragma once
#include <functional>
#include <string>

#include "host/live/live_session.h"

namespace knead {

class SessionRecord {
  public:
    // `tell`: messages for people.
    explicit SessionRecord(std::function<void(const std::string&)> by) : tell(std::move(by)) {}

    // A history of `scene` begins at `now` [s of the session]; what was of the one before goes.
    void begin(const LiveScene& scene, double now);
    void begins_by(const std::string& act) { began_by = act; }  // the next: "scene", "reset"
    // Hands that the simulation is given for `now`; false where that is no later than the last.
    bool frame(HandFrame given, double now);
    // The simulation has gone on to there: what is done from now on is done after that.
    void simulated(double now) { done_to = now; }
    void act(HandAction done);
    void pause(bool on);

    Recording hands;
    HandActions actions;

  private:
    std::function<void(const std::string&)> tell;
    std::string began_by;           // "": the program's start
    double began = 0, done_to = 0;  // of the session [s]
    bool hands_full = false, actions_full = false;
};

}  // namespace knead
