// Scenes of splats to measure and to test with, with statistics like those of photographed ones: an
// object of 0.4 m in a room of 6 x 4 x 8 m. Axes: right, down, forward; the object's centre is 0.
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
    double median = 0.01;  // half axis of the background's [m]
    std::uint64_t seed = 20261120;
};

// 100k 382k 480k 660k 5m-coarse 5m-fine, by their names.
const std::vector<SplatLoad>& splat_loads();

// In no order, of degree 3; the same for the same seed and any number of threads. The object's come
// first.
SplatCloud generated(const SplatLoad& load);

// Two eyes 64 mm apart, 96 degrees wide, turned by 12 degrees and down by 8, that look at the
// object's centre from 0.6 m ("far"), 0.45 m ("near45") or 0.25 m ("near", 5 cm from the object).
// Throws std::invalid_argument for another view.
std::vector<Eye<float>> load_eyes(const std::string& view, int width = 2064, int height = 2208);

// An eye at `from` that looks at `to`, `up` being up on its picture, as wide as `width_tangent` to
// either side.
Eye<float> eye_looking(Vec3<double> from, Vec3<double> to, double width_tangent, int width,
                       int height, Vec3<double> up = {0, -1, 0});

}  // namespace knead
