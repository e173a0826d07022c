// What hands in a headset feel of the clay: vibration, and sound from the side where the hand is.
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
    // `audible`: where a device plays; otherwise `tell` is told why not.
    HeadsetFeel(bool audible, const std::function<void(const std::string&)>& tell);
    // Of what the newest state did: how strongly controllers vibrate.
    void frame(const HeadsetViews& sight, const LiveState& state, HeadsetHands& hands,
               float strength[side_count]);

  private:
    CueSound cues;
    std::unique_ptr<SoundOut> sound;  // null: nothing is heard
};

}  // namespace knead
