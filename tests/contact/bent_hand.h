// Hands with bent fingers, for the tests of what follows them.
#pragma once
#include "host/hands/hands.h"

namespace knead {

// The hand with every finger joint turned by `angle` [rad] towards the palm, the thumb's by half.
inline Hand flexed(Hand hand, float angle)
{
    const int chains[5][2] = {{thumb_proximal, thumb_tip},
                              {index_proximal, index_tip},
                              {middle_proximal, middle_tip},
                              {ring_proximal, ring_tip},
                              {little_proximal, little_tip}};
    for (const auto& chain : chains)
        for (int j = chain[0]; j < chain[1]; ++j) {
            const Joint<float> about = hand.joints[j];
            const float share = chain[0] == thumb_proximal ? 0.5f : 1;
            const Quat<float> local = turn_about(Vec3<float>{1, 0, 0}, -share * angle);
            const Quat<float> turn = about.q * local * conjugate(about.q);
            for (int k = j; k <= chain[1]; ++k) {
                Joint<float>& moved = hand.joints[k];
                moved = {unit(turn * moved.q), about.p + rotate(turn, moved.p - about.p)};
            }
        }
    return hand;
}

constexpr float degree = 3.14159265f / 180;

}  // namespace knead
