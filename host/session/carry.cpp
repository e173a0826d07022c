#include "host/session/carry.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

float closure(const Hand& hand)
{
    constexpr float flat = 0.98f, fist = 0.5f;  // straightness
    float sum = 0;
    for (const JointName tip : tips) {
        const std::optional<float> one = straightness(hand, tip);
        if (!one) return 0;
        sum += *one / 4;
    }
    return clamp((flat - sum) / (flat - fist), 0.f, 1.f);
}

void Carry::close(const HandFrame& hands)
{
    for (int side = 0; side < side_count; ++side) {
        const float now = closure(hands.hand[side]);
        fist[std::size_t(side)] = now > (fist[std::size_t(side)] ? opens : closes);
    }
}

Carry::Answer Carry::carry(const Joint<double>& palm, const std::vector<Mesh>& clay, double nearest)
{
    Answer answer;
    if (!category) {
        for (const Mesh& mesh : clay)
            for (const Vec3<float>& at : mesh.vertices) {
                const double far = length(cast<double>(at) - palm.p);
                if (far < nearest) nearest = far, category = mesh.category;
            }
        answer.took = category.has_value();
        last = palm;
    }
    if (!category) return answer;
    answer.category = category;
    const Quat<double> turn = unit(palm.q * conjugate(last->q));
    answer.motion = {turn, palm.p - rotate(turn, last->p)};
    last = palm;
    return answer;
}

Carry::Answer Carry::frame(const HandFrame& hands, const HandsOptions& options,
                           const std::vector<Mesh>& clay)
{
    close(hands);
    const bool both = fist[left] && fist[right];
    Answer answer;
    if (both && !holds()) {
        const double now = length(
            cast<double>(hands.hand[right].joints[palm].p - hands.hand[left].joints[palm].p));
        if (apart > 0.02 && now > 0.02) answer.zoom = clamp(now / apart, 0.8, 1.25);
        apart = now;
        return answer;
    }
    apart = 0;
    if (!holds()) by = fist[left] ? left : right;
    if (!fist[std::size_t(by)]) {
        answer.let_go = holds();
        category.reset();
        return answer;
    }
    const Joint<float>& at = hands.hand[by].joints[palm];
    const Joint<double> placed{unit(cast<double>(at.q)),
                               options.at + options.zoom * cast<double>(at.p)};
    return carry(placed, clay, options.zoom * reach);
}

}  // namespace knead
