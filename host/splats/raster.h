// Pictures of splats. Every rasteriser maps a SplatFrame to one Picture per eye.
#pragma once
#include <functional>
#include <vector>

#include "cuda/splats/blend.h"
#include "cuda/splats/eye.h"
#include "cuda/splats/fovea.h"
#include "host/splats/cloud.h"

namespace knead {

// Mesh behind the splats, for one eye, rows from the top; both arrays empty, or both of width *
// height.
struct Backdrop {
    std::vector<Vec3<float>> colour;  // of the mesh
    std::vector<float> depth;         // along the eye's forward axis [m]; no_depth: no mesh
};

constexpr int hidden_tile = 16;  // pixels per side

struct SplatFrame {
    std::vector<Eye<float>> eyes;  // 1 or 2; one depth order serves both
    SplatOptions<float> options;
    Vec3<float> background{0, 0, 0};  // colour without mesh
    std::vector<Backdrop> behind;     // per eye; empty: none
    // Centres of the first splats [m], and the total deformation gradient applied to each.
    std::vector<Vec3<float>> moved_centre;
    std::vector<Mat3<float>> moved_F;
    // Snapshots on the device (DeviceGaussians) are extrapolated by this multiple of their motion
    // since the previous state.
    float extrapolation = 0;
    // Per eye and tile, rows from the top: 1 if the tile is hidden and left empty. No tiles, or no
    // eyes: none is hidden.
    std::vector<std::vector<char>> hidden;
    // Foveated rendering, per eye: outside the fovea one sample covers several pixels. Empty: every
    // pixel is drawn.
    std::vector<Fovea<float>> fovea;
    // On the CPU, polled every few milliseconds in every stage, by several threads: return true to
    // cancel; no pictures are then returned.
    std::function<bool()> stop;

    bool stopped() const { return stop && stop(); }
};

// Full resolution up to `degrees` from the eye's forward axis, and 4 x 4 pixels per sample from 15
// degrees more on.
Fovea<float> fovea_of(double degrees);
// Samples per pixel of an eye: 1 at full resolution, 1/16 where one sample covers 4 x 4 pixels.
double blended_share(const SplatFrame& frame, std::size_t eye);

struct Picture {
    int width = 0, height = 0;
    std::vector<Vec3<float>> colour;  // rows from the top; includes background and mesh
    std::vector<float> alpha;         // coverage by splats and mesh
    std::vector<float> depth;         // depth where transmittance falls to 1/2 [m]; or no_depth

    std::size_t pixels() const { return colour.size(); }
};

// Throws std::invalid_argument for invalid frames: eyes, sizes of backdrops, counts.
void check_frame(const SplatCloud& cloud, const SplatFrame& frame);

// In float, tile by tile, as on the GPU: same sort keys, same cutoffs. Bitwise equal for any number
// of threads. Throws as check_frame().
std::vector<Picture> cpu_raster(const SplatCloud& cloud, const SplatFrame& frame);

// Sort criterion of the splats of a pixel.
enum class DepthOrder {
    middle,  // distance of the centre from the midpoint of the eyes
    eye,     // distance of the centre from the eye
    plane,   // depth of the centre along the eye's forward axis
    pixel    // depth of the splat at the pixel
};

// The reference, in double: every splat in every pixel, sorted by unquantised distances, until the
// pixel is opaque, without fovea. Slow: pixels times splats.
std::vector<Picture> exact_raster(const SplatCloud& cloud, const SplatFrame& frame,
                                  DepthOrder order = DepthOrder::middle);

// Peak signal-to-noise ratio of the colours, with white 1 [dB]; 200 for equal pictures. Throws
// std::invalid_argument if the sizes differ.
double psnr(const Picture& a, const Picture& b);

}  // namespace knead
