// Session clock of a window: wall time, without pauses.
#pragma once
#include <mutex>

#include "host/base/machine.h"

namespace knead {

class WindowClock {
  public:
    // Monotonic. All functions are thread-safe.
    double now() const  // [s]
    {
        const std::lock_guard lock(mutex_);
        return at_ + (runs_ ? wall_seconds() - since_ : 0);
    }
    void run(bool on)
    {
        const std::lock_guard lock(mutex_);
        const double wall = wall_seconds();
        if (runs_) at_ += wall - since_;
        since_ = wall, runs_ = on;
    }
    void add(double seconds)
    {
        const std::lock_guard lock(mutex_);
        at_ += seconds;
    }

  private:
    mutable std::mutex mutex_;
    double at_ = 0, since_ = 0;
    bool runs_ = false;
};

}  // namespace knead
