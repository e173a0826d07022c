// Eye views; no OpenGL calls.
#include <cmath>

#include "cuda/math/rotation.h"
#include "render/eye_painter.h"

namespace knead {

EyeView eye_view(const Camera& camera)
{
    const Vec3<float> gaze = camera.target - camera.eye;
    const float distance = length(gaze);
    const Vec3<float> back = (-1 / distance) * gaze;
    const Vec3<float> level{back.z, 0, -back.x};
    const Vec3<float> right =
        length(level) > 1e-4f ? (1 / length(level)) * level : Vec3<float>{1, 0, 0};
    EyeView view;
    view.position = camera.eye;
    view.rotation = quaternion(Mat3<float>{right, cross(back, right), back});
    view.up = std::tan(camera.field / 2);
    view.right = view.up * float(camera.width) / float(camera.height);
    view.down = -view.up;
    view.left = -view.right;
    view.near = 1e-3f * distance;
    view.width = camera.width;
    view.height = camera.height;
    return view;
}

Eye<float> splat_eye(const EyeView& view)
{
    const Quat<float> half_turn{0, 1, 0, 0};  // about x: y down, z forward
    return {view.position, view.rotation * half_turn,
            view.left,     view.right,
            -view.up,      -view.down,
            view.width,    view.height};
}

}  // namespace knead
