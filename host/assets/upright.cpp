#include "host/assets/upright.h"

#include <numbers>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

Quat<double> about(Vec3<double> axis, double degrees)
{
    return turn_about(axis, degrees * std::numbers::pi / 180);
}

Quat<double> to_y(UpAxis up)
{
    switch (up) {
        case UpAxis::y:
            return {1, 0, 0, 0};
        case UpAxis::minus_y:
            return about({1, 0, 0}, 180);
        case UpAxis::z:
            return about({1, 0, 0}, -90);
        case UpAxis::minus_z:
            return about({1, 0, 0}, 90);
        case UpAxis::x:
            return about({0, 0, 1}, 90);
        case UpAxis::minus_x:
            return about({0, 0, 1}, -90);
    }
    return {1, 0, 0, 0};
}

}  // namespace

Quat<double> upright(UpAxis up, double turn) { return about({0, 1, 0}, turn) * to_y(up); }

}  // namespace knead
