// How large a tracked hand is against the default one, from the lengths of its bones and the radii
// that the tracker reports. docs/method/hands.md, "Size".
#pragma once
#include "host/hands/hands.h"

namespace knead {

// Lengths of the fingers' bones over those of the default hand, within what hands are; 0 where a
// joint between them is not known.
double bone_ratio(const Hand& hand);

// Whether a tracker knows the radii of the valid joints: not impossible ones, nor the same for all.
bool radii_known(const Hand& hand);

// What frames of one hand say of its size, the last two seconds most. Noise and lost joints do not
// move it much; it is kept while the hand is out of sight.
class HandSize {
  public:
    // A tracked frame, unfiltered, that lasted `duration` [s].
    void see(const Hand& hand, double duration);
    // Of a rig of the default hand: in steps of 1/1024, so that a default hand has 1.
    Stretch<float> stretch() const;

  private:
    double across_ = 1, along_ = 1;
    double seen_ = 0;  // for so long, as far as it counts [s]
};

}  // namespace knead
