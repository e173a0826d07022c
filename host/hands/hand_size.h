// Size of a tracked hand relative to the default hand, from the bone lengths and the radii that the
// tracker reports. docs/method/hands.md, "Size".
#pragma once
#include "host/hands/hands.h"

namespace knead {

// Ratio of the total finger bone length to that of the default hand, clamped to human range; 0 if a
// joint between these bones is unknown.
double bone_ratio(const Hand& hand);

// True if the radii of the valid joints are measurements: plausible, and not all equal.
bool radii_known(const Hand& hand);

// Size estimate of one hand, dominated by the last two seconds. Robust against noise and lost
// joints; kept while the hand is out of sight.
class HandSize {
  public:
    // Adds a tracked, unfiltered frame that lasted `duration` [s].
    void see(const Hand& hand, double duration);
    // Scale of a rig of the default hand, in steps of 1/1024, so that a default hand has exactly 1.
    Stretch<float> stretch() const;

  private:
    double across_ = 1, along_ = 1;
    double seen_ = 0;  // observed time, capped at the averaging window [s]
};

}  // namespace knead
