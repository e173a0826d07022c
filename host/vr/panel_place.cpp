#include "host/vr/panel_place.h"

#include <array>
#include <cmath>
#include <numbers>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

using V = Vec3<float>;

constexpr float to_radians = std::numbers::pi_v<float> / 180;
// Centre of the usual pose right of the clay, in the frame of the hands [m].
constexpr V usual_centre{0.45f, 0, 0.25f};
constexpr float clay_margin = 0.02f;    // distance of the panel from the clay's box [m]
constexpr float least_distance = 0.4f;  // from the head to the panel [m]

V mirrored_if(Side side, V v) { return side == left ? V{-v.x, v.y, v.z} : v; }

std::array<V, 4> rectangle(const Joint<float>& pose, const PanelSize& size)
{
    std::array<V, 4> corners;
    for (std::size_t k = 0; k < 4; ++k)
        corners[k] =
            pose.p + rotate(pose.q, V{k & 1 ? 0.5f * size.width : -0.5f * size.width,
                                      k & 2 ? 0.5f * size.height : -0.5f * size.height, 0});
    return corners;
}

// Upright, its normal towards the head.
Joint<float> facing(V head, V centre)
{
    V z = head - centre;
    // If the eyes are at the panel's centre, the direction is undefined.
    z = length(z) > 0.05f ? (1 / length(z)) * z : V{0, 0, 1};
    V x = cross(V{0, 1, 0}, z);
    x = length(x) > 0.05f ? (1 / length(x)) * x : V{1, 0, 0};
    return {quaternion(Mat3<float>{x, cross(z, x), z}), centre};
}

// Whether a rectangle and a box have a common point, by their separating axes.
bool intersects(const Joint<float>& pose, const PanelSize& size, const Box3<float>& box)
{
    if (empty(box)) return false;
    const std::array<V, 4> corners = rectangle(pose, size);
    const V middle = 0.5f * (box.low + box.high), half = 0.5f * (box.high - box.low);
    const std::array<V, 3> sides{V{1, 0, 0}, V{0, 1, 0}, V{0, 0, 1}};
    const std::array<V, 3> own{rotate(pose.q, sides[0]), rotate(pose.q, sides[1]),
                               rotate(pose.q, sides[2])};
    const auto separates = [&](V axis) {
        if (length(axis) < 1e-4f) return false;
        const float reach =
            half.x * std::abs(axis.x) + half.y * std::abs(axis.y) + half.z * std::abs(axis.z);
        float low = 1e30f, high = -1e30f;
        for (const V& corner : corners) {
            const float at = dot(axis, corner - middle);
            low = std::min(low, at), high = std::max(high, at);
        }
        return low > reach || high < -reach;
    };
    for (const V& a : sides) {
        if (separates(a)) return false;
        for (const V& b : own)
            if (separates(b) || separates(cross(a, b))) return false;
    }
    return true;
}

// The clay's box in the frame of the hands, with its margin; empty if it is.
Box3<float> in_hands(const Box3<double>& clay, const HandsOptions& hands)
{
    if (empty(clay) || !(hands.zoom > 0)) return empty_box<float>();
    const Box3<double> moved{(1 / hands.zoom) * (clay.low - hands.at),
                             (1 / hands.zoom) * (clay.high - hands.at)};
    return expanded(Box3<float>{cast<float>(moved.low), cast<float>(moved.high)}, clay_margin);
}

}  // namespace

PanelPlace main_panel_pose(const Workplace& workplace, Side side, const Box3<double>& clay,
                           const HandsOptions& hands, const PanelSize& size)
{
    const V head = in_hands(workplace, Joint<float>{{1, 0, 0, 0}, {0, 0, 0}}).p;
    const V shoulder = head + mirrored_if(side, shoulder_from_eyes);
    const Box3<float> box = in_hands(clay, hands);
    const auto at = [&](V centre) {
        PanelPlace place;
        place.pose = facing(head, centre);
        place.distance = length(head - centre);
        place.reached = true;
        for (const V& corner : rectangle(place.pose, size))
            place.reached = place.reached && length(corner - shoulder) <= panel_reach;
        place.clear_of_clay = !intersects(place.pose, size, box);
        return place;
    };
    const V wanted = mirrored_if(side, usual_centre);
    const PanelPlace usual = at(wanted);
    if (usual.reached && usual.clear_of_clay) return usual;
    // Others: directions and distances from the shoulder, on its side of the head.
    std::optional<PanelPlace> best;
    for (int across = -30; across <= 90; across += 10)
        for (int up = -60; up <= 60; up += 10)
            for (const float far : {0.25f, 0.3f, 0.35f, 0.4f, 0.45f, 0.5f, 0.55f}) {
                const float a = to_radians * float(across), e = to_radians * float(up);
                const V way{std::sin(a) * std::cos(e), std::sin(e), -std::cos(a) * std::cos(e)};
                const V centre = shoulder + far * mirrored_if(side, way);
                if (best && length(centre - wanted) >= length(best->pose.p - wanted)) continue;
                if (length(centre - head) < least_distance) continue;
                const PanelPlace other = at(centre);
                if (other.reached && other.clear_of_clay) best = other;
            }
    return best.value_or(usual);
}

float panel_letter_height(float distance, const PanelSize& size, float degrees)
{
    // A height h at the distance r from the panel's centre, towards which it points, is seen under
    // the angle h d / (d^2 + r^2); across that direction under a larger one.
    const float r2 = 0.25f * (size.width * size.width + size.height * size.height);
    return std::tan(to_radians * degrees) * (distance * distance + r2) / distance;
}

float distance_to_panel(const Joint<float>& pose, const PanelSize& size, Vec3<float> point)
{
    const V at = rotate(conjugate(pose.q), point - pose.p);
    return length(V{std::max(std::abs(at.x) - 0.5f * size.width, 0.f),
                    std::max(std::abs(at.y) - 0.5f * size.height, 0.f), at.z});
}

std::optional<Joint<float>> palm_pose(const Hand& hand, float above)
{
    if (!hand.tracked || !hand.valid[palm]) return std::nullopt;
    const Joint<float>& joint = hand.joints[palm];
    const V p = joint.p;
    const Quat<float> turn = joint.q;
    const float square = turn.w * turn.w + turn.x * turn.x + turn.y * turn.y + turn.z * turn.z;
    if (!std::isfinite(p.x + p.y + p.z + square) || !(square > 0)) return std::nullopt;
    // OpenXR: -z towards the fingers, +y out of the back of the hand.
    const Quat<float> q = unit(turn);
    const V right = rotate(q, V{-1, 0, 0}), up = rotate(q, V{0, 0, -1}),
            normal = rotate(q, V{0, -1, 0});
    const float radius = hand.radius[palm] > 0 ? hand.radius[palm] : 0;
    return Joint<float>{quaternion(Mat3<float>{right, up, normal}), p + (radius + above) * normal};
}

bool PalmStrip::frame(double time, const Hand& hand, Vec3<float> head, bool contact, bool busy)
{
    if (contact) touched = time;
    const std::optional<Joint<float>> pose = palm_pose(hand);
    if (!pose || contact || busy || time - touched < rest) return shown = false;
    const V to_head = head - pose->p, normal = rotate(pose->q, V{0, 0, 1});
    const float limit = std::cos(to_radians * (shown ? hidden_above : shown_below));
    return shown = dot(normal, to_head) > limit * length(to_head);
}

}  // namespace knead
