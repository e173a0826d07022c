// The simulation's time in a headset: that of the frames as they are seen, standing still while
// nobody sees them.
#pragma once
#include <atomic>
#include <cmath>
#include <limits>

namespace knead {

class SessionTime {
  public:
    // `rate`: frames of the simulation per second. A time within a microsecond of the end of one is
    // put on it: displays count nanoseconds, and a recording of these times is then replayed to the
    // bit. `most`: time that a frame of the display may add [s].
    explicit SessionTime(double rate, double most = std::numeric_limits<double>::infinity())
        : frames_per_second(rate), most_added(most)
    {
    }

    // The frame that is seen at `display` [s]. `runs`: time has gone on since the frame before.
    // Answers the session's time [s].
    double frame(double display, bool runs)
    {
        if (runs && known && display > last) {
            raw += std::fmin(display - last, most_added);
            left += std::fmax(0.0, display - last - most_added);
        }
        known = true;
        last = display;
        const double whole = std::round(raw * frames_per_second);
        const bool near = std::abs(raw * frames_per_second - whole) < 1e-6 * frames_per_second;
        return now = near ? whole / frames_per_second : raw;
    }
    double time() const { return now; }       // [s]
    double left_out() const { return left; }  // display time beyond `most` [s]

  private:
    double frames_per_second, most_added;
    double raw = 0, last = 0, now = 0, left = 0;  // [s]
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
