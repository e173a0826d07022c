// How many pixels can be drawn in time.
#pragma once
#include <algorithm>
#include <cmath>

namespace knead {

class Pace {
  public:
    // Pictures take about `budget` [s] at most; `least` is the smallest share of a side's pixels.
    Pace(double budget, double least, double first) : budget_(budget), least_(least), scale_(first)
    {
    }
    double scale() const { return scale_; }  // share of a side's pixels, up to 1
    // What a picture of that scale took [s]. What lies near the budget changes nothing, so that the
    // picture does not waver: a step down or up leaves it there. Where two on end took too long,
    // the next has as many pixels as there is time for; one alone may have waited for something.
    void took(double seconds)
    {
        const double both = std::min(seconds, before_);
        before_ = seconds;
        if (both > 1.2 * budget_)
            set(std::max(least_, std::min(0.75, std::sqrt(budget_ / both)) * scale_));
        else if (seconds < 0.6 * budget_)
            set(std::min(1.0, 1.2 * scale_));
    }

  private:
    void set(double scale) { scale_ = scale, before_ = 0; }

    double budget_, least_, scale_;
    double before_ = 0;  // what the last picture of this scale took [s]
};

}  // namespace knead
