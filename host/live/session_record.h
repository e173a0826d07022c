// Recording of a session in a headset or a window since the last load or reset: hands as the
// simulation received them, and the commands that were applied.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/document/command_text.h"
#include "host/live/live_session.h"

namespace knead {

class SessionRecord {
  public:
    // `by`: receives messages for the user.
    explicit SessionRecord(std::function<void(const std::string&)> by) : notify(std::move(by)) {}

    // Starts a new recording at `now` [s of the session] and discards the previous one. `history`:
    // LiveState::history.
    void begin(const LiveScene& scene, int history, double now);
    // Records hands pushed to the simulation at `now` [s]; false if not later than the last frame.
    bool frame(HandFrame given, double now);
    // Adds what LiveSession::take_applied() returned. Commands of a history that has not begun here
    // are kept for it.
    void add(std::vector<AppliedCommand> applied);

    Recording hands;
    // Frames are those of a run that plays the recorded hands.
    CommandLog commands;

  private:
    void put(const AppliedCommand& applied);

    std::function<void(const std::string&)> notify;
    std::vector<AppliedCommand> waiting;  // of later histories
    int history = 0;
    double began = 0, rate = 90;  // of the session [s]; frames per second
    bool hands_full = false, commands_full = false;
};

}  // namespace knead
