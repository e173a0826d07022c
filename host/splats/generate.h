// Synthetic splat scenes for benchmarks and tests, with statistics like photographed ones: an
// object of 0.4 m in a room of 6 x 4 x 8 m. Axes: right, down, forward; the origin is the object's
// centre.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "cuda/splats/eye.h"
#include "host/splats/cloud.h"

namespace knead {

struct SplatLoad {
    std::string name;
    int object = 60000;    // splats of the bumpy ball
    int background = 0;    // splats of the room: walls, boxes, floaters
    double median = 0.01;  // median half axis of the background splats [m]
    std::uint64_t seed = 20261120;
};

// Named loads: 100k 382k 480k 660k 5m-coarse 5m-fine.
const std::vector<SplatLoad>& splat_loads();

// Generates a cloud of degree 3, the object's splats first, otherwise unordered; equal for equal
// seeds and any number of threads.
SplatCloud generated(const SplatLoad& load);

// Two eyes 64 mm apart, 96 degrees wide, rotated by 12 degrees and down by 8, looking at the
// object's centre from 0.6 m ("far"), 0.45 m ("near45") or 0.25 m ("near", 5 cm from the object).
// Throws std::invalid_argument for another view.
std::vector<Eye<float>> load_eyes(const std::string& view, int width = 2064, int height = 2208);

// An eye at `from` looking at `to`, with `up` upwards in its picture; `width_tangent` is the
// tangent of half its horizontal field of view.
Eye<float> eye_looking(Vec3<double> from, Vec3<double> to, double width_tangent, int width,
                       int height, Vec3<double> up = {0, -1, 0});

}  // namespace knead
