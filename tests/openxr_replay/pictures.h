// What was submitted, as files: colour as PNG, depth as what it says of the scene.
#pragma once
#include <string>

#include "host/files/image.h"

namespace knead::replay {

// A texture, or one of an array.
struct ShownTexture {
    static constexpr int whole = -1;
    unsigned name;
    int layer = whole;
};

// A rectangle of a GL texture whose row 0 is the lowest; the image's is the highest. The context
// must be current; what was bound is bound again.
Image colour_of(ShownTexture texture, int x, int y, int width, int height);

struct DepthInfo {
    float nearest = 1, farthest = 0;  // of the values [0, 1]
    double covered = 0;               // the share that is nearer than 1
    double mean = 0;                  // of those [0, 1]
};
DepthInfo depth_of(ShownTexture texture, int x, int y, int width, int height);

}  // namespace knead::replay
