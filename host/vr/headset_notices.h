// What people are told while a session in a headset goes on: by a message, and on the panel by a
// sentence that passes.
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

    // `now` [s] of a clock that rises. A later sentence replaces the one before.
    void show(std::string words, double now) { text = std::move(words), since = now; }
    // "" where there is none any more.
    std::string at(double now) const { return now - since < lasting ? text : std::string(); }

  private:
    std::string text;
    double since = -1e30;  // [s]
};

// Of a refusal: without the place that its message names.
std::string short_refusal(const std::string& message);

class HeadsetNotices {
  public:
    explicit HeadsetNotices(std::function<void(const std::string&)> by) : tell(std::move(by)) {}

    // That something was refused, since the state before. While clay is carried against a wall that
    // is so in every frame: it is told once.
    void follow(const LiveState& state, double now);
    // That hands are tracked too seldom to shape, once they were pushed.
    void follow(const HeadsetHands& hands, double now);
    std::string at(double now) const { return notice.at(now); }

  private:
    std::function<void(const std::string&)> tell;
    Notice notice;
    int refused = 0;  // commands that were, and of which was told
    TrackingWatch tracking;
    bool too_slow = false;  // so it was in the frame before
};

}  // namespace knead
