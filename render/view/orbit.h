// A camera that goes around what it looks at.
#pragma once
#include "render/eye_painter.h"

namespace knead {

class OrbitCamera {
  public:
    // From `eye` at `target` [m]; they are apart.
    void look(Vec3<float> eye, Vec3<float> target);
    // So that the box is seen whole, from where it was seen. Width over height: `aspect`.
    void frame(Vec3<float> low, Vec3<float> high, float aspect);

    void orbit(float right, float up);  // by these angles of the eye [rad]; stops near the poles
    // Eye and target together, so that what lies at the target follows a mouse by so many pixels of
    // a picture that is `height` pixels high.
    void pan(float right, float down, int height);
    void zoom(float steps);  // nearer by a tenth for each step

    // What the camera looks at is in the middle of what is left of a picture whose first `hidden`
    // columns cannot be seen.
    EyeView view(int width, int height, int hidden = 0) const;
    Vec3<float> eye() const;
    Vec3<float> target() const { return at_; }
    float distance() const { return distance_; }
    float field() const { return field_; }
    Vec3<float> forward() const;  // unit
    // Through the pixel (x, y) from the upper left corner; as long as the gaze goes 1 ahead.
    Vec3<float> ray(float x, float y, int width, int height, int hidden = 0) const;

  private:
    Vec3<float> right() const;

    Vec3<float> at_{0.5f, 0.25f, 0.5f};  // [m]
    float distance_ = 1.5f;              // [m]
    float yaw_ = 0.6f, pitch_ = 0.4f;  // of the eye about the target, from +z and from level [rad]
    float field_ = 0.6f;               // vertical field of view [rad]
};

}  // namespace knead
