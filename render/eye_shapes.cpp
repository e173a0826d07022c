#include "render/eye_shapes.h"

namespace knead {
std::vector<DrawnHand> gather_hands(Geometry& geometry, const std::vector<HandLook>& hands)
{
    std::vector<DrawnHand> drawn;
    for (const HandLook& hand : hands) drawn.push_back({add_hand(geometry, hand), hand.opacity});
    return drawn;
}

}  // namespace knead
