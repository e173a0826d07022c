// A camera that orbits its target.
#pragma once
#include "cuda/math/box.h"
#include "render/eye_painter.h"

namespace knead {

class OrbitCamera {
  public:
    // Places the camera at `eye`, directed at `target` [m]. Precondition: eye != target.
    void look(Vec3<float> eye, Vec3<float> target);
    // Moves the camera so that the whole box is visible from the present direction. `aspect`: width
    // over height.
    void frame(const Box3<float>& box, float aspect);

    // Rotates the eye around the target by these angles [rad]; stops near the poles.
    void orbit(float right, float up);
    // Moves eye and target together, so that the target follows a mouse moved by `right`, `down`
    // pixels in a picture `height` pixels high.
    void pan(float right, float down, int height);
    void zoom(float steps);  // a tenth nearer per step

    // Centres the target in the visible part of the picture: its first `hidden` columns are
    // covered.
    EyeView view(int width, int height, int hidden = 0) const;
    Vec3<float> eye() const;
    Vec3<float> target() const { return at_; }
    float distance() const { return distance_; }
    float field() const { return field_; }
    Vec3<float> forward() const;  // unit
    // Direction through pixel (x, y) from the upper left corner, with component 1 along the view
    // axis.
    Vec3<float> ray(float x, float y, int width, int height, int hidden = 0) const;

  private:
    Vec3<float> right() const;

    Vec3<float> at_{0.5f, 0.25f, 0.5f};  // [m]
    float distance_ = 1.5f;              // [m]
    float yaw_ = 0.6f, pitch_ = 0.4f;    // of the eye, from +z and from horizontal [rad]
    float field_ = 0.6f;                 // vertical field of view [rad]
};

}  // namespace knead
