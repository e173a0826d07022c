// Pictures of splats. Every form of the rasteriser takes a SplatFrame and gives a Picture per eye.
#pragma once
#include <functional>
#include <vector>

#include "cuda/splats/blend.h"
#include "cuda/splats/eye.h"
#include "cuda/splats/fovea.h"
#include "host/splats/cloud.h"

namespace knead {

// What lies behind splats, of one eye, rows from the top; both empty, or both width * height.
struct Backdrop {
    std::vector<Vec3<float>> colour;  // of a mesh
    std::vector<float> depth;         // along the eye's forward axis [m]; no_depth: no mesh here
};

constexpr int hidden_tile = 16;  // pixels a side

struct SplatFrame {
    std::vector<Eye<float>> eyes;  // 1 or 2: one order of depth serves both
    SplatOptions<float> options;
    Vec3<float> background{0, 0, 0};  // where there is no mesh
    std::vector<Backdrop> behind;     // per eye; empty: none
    // Of the first splats, as many as there are: where they are [m], and the total deformation
    // gradient that turns and stretches them.
    std::vector<Vec3<float>> moved_centre;
    std::vector<Mat3<float>> moved_F;
    // Those that a device moved and keeps (DeviceGaussians) go on as they came, by so much of their
    // way since the state before.
    float extrapolation = 0;
    // Per eye, of its tiles, rows from the top: 1 where nobody sees one, which is left empty. No
    // tiles, or no eyes: all is seen.
    std::vector<std::vector<char>> hidden;
    // Per eye, beside which one sample stands for several pixels; none: all pixels are drawn.
    std::vector<Fovea<float>> fovea;
    // On the CPU, asked every few milliseconds at every stage, by several threads: true gives the
    // pictures up, of which there are then none.
    std::function<bool()> stop;

    bool stopped() const { return stop && stop(); }
};

// What is fine up to so many degrees from the eye's forward axis, and 4 x 4 from 15 more on.
Fovea<float> fovea_of(double degrees);
// The share of an eye's pixels that are blended: of those that stand alone 1, of 4 x 4 1/16.
double blended_share(const SplatFrame& frame, std::size_t eye);

struct Picture {
    int width = 0, height = 0;
    std::vector<Vec3<float>> colour;  // rows from the top; background and mesh included
    std::vector<float> alpha;         // what splats and mesh cover
    std::vector<float> depth;         // [m]: where half of what lies behind is hidden; or no_depth

    std::size_t pixels() const { return colour.size(); }
};

// Throws std::invalid_argument where a frame has no meaning: eyes, sizes of backdrops, counts.
void check_frame(const SplatCloud& cloud, const SplatFrame& frame);

// In float, tile by tile, as on the GPU: the order of the same keys, the same cuts. The same bits
// for any number of threads. Throws as check_frame().
std::vector<Picture> cpu_raster(const SplatCloud& cloud, const SplatFrame& frame);

// By what splats of a pixel are ordered.
enum class DepthOrder {
    middle,  // the distance of the centre from the point between the eyes
    eye,     // the distance of the centre from the eye
    plane,   // the centre's depth along the eye's forward axis
    pixel    // the depth of the splat at the pixel
};

// In double, every splat in every pixel, in the order of distances that are not rounded to keys, as
// far as anything shines through: the reference, with every pixel. Slow: pixels times splats.
std::vector<Picture> exact_raster(const SplatCloud& cloud, const SplatFrame& frame,
                                  DepthOrder order = DepthOrder::middle);

// Peak signal-to-noise ratio of the colours, white being 1 [dB]; 200 for equal ones. Throws
// std::invalid_argument where sizes differ.
double psnr(const Picture& a, const Picture& b);

}  // namespace knead
