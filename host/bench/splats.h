// One measured picture of a generated scene of splats, for both eyes.
#pragma once
#include "host/bench/bench.h"
#include "host/splats/generate.h"
#include "host/splats/raster.h"

namespace knead {

struct SplatCase {
    SplatLoad load;
    std::string view = "far";         // of load_eyes()
    int width = 2064, height = 2208;  // pixels of an eye
    bool moving = true;               // every splat is turned and stretched, else none
    bool check = true;                // a GPU's picture is compared with the CPU's
    double foveate = 0;               // of fovea_of() [degrees]; 0: every pixel is drawn
    int frames = 200;                 // timed
    double limit = 20;                // [s] after which a CPU begins no frame; it times two
};

// The frame of the case: its eyes, and where all is twisted about the upright line through the
// object, its deformation.
SplatFrame frame_of(const SplatCase& what, const SplatCloud& cloud);

// `cloud`: of the case's load, in any order. `copy`: of DeviceInfo. The hash is that of the
// pictures' bits. Throws std::runtime_error where the device fails.
BenchRow splat_row(const SplatCase& what, const SplatCloud& cloud, Device device, double copy);

}  // namespace knead
