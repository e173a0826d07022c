// Notices to the user during a headset session: messages, and temporary sentences on the panel.
#pragma once
#include <functional>
#include <string>
#include <utility>

#include "host/live/live_session.h"
#include "host/vr/headset_hands.h"

namespace knead {

// Text of a refusal without the position in it.
std::string short_refusal(const std::string& message);

class HeadsetNotices {
  public:
    using Report = std::function<void(const std::string&)>;
    // `shows`: on the panel, for some seconds.
    HeadsetNotices(Report by, Report shows) : notify(std::move(by)), show(std::move(shows)) {}

    // Reports a refusal since the state before, and a save that was written. Repetitions, as in
    // every frame while clay is carried against a wall, are reported once.
    void follow(const LiveState& state, double now);
    // Reports a message; "": none.
    void tell(const std::string& message);
    // Reports tracking that is too slow. Call after pushing the hands.
    void follow(const HeadsetHands& hands, double now);

  private:
    Report notify, show;
    int refused = 0;            // number of refusals reported
    std::string last_refusal;   // reported,
    double refused_at = -1e30;  // or repeated [s]
    bool unsaved = false;       // in the state before
    TrackingWatch tracking;
    bool too_slow = false;  // in the previous frame
};

}  // namespace knead
