// Where the clay is before the user: between the headset's frame, that of the hands, which is the
// frame of recordings, and the simulation's.
#pragma once
#include <array>

#include "host/hands/hands_options.h"
#include "host/scene/scene.h"
#include "render/eye_painter.h"
#include "xr/headset.h"

namespace knead {

// The frame of the hands as it stands in the headset's: turned about the vertical, then moved.
struct Workplace {
    Vec3<double> at{0, -0.35, -0.5};  // [m] of the headset's frame
    double turn = 0;                  // [rad]
};
// The same, as far from the head and as much below it as `usual` is from the origin, and where the
// head looks, seen from above.
Workplace before_head(const Joint<float>& head, const Workplace& usual);

// A pose of the headset's frame in that of the hands.
Joint<float> in_hands(const Workplace& workplace, const Joint<float>& pose);
// The joints that are valid; to the bit the same where the workplace is the origin.
Hand in_hands(const Workplace& workplace, const Hand& hand);

// What an eye of the headset sees of the simulation. `nearest` [m] is of the headset's size.
EyeView eye_view(const EyePlace& eye, int width, int height, const Workplace& workplace,
                 const HandsOptions& hands, float nearest);
// A point of the world in the clip space of an eye, whose depth is near / distance.
std::array<float, 4> clip_of(const EyeView& view, Vec3<float> point);
// The head, between both eyes.
Joint<float> head_of(const HeadsetViews& sight);

// The scene's hands, or where it names none, bare ones in a size that makes its objects fit into
// them.
HandsOptions live_hands(const Scene& scene);

}  // namespace knead
