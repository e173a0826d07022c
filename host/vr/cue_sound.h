// Synthesis of sounds for contact with clay: a thud at contact, a low rustle while clay yields, a
// higher one while a blade cuts. Each hand is panned to its side.
#pragma once
#include <cstdint>
#include <vector>

#include "host/hands/hands.h"

namespace knead {

// Effect of a hand's tool on clay, for haptic and acoustic feedback.
enum class Feel { nothing, contact, yielding, cutting };

class CueSound {
  public:
    static constexpr int rate = 48000;  // samples a second

    // Sets the current feedback; a rustle fades unless set again within 60 ms. `right`: pan, from
    // -1 (left of the head) to 1 (right).
    void set(Side side, Feel feel, float right);
    // Appends the next `frames` pairs of samples, left and right, to `to`.
    void make(int frames, std::vector<std::int16_t>& to);

  private:
    // One hand. Levels are low-pass filtered to avoid clicks.
    struct Voice {
        float right = 0;
        float thud = 0, strike = 0, phase = 0;  // level; remaining onset; phase [turns]
        float yield = 0, cut = 0;               // levels
        int yield_left = 0, cut_left = 0;       // samples until they fade
        float low = 0, lower = 0, high = 0;     // states of the filters
    };
    float sample(Voice& voice);
    float noise();

    Voice voices[side_count];
    std::uint32_t random = 1;
};

}  // namespace knead
