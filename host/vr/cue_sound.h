// What hands do to clay, made audible sample by sample: a thud where a tool comes to it, a low
// rustle while it yields, a higher one while a blade cuts. Each hand is heard from its side.
#pragma once
#include <cstdint>
#include <vector>

#include "host/hands/hands.h"

namespace knead {

// What a hand's tool does to clay, as its side feels and hears it.
enum class Feel { nothing, contact, yielding, cutting };

class CueSound {
  public:
    static constexpr int rate = 48000;  // samples a second

    // From now on; a rustle ends by itself where it is not told again within 60 ms. `right`: how
    // far the hand is to the right of the head, -1 to 1.
    void set(Side side, Feel feel, float right);
    // The next `frames` pairs, left and right, behind what is in `to`.
    void make(int frames, std::vector<std::int16_t>& to);

  private:
    // Of one hand. Levels follow what they are to be, so that nothing clicks.
    struct Voice {
        float right = 0;
        float thud = 0, strike = 0, phase = 0;  // how loud; what is left of its onset; [turns]
        float yield = 0, cut = 0;               // how loud
        int yield_left = 0, cut_left = 0;       // samples until they fade
        float low = 0, lower = 0, high = 0;     // of the filters
    };
    float sample(Voice& voice);
    float noise();

    Voice voices[side_count];
    std::uint32_t random = 1;
};

}  // namespace knead
