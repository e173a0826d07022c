// workprecision: a smaller ball is pressed into a ball of clay on a floor and withdrawn.
#include <algorithm>

#include "host/verify/front.h"

namespace knead {
namespace {

constexpr double tool = 0.1, deep = 0.1, speed = 1, rest = 0.05;  // [m] [m/s] [s]

Squeezed imprinted(const Verification& v, const SceneOptions& options)
{
    auto [s, middle] = ball_of_clay(options, 0.5);
    s.walls.min.y = middle.y - squeeze_radius;
    add_ball_tool(s, tool, ContactMode::separate, 0.4);
    const auto at = [middle = middle](double t) {
        const double in = speed * std::min(t, std::max(2 * deep / speed - t, -tool));
        return std::vector{stands_at(middle + Place{0, squeeze_radius + tool - in, 0})};
    };
    return followed(v, options, std::move(s), middle, 2 * deep / speed + rest, at);
}

}  // namespace

FrontScene imprint_front(Verification& v)
{
    return against_finest(v, "imprint", "the places", 48, 32, imprinted, places_off);
}

}  // namespace knead
