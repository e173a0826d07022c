// Simulation time in a headset: follows the display times of frames and pauses while the session is
// not visible.
#pragma once
#include <atomic>
#include <cmath>
#include <limits>

namespace knead {

class SessionTime {
  public:
    // `rate`: simulation frames per second. Times within a microsecond of the end of a frame are
    // rounded to it, because displays count nanoseconds: recordings then replay bit for bit.
    // `most`: largest time that a display frame adds [s].
    explicit SessionTime(double rate, double most = std::numeric_limits<double>::infinity())
        : frames_per_second(rate), most_added(most)
    {
    }

    // Call for each frame with its display time [s]. `runs`: time advances since the frame before.
    // Returns the session's time [s].
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

// Clock of a real-time simulation: time of the last frame plus the wall time since, at most one
// period. now() is thread-safe.
class DisplayClock {
  public:
    // At wall time `wall` the time is `time`; the next frame follows after `period` [s].
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
