#include "host/vr/hand_act.h"

#include <algorithm>
#include <cmath>

#include "host/hands/posture.h"
#include "host/session/fist_gesture.h"
#include "host/vr/panel_place.h"

namespace knead {
namespace {

Vec3<double> joint(const Hand& hand, JointName name) { return cast<double>(hand.joints[name].p); }

// Between the tips, in the palm's frame, of the default hand that pinches: where a hand around a
// controller holds what it takes, however far the trigger is pulled.
Vec3<double> usual_pinch(Side side)
{
    static const auto of = [](Side s) {
        const Pose pose = posed(s, {{1, 0, 0, 0}, {0, 0, 0}}, pinched(s));
        return rotate(conjugate(unit(pose[palm].q)),
                      0.5 * (pose[thumb_tip].p + pose[index_tip].p) - pose[palm].p);
    };
    static const Vec3<double> both[side_count] = {of(left), of(right)};
    return both[side];
}

Vec3<double> unit_vector(Vec3<double> v)
{
    const double size = length(v);
    return size > 1e-9 ? (1 / size) * v : Vec3<double>{0, 0, -1};
}

// Away from the shoulder, which keeps its place below the head, whatever the head looks at.
Vec3<double> from_shoulder(Side side, Vec3<double> at, const Joint<float>& head)
{
    const Vec3<float> gaze = rotate(unit(head.q), Vec3<float>{0, 0, -1});
    const double heading = std::atan2(double(-gaze.x), double(-gaze.z));
    Vec3<double> off = cast<double>(shoulder_from_eyes);
    if (side == left) off.x = -off.x;
    return unit_vector(at - cast<double>(head.p) -
                       rotate(turn_about(Vec3<double>{0, 1, 0}, heading), off));
}

}  // namespace

std::optional<double> tips_apart(const Hand& hand)
{
    if (!hand.tracked || !hand.valid[thumb_tip] || !hand.valid[index_tip]) return {};
    return length(joint(hand, thumb_tip) - joint(hand, index_tip));
}

std::optional<FingerRing> finger_ring(const Hand& hand)
{
    constexpr JointName around[] = {thumb_proximal, thumb_distal,       thumb_tip,     index_tip,
                                    index_distal,   index_intermediate, index_proximal};
    constexpr double count = std::size(around);
    if (!hand.tracked) return {};
    FingerRing ring;
    double skin = 0;
    for (const JointName name : around) {
        if (!hand.valid[name]) return {};
        ring.centre = ring.centre + (1 / count) * joint(hand, name);
        skin += double(hand.radius[name]) / count;
    }
    Vec3<double> normal{};
    double distance = 0;
    for (std::size_t i = 0; i < std::size(around); ++i) {
        const Vec3<double> a = joint(hand, around[i]) - ring.centre,
                           b = joint(hand, around[(i + 1) % std::size(around)]) - ring.centre;
        normal = normal + cross(a, b);
        distance += length(a) / count;
    }
    ring.axis = unit_vector(normal);
    ring.diameter = 2 * std::max(0.0, distance - skin);
    return ring;
}

HandAct HandReader::frame(Side side, const TrackedHand& found, const Joint<float>& head)
{
    HandAct act;
    const Hand& hand = found.hand;
    act.by_controller = found.from == HandFrom::posed || found.from == HandFrom::controller;
    act.tracked = hand.tracked && hand.valid[palm];
    if (!act.tracked) return act;
    const auto beyond = [](bool now, float value) { return value > (now ? lets : pulls); };
    // A trigger closes fingers, too, but does not make a fist.
    fist_ = act.by_controller ? beyond(fist_, found.grasp)
                              : closure(hand) > (fist_ ? no_fist : fist) &&
                                    closure(hand, index_tip) > (fist_ ? no_fist_index : fist_index);
    const auto apart = tips_apart(hand);
    const bool tips = !act.by_controller && apart && *apart < (pinches_ ? opens : closes);
    pinches_ = !fist_ && (tips || (act.by_controller && beyond(pinches_, found.pinch)));
    act.pinches = pinches_, act.fist = fist_;
    const Joint<double> middle{unit(cast<double>(hand.joints[palm].q)), joint(hand, palm)};
    act.at.q = middle.q;
    if (!act.by_controller && apart) {
        act.at.p = 0.5 * (joint(hand, thumb_tip) + joint(hand, index_tip));
        act.ring = finger_ring(hand);
    } else {
        act.at.p = middle.p + rotate(middle.q, usual_pinch(side));
    }
    act.lower = found.lower, act.upper = found.upper;
    act.ray = found.aim ? rotate(unit(cast<double>(found.aim->q)), Vec3<double>{0, 0, -1})
                        : from_shoulder(side, act.at.p, head);
    return act;
}

}  // namespace knead
