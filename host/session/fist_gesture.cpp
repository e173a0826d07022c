#include "host/session/fist_gesture.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace knead {
namespace {

// The tips of the four fingers; the chain runs from the wrist over the metacarpal's end to the tip.
constexpr JointName tips[] = {index_tip, middle_tip, ring_tip, little_tip};

// Distance from wrist to tip, divided by the length along the bones: near 1 for a flat hand.
std::optional<float> straightness(const Hand& hand, JointName tip)
{
    if (!hand.tracked || !hand.valid[wrist]) return {};
    float way = length(hand.joints[tip - 3].p - hand.joints[wrist].p);
    for (int j = tip - 3; j <= tip; ++j) {
        if (!hand.valid[std::size_t(j)]) return {};
        if (j > tip - 3) way += length(hand.joints[j].p - hand.joints[j - 1].p);
    }
    if (!(way > 0.02f)) return {};
    return length(hand.joints[tip].p - hand.joints[wrist].p) / way;
}

// Category of the clay nearest to a point, if any is nearer than `reach` [m].
std::optional<int> nearest_clay(Vec3<double> point, const std::vector<Mesh>& clay, double reach)
{
    std::optional<int> category;
    for (const Mesh& mesh : clay)
        for (const Vec3<float>& at : mesh.vertices) {
            const double far = length(cast<double>(at) - point);
            if (far < reach) reach = far, category = mesh.category;
        }
    return category;
}

// From a straightness.
float closed(float straight)
{
    constexpr float flat = 0.98f, fist = 0.5f;
    return clamp((flat - straight) / (flat - fist), 0.f, 1.f);
}

}  // namespace

float closure(const Hand& hand)
{
    float sum = 0;
    for (const JointName tip : tips) {
        const std::optional<float> one = straightness(hand, tip);
        if (!one) return 0;
        sum += *one / 4;
    }
    return closed(sum);
}

float closure(const Hand& hand, JointName tip)
{
    const std::optional<float> one = straightness(hand, tip);
    return one ? closed(*one) : 0;
}

void FistGesture::close(const HandFrame& hands)
{
    for (int side = 0; side < side_count; ++side) {
        const float now = closure(hands.hand[side]);
        fist[std::size_t(side)] = now > (fist[std::size_t(side)] ? opens : closes);
    }
}

FistGesture::Answer FistGesture::frame(const HandFrame& hands, const HandsOptions& options,
                                       const std::vector<Mesh>& clay)
{
    close(hands);
    Answer answer;
    if (fist[left] && fist[right] && !holding) return answer;
    if (!holding) by = fist[left] ? left : right;
    answer.by = by;
    if (!fist[std::size_t(by)]) {
        answer.let_go = std::exchange(holding, false);
        return answer;
    }
    if (holding) return answer;
    const Vec3<double> palm_at = cast<double>(hands.hand[by].joints[palm].p);
    answer.took =
        nearest_clay(options.at + options.zoom * palm_at, clay, options.zoom * double(reach));
    holding = answer.took.has_value();
    return answer;
}

}  // namespace knead
