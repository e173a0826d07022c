#include "host/ui/grab_gesture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

// [rad], 0 to pi.
double angle_of(const Quat<double>& q)
{
    return 2 * std::atan2(length(Vec3<double>{q.x, q.y, q.z}), std::abs(q.w));
}

// The shortest turn from one direction to another.
Quat<double> turn_between(Vec3<double> a, Vec3<double> b)
{
    const double size = length(a) * length(b);
    const double cosine = dot(a, b) / size;
    if (cosine < -0.999999) {
        const Vec3<double> u = orthogonal((1 / length(a)) * a);
        return {0, u.x, u.y, u.z};
    }
    const Vec3<double> axis = (1 / size) * cross(a, b);
    return unit(Quat<double>{1 + cosine, axis.x, axis.y, axis.z});
}

// The angle of a turn about a unit axis.
double about(const Quat<double>& q, Vec3<double> axis)
{
    const double half = std::atan2(dot(Vec3<double>{q.x, q.y, q.z}, axis), q.w);
    return std::remainder(2 * half, 2 * std::numbers::pi);
}

}  // namespace

Similarity then(const Similarity& a, const Similarity& b)
{
    return {a.scale * b.scale, unit(b.turn * a.turn), b.at(a.by)};
}

Similarity motion_between(const Joint<double>& from, const Joint<double>& to)
{
    Similarity motion;
    motion.turn = unit(to.q * conjugate(from.q));
    motion.by = to.p - rotate(motion.turn, from.p);
    return motion;
}

Similarity motion_between(const Joint<double> (&from)[side_count],
                          const Joint<double> (&to)[side_count])
{
    constexpr double least = 0.001;  // distance of the points that has a direction [m]
    const Vec3<double> a = from[right].p - from[left].p, b = to[right].p - to[left].p;
    const Vec3<double> middle = 0.5 * (from[left].p + from[right].p),
                       now = 0.5 * (to[left].p + to[right].p);
    Similarity motion;
    if (length(a) > least && length(b) > least) {
        const Quat<double> tilt = turn_between(a, b);
        const Vec3<double> axis = (1 / length(b)) * b;
        double twist = 0;
        for (const Side side : {left, right})
            twist += 0.5 * about(to[side].q * conjugate(tilt * from[side].q), axis);
        motion.turn = unit(turn_about(axis, twist) * tilt);
        motion.scale = length(b) / length(a);
    }
    motion.by = now - motion.scale * rotate(motion.turn, middle);
    return motion;
}

Similarity GrabGesture::motion() const
{
    if (held_[left] && held_[right]) return then(before_, motion_between(from_, to_));
    const Side one = held_[left] ? left : right;
    if (!held_[one]) return before_;
    return then(before_, motion_between(from_[one], to_[one]));
}

// Keeps the motion so far, before another hand takes part or one leaves.
void GrabGesture::anchor()
{
    before_ = motion();
    for (const Side side : {left, right}) from_[side] = to_[side];
}

void GrabGesture::stop()
{
    held_[left] = held_[right] = moves_ = false;
    before_ = {}, pressed_ = {};
}

void GrabGesture::release(Side side, const GrabInput& input, GrabAnswer& answer)
{
    anchor();
    held_[side] = false;
    if (pinches()) return;
    if (moves_) {
        answer.ends = true, moves_ = false;
        return;
    }
    before_ = {};
    if (!pressed_.value) {
        if (!toggles_ && !input.chosen.empty()) answer.choice = GrabAnswer::none;
    } else if (was_chosen_) {
        answer.choice = toggles_ ? GrabAnswer::less : GrabAnswer::alone;
        answer.object = pressed_;
    }
}

void GrabGesture::press(Side side, const GrabInput& input, GrabAnswer& answer)
{
    const GrabHand& hand = input.hands[side];
    const bool second = pinches();
    if (second && !pressed_.value) return;  // the first has no object
    if (second)
        anchor();
    else
        before_ = {};
    held_[side] = true, from_[side] = to_[side] = hand.at;
    if (second) return;
    first_ = side;
    toggles_ = input.adds_always || side == input.adds;
    pressed_ = hand.hovers ? hand.hovers->object : ObjectId{};
    was_chosen_ = std::ranges::count(input.chosen, pressed_) > 0;
    if (!pressed_.value || was_chosen_) return;
    answer.choice = toggles_ ? GrabAnswer::more : GrabAnswer::alone;
    answer.object = pressed_;
}

GrabAnswer GrabGesture::frame(const GrabInput& input)
{
    GrabAnswer answer;
    bool began[side_count] = {false, false};
    for (const Side side : {left, right}) {
        const GrabHand& hand = input.hands[side];
        // While a hand is lost it keeps its pinch. One that comes back must open first.
        if (!hand.tracked) {
            if (held_[side] && input.time > seen_[side] + lost_for) answer.cancelled = true;
            down_[side] = true;
            continue;
        }
        seen_[side] = input.time;
        began[side] = hand.pinches && !down_[side];
        down_[side] = hand.pinches;
    }
    if (input.cancels && pinches()) answer.cancelled = true;
    if (answer.cancelled) {
        answer.cancelled = moves_;
        stop();
        return answer;
    }
    for (const Side side : {left, right})
        if (held_[side] && input.hands[side].tracked) to_[side] = input.hands[side].at;
    for (const Side side : {left, right})
        if (held_[side] && !down_[side])
            release(side, input, answer);
        else if (began[side])
            press(side, input, answer);
    if (!pinches() || moves_ || !pressed_.value) return answer;
    const Similarity so_far = motion();
    const Vec3<double> moved = so_far.at(from_[first_].p) - from_[first_].p;
    const bool both = held_[left] && held_[right];
    if (both || length(moved) > still * input.scale || angle_of(so_far.turn) > still_angle)
        answer.begins = moves_ = true;
    return answer;
}

ObjectMotion object_motion(const Similarity& motion, Vec3<double> centre, bool snaps)
{
    ObjectMotion made;
    made.about = centre;
    made.factor =
        std::clamp(motion.scale, TransformGesture::least_factor, TransformGesture::largest_factor);
    made.turn = motion.turn, made.by = motion.at(centre) - centre;
    if (!snaps) return made;
    made.factor = std::clamp(Snapping::factor(made.factor), TransformGesture::least_factor,
                             TransformGesture::largest_factor);
    made.turn = Snapping::turn(made.turn), made.by = Snapping::move(made.by);
    return made;
}

std::vector<Command> ObjectMotion::commands(const std::vector<ObjectId>& objects,
                                            Vec3<double> origin) const
{
    constexpr double nothing = 1e-9;
    const std::vector<ObjectRef> refs(objects.begin(), objects.end());
    std::vector<Command> all;
    const bool turns = angle_of(turn) > nothing;
    if (turns || length(by) > nothing) {
        MoveObjects moves{refs, {}, {}, {}};
        if (length(by) > nothing) moves.by = by;
        if (turns) moves.turn = unit(turn), moves.about = about + origin;
        all.push_back(std::move(moves));
    }
    if (std::abs(factor - 1) > nothing)
        all.insert(factor > 1 ? all.end() : all.begin(), ScaleObjects{refs, factor});
    return all;
}

std::string ObjectMotion::text() const
{
    std::string text =
        fmt::format("Move x {:.1f} y {:.1f} z {:.1f} cm", 100 * by.x, 100 * by.y, 100 * by.z);
    const double degrees = angle_of(turn) * 180 / std::numbers::pi;
    if (degrees > 0.05) text += fmt::format(", turn {:.0f} degrees", degrees);
    if (std::abs(factor - 1) > 1e-9) text += fmt::format(", scale {:.2f}", factor);
    return text;
}

}  // namespace knead
