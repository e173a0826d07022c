// Shade of what stands above clay.
#include <algorithm>
#include <cmath>

#include "tests/render/eye_picture.h"

#if KNEAD_HAS_GL
namespace knead {
namespace {

// A rod above the side of a ball, in shade: all that it takes is light from above, and the border
// of that is soft wherever the ball is steep.
TEST_F(EyePicture, WhatStandsAboveClayShadesItWithoutAnEdge)
{
    EyeLook look;
    look.floor = 0;
    look.light = {0, 0.3f, -1};  // from behind
    const auto clay = [&](bool shaded) {
        DrawPrimitive rod{2, {}};
        rod.sphere[0].c = {0.3f, 0.62f, 0.62f}, rod.sphere[1].c = {0.7f, 0.62f, 0.80f};
        rod.sphere[0].r = rod.sphere[1].r = 0.05f;
        painter->set_hands(shaded ? std::vector<DrawPrimitive>{rod} : std::vector<DrawPrimitive>{});
        const EyeView view = eye_view(
            {{0.5f, 0.3f, 1.9f}, ball_centre, 0.42f, 4 * picture_width, 4 * picture_height});
        OffscreenTarget large(GL_RGBA8, 4 * picture_width, 4 * picture_height);
        painter->paint(view, look, {large.frame});
        return large.colours();
    };
    painter->set_clay({ball(ball_centre, 0.25f)}, 1);
    const std::vector<int> open = clay(false), shaded = clay(true);
    // Of the ball's front below the rod.
    const int w = 4 * picture_width, h = 4 * picture_height;
    double darkest = 1, steepest = 0;
    const auto share = [&](int x, int y) {
        const int at = y * w + x;
        return double(red_green_blue(shaded, at)) / std::max(1, red_green_blue(open, at));
    };
    for (int y = h / 4; y < h / 2; ++y)
        for (int x = w / 2 - h / 5; x < w / 2 + h / 5; ++x) {
            darkest = std::min(darkest, share(x, y));
            steepest = std::max({steepest, std::abs(share(x, y) - share(x + 1, y)),
                                 std::abs(share(x, y) - share(x, y + 1))});
        }
    EXPECT_LT(darkest, 0.9) << "there is a shade";
    EXPECT_LT(steepest, 0.04) << "from pixel to pixel";
}

}  // namespace
}  // namespace knead
#endif
