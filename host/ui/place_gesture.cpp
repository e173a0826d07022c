#include "host/ui/place_gesture.h"

#include <cmath>
#include <numbers>

namespace knead {

Vec3<double> resting_on(const SceneObject& object, const TransformSurface& on, double gap)
{
    const Vec3<double> half = 0.5 * own_extents(object),
                       n = rotate(conjugate(object.pose.q), on.normal);
    const double reach = std::abs(n.x) * half.x + std::abs(n.y) * half.y + std::abs(n.z) * half.z;
    return on.point + (reach + gap) * on.normal;
}

SceneObject placed(const SceneObject& object, Vec3<double> centre, Vec3<double> origin)
{
    SceneObject there = object;
    there.pose.p = centre + origin;
    return there;
}

Mesh object_outline(const SceneObject& object, Vec3<double> centre, double thick)
{
    const Vec3<double> half = 0.5 * own_extents(object);
    Mesh mesh = box_corners({-1.0 * half, half}, thick);
    const auto ellipse = [&](Vec3<double> u, Vec3<double> v) {
        constexpr int pieces = 32;
        const auto at = [&](int i) {
            const double angle = 2 * std::numbers::pi * i / pieces;
            return std::cos(angle) * u + std::sin(angle) * v;
        };
        for (int i = 0; i < pieces; ++i) add_line(mesh, at(i), at(i + 1), thick);
    };
    const Vec3<double> x{half.x, 0, 0}, y{0, half.y, 0}, z{0, 0, half.z};
    switch (object.source.shape) {
        case ShapeKind::sphere:
        case ShapeKind::ellipsoid:
            ellipse(x, y), ellipse(y, z), ellipse(z, x);
            break;
        case ShapeKind::cylinder:
        case ShapeKind::cone:
        case ShapeKind::capsule:
        case ShapeKind::torus:
            ellipse(z, x);
            break;
        default:
            break;
    }
    const Quat<float> q = cast<float>(object.pose.q);
    for (Vec3<float>& p : mesh.vertices) p = cast<float>(centre) + rotate(q, p);
    for (Vec3<float>& n : mesh.normals) n = rotate(q, n);
    return mesh;
}

PlaceGesture::Answer PlaceGesture::frame(const Input& input)
{
    if (input.cancels) return cancelled;
    for (const Side side : {left, right}) {
        const GrabHand& hand = input.hands[side];
        if (hand.tracked && hand.pinches && !down_[side] && !pinched_) by_ = side, pinched_ = true;
        down_[side] = !hand.tracked || hand.pinches;
    }
    const Side other = input.usual == left ? right : left;
    const Side by = by_.value_or(input.hands[input.usual].tracked ? input.usual : other);
    const GrabHand& hand = input.hands[by];
    // A lost hand leaves the object where it is.
    if (!hand.tracked) return goes_on;
    at_ = input.snaps ? Snapping::move(hand.at.p) : hand.at.p;
    return pinched_ && !hand.pinches ? placed : goes_on;
}

}  // namespace knead
