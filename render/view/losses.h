// Counts losses of the OpenGL context, which a driver may reset at any time.
#pragma once
#include <algorithm>
#include <array>

namespace knead {

class ContextLosses {
  public:
    static constexpr int most = 3;        // within `window`
    static constexpr double window = 10;  // [s]

    // Counts a loss at `time` [s]. Returns true if more than `most` occurred within `window`:
    // another context would be lost as well.
    bool too_many(double time)
    {
        ++count_;
        std::rotate(last_.begin(), last_.begin() + 1, last_.end());
        last_.back() = time;
        return time - last_.front() < window;
    }
    int count() const { return count_; }

  private:
    std::array<double, most + 1> last_{-1e30, -1e30, -1e30, -1e30};
    int count_ = 0;
};

}  // namespace knead
