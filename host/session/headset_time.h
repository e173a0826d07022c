// The simulation's time in a headset: that of the frames as they are seen, standing still while
// nobody sees them.
#pragma once
#include <atomic>
#include <cmath>

namespace knead {

class SessionTime {
  public:
    // `rate`: frames of the simulation per second. A time within a microsecond of the end of one is
    // put on it: displays count nanoseconds, and a recording of these times is then replayed to the
    // bit.
    explicit SessionTime(double rate) : frames_per_second(rate) {}

    // The frame that is seen at `display` [s]. `runs`: time has gone on since the frame before.
    // Answers the session's time [s].
    double frame(double display, bool runs)
    {
        if (runs && known && display > last) raw += display - last;
        known = true;
        last = display;
        const double whole = std::round(raw * frames_per_second);
        const bool near = std::abs(raw * frames_per_second - whole) < 1e-6 * frames_per_second;
        return now = near ? whole / frames_per_second : raw;
    }
    double time() const { return now; }  // [s]

  private:
    double frames_per_second;
    double raw = 0, last = 0, now = 0;  // [s]
    bool known = false;
};

// What a simulation in real time takes its time from: the frame's, going on with the wall until the
// next one, but for no longer than a frame. Any thread may read it.
class DisplayClock {
  public:
    // From now on `wall` [s] the time is `time`, `period` [s] from the next.
    void set(double time, double wall, double period)
    {
        at.store(time), since.store(wall), most.store(period);
    }
    double now(double wall) const
    {
        const double gone = wall - since.load();
        return at.load() + (gone < 0 ? 0 : gone < most.load() ? gone : most.load());
    }

  private:
    std::atomic<double> at = 0, since = 0, most = 0;
};

}  // namespace knead
