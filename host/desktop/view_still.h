// Whether the picture of the window still shows what there is: of a picture in which nothing moves
// all pixels are drawn, once.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "host/live/live_session.h"
#include "render/eye_painter.h"

namespace knead {

// All that a picture shows.
struct PictureContent {
    EyeView view;
    int history = 0, highlight = -1;
    long splat_version = 0;
    Meshes meshes;  // or
    std::shared_ptr<const DeviceMesh> on_device;
    std::shared_ptr<const std::vector<Gaussian<double>>> gaussians;  // or
    std::shared_ptr<const DeviceGaussians> gaussians_on_device;
    std::vector<float> hands;  // what they are drawn by
    float within = 0;          // so far clay may move and be seen where it was [m]
};
// Clay that rests under gravity trembles by far less than a pixel.
bool alike(const PictureContent& a, const PictureContent& b);

class StillPicture {
  public:
    static constexpr double rest = 0.25;  // from the last motion to the whole picture [s]

    // What there is to see at `time` [s].
    void look(PictureContent now, double time)
    {
        if (painted_ && alike(last_, now)) return;
        last_ = std::move(now);
        moved_ = time, whole_ = false, painted_ = true;
    }
    // All pixels are worth their time, and were not drawn yet.
    bool due(double time) const { return !whole_ && time >= moved_ + rest; }
    bool whole() const { return whole_; }
    void drawn_whole() { whole_ = true; }
    void forget() { painted_ = whole_ = false; }

  private:
    PictureContent last_;
    double moved_ = 0;
    bool painted_ = false, whole_ = false;
};

}  // namespace knead
