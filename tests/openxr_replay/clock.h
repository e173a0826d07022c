// The display's clock: frames at even times. Virtual, a frame is due at once; in real time the
// caller sleeps until it is.
#pragma once
#include <cmath>
#include <cstdint>

namespace knead::replay {

class FrameClock {
  public:
    FrameClock(double per_second, std::int64_t at) : rate(per_second), zero(at) {}
    // The next frame, and when it will be seen [ns]. `now` [ns] is 0 in virtual time; else frames
    // that can no longer be seen are left out.
    std::int64_t next(std::int64_t now)
    {
        ++frame;
        if (now > 0)
            while (time(frame) - period() < now - lead()) ++frame;
        return time(frame);
    }
    // The rate is another from the next frame on.
    void change(double per_second)
    {
        zero = time(frame) - std::int64_t(std::llround(double(frame) * 1e9 / per_second));
        rate = per_second;
    }
    std::int64_t period() const { return std::int64_t(std::llround(1e9 / rate)); }
    // From its being waited for to its being seen, of a frame in real time.
    std::int64_t lead() const { return period(); }
    std::int64_t time(std::int64_t of) const
    {
        return zero + std::int64_t(std::llround(double(of) * 1e9 / rate));
    }

  private:
    double rate;
    std::int64_t zero, frame = -1;
};

}  // namespace knead::replay
