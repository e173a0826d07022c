#include "host/vr/scene_gesture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knead {

std::optional<ScenePlace> SceneGesture::frame(
    const std::optional<std::array<Vec3<double>, 2>>& fists, const ScenePlace& now)
{
    const auto before = std::exchange(last_, fists);
    if (!before || !fists) return {};
    ScenePlace to = now;
    for (std::size_t k = 0; k < 2; ++k)
        if (length((*fists)[k] - (*before)[k]) > longest_step) return to;
    const Vec3<double> a = (*before)[1] - (*before)[0], b = (*fists)[1] - (*fists)[0];
    const Vec3<double> from = 0.5 * ((*before)[0] + (*before)[1]),
                       middle = 0.5 * ((*fists)[0] + (*fists)[1]);
    constexpr double near = 0.03;  // fists have no direction, and no distance to compare [m]
    if (length(a) > near && length(b) > near)
        to.zoom = std::clamp(now.zoom * length(a) / length(b), least, largest);
    double turn = 0;
    if (std::hypot(a.x, a.z) > near && std::hypot(b.x, b.z) > near)
        turn = std::remainder(std::atan2(a.z, a.x) - std::atan2(b.z, b.x), 2 * std::numbers::pi);
    const double grown = now.zoom / to.zoom;
    to.workplace.turn = std::remainder(now.workplace.turn + turn, 2 * std::numbers::pi);
    to.workplace.at =
        middle + grown * rotate(turn_about(Vec3<double>{0, 1, 0}, turn), now.workplace.at - from);
    return to;
}

}  // namespace knead
