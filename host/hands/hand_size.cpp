#include "host/hands/hand_size.h"

#include <algorithm>
#include <cmath>

namespace knead {
namespace {

constexpr double size_memory = 2;                          // [s]
constexpr double smallest_hand = 0.6, largest_hand = 1.6;  // relative hand size: a child, a giant
constexpr double thinnest = 0.8, thickest = 1.25;          // finger thickness relative to length
constexpr float largest_radius = 0.05f;                    // [m]
constexpr float same_radius = 1e-5f;                       // [m]

// Trackers define the radius differently. Sum over the default hand's joints below, whose distance
// to the skin is as in open_hand(), as a Quest reports it [m]:
constexpr double reported_radii = 0.1217;

// Bones whose length is consistent between trackers; metacarpals and tips are not.
constexpr JointName finger_bones[][2] = {
    {thumb_metacarpal, thumb_proximal},     {thumb_proximal, thumb_distal},
    {index_proximal, index_intermediate},   {index_intermediate, index_distal},
    {middle_proximal, middle_intermediate}, {middle_intermediate, middle_distal},
    {ring_proximal, ring_intermediate},     {ring_intermediate, ring_distal},
    {little_proximal, little_intermediate}, {little_intermediate, little_distal},
};
constexpr JointName finger_joints[] = {thumb_proximal,      thumb_distal,  index_proximal,
                                       index_intermediate,  index_distal,  middle_proximal,
                                       middle_intermediate, middle_distal, ring_proximal,
                                       ring_intermediate,   ring_distal,   little_proximal,
                                       little_intermediate, little_distal};

bool know_bones(const Hand& hand)
{
    const auto known = [&](JointName j) {
        const Vec3<float> p = hand.joints[j].p;
        return hand.valid[j] && std::isfinite(dot(p, p));
    };
    return std::all_of(std::begin(finger_bones), std::end(finger_bones),
                       [&](const auto& bone) { return known(bone[0]) && known(bone[1]); });
}

double bone_lengths(const Hand& hand)
{
    double sum = 0;
    for (const auto& bone : finger_bones)
        sum += length(cast<double>(hand.joints[bone[1]].p) - cast<double>(hand.joints[bone[0]].p));
    return sum;
}

double finger_radii(const Hand& hand)
{
    double sum = 0;
    for (const JointName j : finger_joints) sum += hand.radius[j];
    return sum;
}

// Finger thickness relative to the default hand, for a hand whose bones are `along` times as long.
// Deviations within the trackers' differences of definition count as none.
double thickness(const Hand& hand, double along)
{
    static const double usual = finger_radii(open_hand(right));
    const double low = finger_radii(hand) / (along * usual),
                 high = finger_radii(hand) / (along * reported_radii);
    const double share = low < 1 ? low : std::max(high, 1.0);
    return along * clamp(share, thinnest, thickest);
}

}  // namespace

double bone_ratio(const Hand& hand)
{
    static const double usual = bone_lengths(open_hand(right));
    if (!know_bones(hand)) return 0;
    return clamp(bone_lengths(hand) / usual, smallest_hand, largest_hand);
}

bool radii_known(const Hand& hand)
{
    float low = largest_radius, high = 0;
    for (int j = 0; j < joint_count; ++j) {
        if (!hand.valid[j]) continue;
        const float r = hand.radius[j];
        if (!(r > 0 && r < largest_radius)) return false;  // also false for NaN
        low = std::min(low, r), high = std::max(high, r);
    }
    return high - low > same_radius;
}

void HandSize::see(const Hand& hand, double duration)
{
    const double along = bone_ratio(hand);
    if (!(along > 0 && duration >= 0)) return;
    const double across = radii_known(hand) ? thickness(hand, along) : along;
    const double share = seen_ > 0 ? duration / std::min(seen_ + duration, size_memory) : 1;
    seen_ = std::min(seen_ + std::max(duration, 1e-3), size_memory);
    along_ += std::min(share, 1.0) * (along - along_);
    across_ += std::min(share, 1.0) * (across - across_);
}

Stretch<float> HandSize::stretch() const
{
    const auto stepped = [](double x) { return float(std::round(1024 * x) / 1024); };
    return {stepped(across_), stepped(along_)};
}

}  // namespace knead
