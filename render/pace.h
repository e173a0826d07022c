// How many pixels can be drawn in time.
#pragma once
#include <algorithm>

namespace knead {

class Pace {
  public:
    // Pictures take about `budget` [s] at most; `least` is the smallest share of a side's pixels.
    Pace(double budget, double least, double first) : budget_(budget), least_(least), scale_(first)
    {
    }
    double scale() const { return scale_; }  // share of a side's pixels, up to 1
    // What a picture of that scale took [s]. What lies near the budget changes nothing, so that the
    // picture does not waver: a step down or up leaves it there.
    void took(double seconds)
    {
        if (seconds > 1.2 * budget_) scale_ = std::max(least_, 0.75 * scale_);
        if (seconds < 0.6 * budget_) scale_ = std::min(1.0, 1.2 * scale_);
    }

  private:
    double budget_, least_, scale_;
};

}  // namespace knead
