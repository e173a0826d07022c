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
    // Where fewer pixels took no less, as splats do that crowd into few tiles, there are as many as
    // before again, for `patience` pictures that take too long.
    void took(double seconds)
    {
        const double both = std::min(seconds, before_);
        before_ = seconds;
        if (both > 1.2 * budget_)
            too_long(both);
        else if (seconds <= 1.2 * budget_)
            larger_ = {};
        if (seconds < 0.6 * budget_) patient_ = 0, set(std::min(1.0, 1.2 * scale_));
    }

  private:
    static constexpr int patience = 100;
    struct Taken {
        double scale = 0, seconds = 0;
    };

    void too_long(double seconds)
    {
        if (patient_ > 0 && --patient_ > 0) return;
        if (larger_.scale > scale_ && seconds >= 0.95 * larger_.seconds) {
            patient_ = patience;
            set(larger_.scale), larger_ = {};
            return;
        }
        larger_ = {scale_, seconds};
        set(std::max(least_, std::min(0.75, std::sqrt(budget_ / seconds)) * scale_));
    }
    void set(double scale) { scale_ = scale, before_ = 0; }

    double budget_, least_, scale_;
    double before_ = 0;  // what the last picture of this scale took [s]
    Taken larger_;       // before the last step down
    int patient_ = 0;    // pictures that may still take too long
};

}  // namespace knead
