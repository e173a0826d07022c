// Coordinate frames in VR: the headset's, that of the hands (the frame of recordings), and the
// simulation's.
#pragma once
#include <array>

#include "host/hands/hands_options.h"
#include "host/scene/scene.h"
#include "render/eye_painter.h"
#include "xr/headset.h"

namespace knead {

// Pose of the frame of the hands in the headset's frame: rotated about the vertical, then shifted.
struct Workplace {
    Vec3<double> at{0, -0.35, -0.5};  // [m] of the headset's frame
    double turn = 0;                  // [rad]
};
// The workplace before the head: `usual`, rotated to the head's heading and shifted to its
// position.
Workplace before_head(const Joint<float>& head, const Workplace& usual);

// Transforms a pose from the headset's frame to that of the hands.
Joint<float> in_hands(const Workplace& workplace, const Joint<float>& pose);
// in_hands() for the valid joints; exact, to the bit, if the workplace is the origin.
Hand in_hands(const Workplace& workplace, const Hand& hand);
// Transforms a pose from the frame of the hands to the headset's.
Joint<float> in_headset_frame(const Workplace& workplace, const Joint<float>& pose);

// View of an eye in the simulation's frame. `nearest`: near plane in the headset's frame [m].
EyeView eye_view(const EyePlace& eye, int width, int height, const Workplace& workplace,
                 const HandsOptions& hands, float near_plane);
// Transforms a point of the world to the clip space of an eye; depth is near / distance.
std::array<float, 4> clip_of(const EyeView& view, Vec3<float> point);
// Pose of the head: the mean of both eyes.
Joint<float> head_of(const HeadsetViews& views);

// The scene's hands; if it has none, bare hands scaled so that its objects fit into them.
HandsOptions live_hands(const Scene& scene);

}  // namespace knead
