// Detects pictures in which nothing moves: such a picture is drawn once, at full resolution.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "host/live/live_session.h"
#include "render/eye_painter.h"

namespace knead {

// Everything that determines a picture.
struct PictureContent {
    EyeView view;
    int history = 0, highlight = -1;
    long splat_version = 0;
    Meshes meshes;  // or
    std::shared_ptr<const DeviceMesh> on_device;
    std::shared_ptr<const std::vector<Gaussian<double>>> gaussians;  // or
    std::shared_ptr<const DeviceGaussians> gaussians_on_device;
    std::vector<int> hidden;   // categories of clay that is not drawn
    std::vector<float> hands;  // numbers that determine their appearance
    float within = 0;          // largest motion of clay that is not visible [m]
};
// Whether two pictures look the same. Tolerates motion up to `within`: clay at rest under gravity
// oscillates by far less than a pixel.
bool alike(const PictureContent& a, const PictureContent& b);

class StillPicture {
  public:
    static constexpr double rest = 0.25;  // from the last motion to the full-resolution picture [s]

    // Sets the content at `time` [s].
    void update(PictureContent now, double time)
    {
        if (painted_ && alike(last_, now)) return;
        last_ = std::move(now);
        moved_ = time, full_resolution_ = false, painted_ = true;
    }
    // Whether to draw the full-resolution picture now.
    bool due(double time) const { return !full_resolution_ && time >= moved_ + rest; }
    bool full_resolution() const { return full_resolution_; }
    void drawn_full() { full_resolution_ = true; }
    void forget() { painted_ = full_resolution_ = false; }

  private:
    PictureContent last_;
    double moved_ = 0;
    bool painted_ = false, full_resolution_ = false;
};

}  // namespace knead
