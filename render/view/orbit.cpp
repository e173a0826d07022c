#include "render/view/orbit.h"

#include <algorithm>
#include <cmath>

namespace knead {
namespace {

constexpr float steepest = 1.5f;                            // [rad]
constexpr float min_distance = 1e-3f, max_distance = 1e3f;  // [m]

}  // namespace

void OrbitCamera::look(Vec3<float> eye, Vec3<float> target)
{
    const Vec3<float> back = eye - target;
    const float far = length(back);
    if (!(far > 0 && far < max_distance)) return;
    at_ = target;
    distance_ = std::max(far, min_distance);
    pitch_ = clamp(std::asin(clamp(back.y / far, -1.0f, 1.0f)), -steepest, steepest);
    yaw_ = std::atan2(back.x, back.z);
}

void OrbitCamera::frame(const Box3<float>& box, float aspect)
{
    const float radius = length(edges(box)) / 2;
    if (!(radius > 0 && radius < max_distance)) return;
    at_ = centre(box);
    const float half = std::atan(std::tan(field_ / 2) * std::min(1.0f, aspect));
    distance_ = clamp(1.1f * radius / std::sin(half), min_distance, max_distance);
}

void OrbitCamera::orbit(float right, float up)
{
    yaw_ = std::remainder(yaw_ + right, 6.2831853f);
    pitch_ = clamp(pitch_ + up, -steepest, steepest);
}

void OrbitCamera::pan(float right_by, float down, int height)
{
    const float pixel = 2 * distance_ * std::tan(field_ / 2) / float(std::max(height, 1));
    const Vec3<float> up = cross(right(), forward());
    at_ = at_ - (right_by * pixel) * right() + (down * pixel) * up;
}

void OrbitCamera::zoom(float steps)
{
    distance_ = clamp(distance_ * std::pow(0.9f, steps), min_distance, max_distance);
}

Vec3<float> OrbitCamera::forward() const
{
    const float level = std::cos(pitch_);
    return {-level * std::sin(yaw_), -std::sin(pitch_), -level * std::cos(yaw_)};
}
Vec3<float> OrbitCamera::right() const { return {std::cos(yaw_), 0, -std::sin(yaw_)}; }
Vec3<float> OrbitCamera::eye() const { return at_ - distance_ * forward(); }

EyeView OrbitCamera::view(int width, int height, int hidden) const
{
    Camera c;
    c.eye = eye(), c.target = at_;
    c.field = field_;
    c.width = width, c.height = height;
    EyeView view = eye_view(c);
    const float aside = view.right * float(hidden) / float(std::max(width, 1));
    view.left -= aside, view.right -= aside;
    return view;
}

Vec3<float> OrbitCamera::ray(float x, float y, int width, int height, int hidden) const
{
    const float pixel = 2 * std::tan(field_ / 2) / float(std::max(height, 1));
    const Vec3<float> up = cross(right(), forward());
    return forward() + ((x - 0.5f * float(width + hidden)) * pixel) * right() -
           ((y - 0.5f * float(height)) * pixel) * up;
}

}  // namespace knead
