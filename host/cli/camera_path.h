// Camera paths of `knead render` videos.
#pragma once
#include <string>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

struct View {
    Vec3<double> eye, at;  // position and target [m]
};

// A view with its time.
struct CameraKey {
    double time;  // [s]
    View view;
};

// Reads {"schema": "knead.path/1", "keys": [{"time": 0, "eye": [x, y, z], "at": [x, y, z]}]}: at
// least two keys, times strictly increasing, over at most an hour. Throws InputError with file and
// place.
std::vector<CameraKey> read_camera_path(const std::string& file);

// Interpolates the keys by a cubic spline through each of them, clamped to the first and the last.
// [Catmull 1974], with non-uniform times.
View view_at(const std::vector<CameraKey>& keys, double time);

}  // namespace knead
