// Chooses the picture resolution that meets a time budget.
#pragma once
#include <algorithm>
#include <cmath>

namespace knead {

class Pace {
  public:
    // Time budget of a picture [s], smallest and initial scale.
    Pace(double budget, double least, double first) : budget_(budget), least_(least), scale_(first)
    {
    }
    double scale() const { return scale_; }  // fraction of the pixels of a side, at most 1
    // Records the time of a picture at scale() [s]. Times near the budget leave the scale unchanged
    // (hysteresis). Two consecutive pictures over 1.2 budgets lower it to fit, because a single one
    // may be a stall; one below 0.6 budgets raises it by 20 %. If fewer pixels are not faster, as
    // with splats crowded into few tiles, the previous scale is restored and kept for `patience`
    // slow pictures.
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
    double before_ = 0;  // time of the last picture at this scale [s]
    Taken larger_;       // before the last step down
    int patient_ = 0;    // slow pictures still tolerated
};

}  // namespace knead
