#include "host/vr/headset_view.h"

#include <algorithm>
#include <cmath>

#include "cuda/math/box.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

Quat<float> turned_back(const Workplace& workplace)
{
    return cast<float>(turn_about(Vec3<double>{0, 1, 0}, -workplace.turn));
}

}  // namespace

Workplace before_head(const Joint<float>& head, const Workplace& usual)
{
    const Vec3<float> gaze = rotate(unit(head.q), Vec3<float>{0, 0, -1});
    Workplace place;
    // The heading of a head that looks straight down or up is undefined.
    const bool level = std::hypot(gaze.x, gaze.z) > 0.1f;
    place.turn = level ? std::atan2(double(-gaze.x), double(-gaze.z)) : usual.turn;
    const Quat<double> turn = turn_about(Vec3<double>{0, 1, 0}, place.turn - usual.turn);
    place.at = cast<double>(head.p) + rotate(turn, usual.at);
    return place;
}

Joint<float> in_hands(const Workplace& workplace, const Joint<float>& pose)
{
    const Quat<float> back = turned_back(workplace);
    return {back * pose.q, rotate(back, pose.p - cast<float>(workplace.at))};
}

Joint<float> in_headset_frame(const Workplace& workplace, const Joint<float>& pose)
{
    const Quat<float> turn = conjugate(turned_back(workplace));
    return {turn * pose.q, cast<float>(workplace.at) + rotate(turn, pose.p)};
}

Hand in_hands(const Workplace& workplace, const Hand& hand)
{
    Hand moved = hand;
    for (int j = 0; j < joint_count; ++j)
        if (hand.valid[j]) moved.joints[j] = in_hands(workplace, hand.joints[j]);
    return moved;
}

EyeView eye_view(const EyePlace& eye, int width, int height, const Workplace& workplace,
                 const HandsOptions& hands, float near_plane)
{
    const Joint<float> pose = in_hands(workplace, eye.pose);
    const float zoom = float(hands.zoom);
    EyeView view;
    view.position = cast<float>(hands.at) + zoom * pose.p;
    view.rotation = unit(pose.q);
    view.left = std::tan(eye.field.left), view.right = std::tan(eye.field.right);
    view.down = std::tan(eye.field.down), view.up = std::tan(eye.field.up);
    view.near = zoom * near_plane;
    view.width = width, view.height = height;
    return view;
}

std::array<float, 4> clip_of(const EyeView& view, Vec3<float> point)
{
    const Vec3<float> p = rotate(conjugate(view.rotation), point - view.position);
    const float width = view.right - view.left, height = view.up - view.down;
    return {(2 * p.x + (view.right + view.left) * p.z) / width,
            (2 * p.y + (view.up + view.down) * p.z) / height, view.near, -p.z};
}

Joint<float> head_of(const HeadsetViews& views)
{
    return between(views.eyes[0].pose, views.eyes[1].pose, 0.5f);
}

HandsOptions live_hands(const Scene& scene)
{
    if (scene.has_hands) return scene.hands;
    HandsOptions options = scene.hands;
    if (scene.objects.empty()) {                    // as large as it fits on a table
        constexpr double table = 0.4, above = 0.1;  // its edge, and the origin above it [m]
        const Int3 cells = scene.stated_cells;
        const WallOptions& walls = scene.setup.walls;
        options.zoom = scene.setup.lattice.dx * std::max({cells.x, cells.y, cells.z}) / table;
        options.at = 0.5 * (walls.min + walls.max);
        options.at.y = walls.min.y + above * options.zoom;
        return options;
    }
    constexpr double in_hand = 0.2;  // the size of all objects together [m]
    Box3<double> all = empty_box<double>();
    for (const Object& o : scene.objects) grow(all, box_of(o));
    options.zoom = longest_edge(all) / in_hand;
    options.at = centre(all);
    return options;
}

}  // namespace knead
