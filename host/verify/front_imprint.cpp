// workprecision: a ball of clay on a floor, into which a smaller ball is pressed, and withdrawn.
#include <algorithm>
#include <memory>

#include "host/verify/front.h"

namespace knead {
namespace {

constexpr double tool = 0.1, deep = 0.1, speed = 1, rest = 0.05;  // [m] [m/s] [s]

Squeezed imprinted(const Verification& v, const FrontRule& rule)
{
    const double dx = 1.0 / rule.cells;
    Setup s = between_walls({rule.cells, rule.cells, rule.cells}, dx, ContactMode::separate, 0.5);
    const Place middle = s.walls.min + Place{0.5, 0.5, 0.5};
    fill(s, plastic(1e5, 0.3, 1000, 1e4), s.walls.min, s.walls.max, rule.per_axis,
         [&](Place x) { return length(x - middle) < squeeze_radius; });
    s.walls.min.y = middle.y - squeeze_radius;
    add_ball_tool(s, tool, ContactMode::separate, 0.4);
    const auto at = [&](double t) {
        const double in = speed * std::min(t, std::max(2 * deep / speed - t, -tool));
        return std::vector{stands_at(middle + Place{0, squeeze_radius + tool - in, 0})};
    };
    return followed(v, rule, std::move(s), middle, 2 * deep / speed + rest, at);
}

}  // namespace

FrontScene imprint_front(Verification& v)
{
    const int finest = v.quick() ? 48 : 96;
    const auto fine = std::make_shared<Squeezed>(imprinted(v, {finest, 2, 0, false}));
    return {"imprint", "mm", "the places on " + std::to_string(finest) + " cells/m",
            v.quick() ? std::vector{16, 32} : std::vector{16, 24, 32, 48},
            [&v, fine](const FrontRule& rule) {
                const Squeezed s = imprinted(v, rule);
                return FrontResult{1e3 * apart(s, *fine).rms, s.seconds};
            }};
}

}  // namespace knead
