#include "host/vr/headset_feel.h"

namespace knead {

HeadsetFeel::HeadsetFeel(bool audible, const std::function<void(const std::string&)>& notify)
{
    std::string silent;
    if (audible) sound = SoundOut::open(silent);
    if (!silent.empty()) notify("no sound: " + silent);
}

void HeadsetFeel::frame(const HeadsetViews& views, const LiveState& state, HeadsetHands& hands,
                        float strength[side_count])
{
    constexpr float aside = 0.4f;  // distance from the head for full pan [m]
    Feel felt[side_count];
    hands.feel(state, felt);
    const Joint<float> head = head_of(views);
    for (const Side side : {left, right}) {
        strength[side] = strength_of(felt[side]);
        const Hand& hand = views.hands[std::size_t(side)].hand;
        const Vec3<float> off = rotate(conjugate(head.q), hand.joints[index_tip].p - head.p);
        cues.set(side, felt[side], off.x / aside);
    }
    if (sound)
        sound->fill([this](int pairs, std::vector<std::int16_t>& to) { cues.make(pairs, to); });
}

}  // namespace knead
