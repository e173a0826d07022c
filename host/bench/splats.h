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
    bool moving = true;               // true: every splat is deformed; false: none
    bool check = true;                // compare the GPU's picture with the CPU's
    double foveate = 0;               // argument of fovea_of() [degrees]; 0: every pixel is drawn
    int frames = 200;                 // timed
    double limit = 20;  // [s] after which a CPU starts no frame; at least two are timed
};

// The frame of the case: its eyes and, if `moving`, a twist of all splats about the vertical axis.
SplatFrame frame_of(const SplatCase& what, const SplatCloud& cloud);

// Measures the case. `cloud`: of the case's load, in any order. `copy`: DeviceInfo::copy. The row's
// hash is computed from the pictures' bits. Throws std::runtime_error on a device error.
BenchRow splat_row(const SplatCase& what, const SplatCloud& cloud, Device device, double copy);

}  // namespace knead
