// Notices to the user during a headset session: messages, and temporary sentences on the panel.
#pragma once
#include <functional>
#include <string>
#include <utility>

#include "host/live/live_session.h"
#include "host/vr/headset_hands.h"

namespace knead {

// A sentence that is shown for some seconds.
class Notice {
  public:
    static constexpr double lasting = 5;  // [s]

    // `now`: ascending time [s]. Replaces the current sentence.
    void show(std::string words, double now) { text = std::move(words), since = now; }
    // "" after `lasting`.
    std::string at(double now) const { return now - since < lasting ? text : std::string(); }

  private:
    std::string text;
    double since = -1e30;  // [s]
};

// Text of a refusal without the position in it.
std::string short_refusal(const std::string& message);

class HeadsetNotices {
  public:
    explicit HeadsetNotices(std::function<void(const std::string&)> by) : notify(std::move(by)) {}

    // Reports a refusal since the state before, and a save that was written. Repetitions, as in
    // every frame while clay is carried against a wall, are reported once.
    void follow(const LiveState& state, double now);
    // Reports a message; "": none.
    void tell(const std::string& message, double now);
    // Reports tracking that is too slow. Call after pushing the hands.
    void follow(const HeadsetHands& hands, double now);
    std::string at(double now) const { return notice.at(now); }

  private:
    std::function<void(const std::string&)> notify;
    Notice notice;
    int refused = 0;       // number of refusals reported
    bool unsaved = false;  // in the state before
    TrackingWatch tracking;
    bool too_slow = false;  // in the previous frame
};

}  // namespace knead
