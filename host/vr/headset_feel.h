// Haptic and acoustic feedback of a headset: vibration, and sound panned to the side of the hand.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "host/vr/cue_sound.h"
#include "host/vr/headset_hands.h"
#include "xr/sound.h"

namespace knead {

class HeadsetFeel {
  public:
    // `audible`: open a sound device; on failure `tell` is called with the reason.
    HeadsetFeel(bool audible, const std::function<void(const std::string&)>& notify);
    // Plays the feedback for the newest state. `strength`: vibration per side, 0 to 1.
    void frame(const HeadsetViews& views, const LiveState& state, HeadsetHands& hands,
               float strength[side_count]);

  private:
    CueSound cues;
    std::unique_ptr<SoundOut> sound;  // null: silent
};

}  // namespace knead
