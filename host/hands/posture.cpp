#include "host/hands/posture.h"

#include <algorithm>
#include <cmath>

namespace knead {
namespace {

// First joint of each finger; its chain ends at the tip.
constexpr int roots[5] = {thumb_metacarpal, index_metacarpal, middle_metacarpal, ring_metacarpal,
                          little_metacarpal};
constexpr int bones[5] = {3, 4, 4, 4, 4};  // joints of the chain, without the tip

Joint<double> bone_of(const Joint<float>& parent, const Joint<float>& child)
{
    const Quat<double> back = conjugate(unit(cast<double>(parent.q)));
    return {back * unit(cast<double>(child.q)), rotate(back, cast<double>(child.p - parent.p))};
}
Joint<double> jointed(const Joint<double>& parent, const Joint<double>& child)
{
    return {unit(parent.q * child.q), parent.p + rotate(parent.q, child.p)};
}

// Away from the middle finger, on the right hand: thumb and index rotate to the left (+y), ring and
// little to the right.
double spread_sign(Side side, int finger)
{
    const double of_right = finger < 2 ? 1 : finger == 2 ? 0 : -1;
    return side == right ? of_right : -of_right;
}

}  // namespace

Fingers between(const Fingers& from, const Fingers& to, double s)
{
    Fingers f;
    for (int i = 0; i < 5; ++i) {
        for (int k = 0; k < 3; ++k)
            f.flex[i][k] = from.flex[i][k] + s * (to.flex[i][k] - from.flex[i][k]);
        f.spread[i] = from.spread[i] + s * (to.spread[i] - from.spread[i]);
    }
    return f;
}

Fingers within_limits(Fingers f)
{
    constexpr double low[2][3] = {{-0.35, -0.2, -0.3}, {-0.35, -0.1, -0.1}};
    constexpr double high[2][3] = {{0.9, 1.0, 1.4}, {1.57, 1.9, 1.4}};
    for (int i = 0; i < 5; ++i) {
        const int kind = i == 0 ? 0 : 1;
        for (int k = 0; k < 3; ++k) f.flex[i][k] = clamp(f.flex[i][k], low[kind][k], high[kind][k]);
        const double widest = i == 0 ? 0.7 : 0.35;
        f.spread[i] = clamp(f.spread[i], -widest, widest);
    }
    return f;
}

Pose posed(Side side, const Joint<double>& wrist_at, const Fingers& fingers)
{
    const Hand open = open_hand(side);
    Pose pose{};
    pose[wrist] = wrist_at;
    pose[palm] = jointed(wrist_at, bone_of(open.joints[wrist], open.joints[palm]));
    for (int i = 0; i < 5; ++i) {
        int parent = wrist;
        for (int k = 0; k <= bones[i]; ++k) {
            const int j = roots[i] + k;
            pose[j] = jointed(pose[parent], bone_of(open.joints[parent], open.joints[j]));
            const int moving = i == 0 ? k : k - 1;  // finger metacarpals do not move
            if (moving == 0) {
                const double angle = spread_sign(side, i) * fingers.spread[i];
                pose[j].q = pose[j].q * turn_about(Vec3<double>{0, 1, 0}, angle);
            }
            if (moving >= 0 && moving < 3) {
                const Vec3<double> axis{-1, 0, 0};
                pose[j].q = unit(pose[j].q * turn_about(axis, fingers.flex[i][moving]));
            }
            parent = j;
        }
    }
    return pose;
}

// Bones are tangents to the ball, padded by the flesh below them: where bones of lengths a and b
// meet, the direction turns by atan(a / 2R) + atan(b / 2R).
Fingers wrapped(Side side, double radius)
{
    constexpr double flesh = 0.008;         // [m]
    constexpr double of_metacarpal = 0.02;  // the part of the palm that rests on the ball [m]
    const Hand open = open_hand(side);
    Fingers f{};
    for (int i = 0; i < 5; ++i) {
        double before = of_metacarpal;
        for (int k = 0; k < 3; ++k) {
            const int j = roots[i] + (i == 0 ? k : k + 1);
            const double bone = length(cast<double>(open.joints[j + 1].p - open.joints[j].p));
            const double around = 2 * (radius + flesh);
            f.flex[i][k] = std::atan(before / around) + std::atan(bone / around);
            if (i == 0) f.flex[i][k] *= 0.4;  // the thumb opposes the fingers only a little
            before = bone;
        }
    }
    return within_limits(f);
}

Fingers gripped(double share)
{
    Fingers f{};
    for (int i = 0; i < 5; ++i)
        for (int k = 0; k < 3; ++k) {
            constexpr double fist[2][3] = {{0.5, 0.5, 0.6}, {1.35, 1.6, 1.0}};
            f.flex[i][k] = share * fist[i == 0 ? 0 : 1][k];
        }
    return f;
}

Fingers pinched(Side side)
{
    // Coordinate search with shrinking steps over the flexion of index and thumb and the spread of
    // the thumb, for pads that touch with the least bending.
    const Hand open = open_hand(side);
    const double apart = open.radius[thumb_tip] + open.radius[index_tip];
    Fingers f = gripped(0.85);
    double v[6] = {0.7, 0.7, 0.3, 0.0, 0.3, 0.3};
    const auto apply = [&] {
        const double index[3] = {v[0], v[1], 2 * v[1] / 3};  // the two end joints share a tendon
        const double thumb[3] = {v[2], v[4], v[5]};
        std::copy(index, index + 3, f.flex[1]);
        std::copy(thumb, thumb + 3, f.flex[0]);
        f.spread[0] = v[3];
        f = within_limits(f);
    };
    const auto cost = [&] {
        apply();
        const Pose pose = posed(side, {{1, 0, 0, 0}, {}}, f);
        const double miss = length(pose[thumb_tip].p - pose[index_tip].p) - apart;
        double bending = 0;
        for (const double angle : v) bending += angle * angle;
        return miss * miss + 1e-6 * bending;
    };
    double best = cost();
    for (double step = 0.4; step > 1e-3; step *= 0.5)
        for (int round = 0; round < 8; ++round)
            for (double& angle : v)
                for (const double change : {step, -step}) {
                    angle += change;
                    const double found = cost();
                    if (found < best)
                        best = found;
                    else
                        angle -= change;
                }
    apply();
    return f;
}

double gap(const Rig& rig, const Joint<double> joints[2 * joint_count], Vec3<double> middle,
           double radius)
{
    const auto sphere = [&](int i) {
        const Binding<float>& b = rig.spheres[i];
        Binding<double> wide{};
        for (int k = 0; k < 4; ++k) {
            wide.joint[k] = b.joint[k];
            wide.weight[k] = b.weight[k];
            wide.offset[k] = cast<double>(b.offset[k]);
        }
        const Vec3<double> c = centre(wide, [&](int j) { return joints[j]; });
        return Sphere<double>{c, {}, {}, b.radius, 0};
    };
    double nearest = 1e30;
    for (const Primitive& p : rig.primitives) {
        const auto s =
            shape(p.count, sphere(p.sphere[0]), sphere(p.sphere[1]), sphere(p.sphere[2]));
        nearest = std::min(nearest, closest_point(s, middle).phi);
    }
    return nearest - radius;
}

}  // namespace knead
