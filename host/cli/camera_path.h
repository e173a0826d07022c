// Where `knead render` looks from while a video goes on.
#pragma once
#include <string>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

struct View {
    Vec3<double> eye, at;  // [m]: where it is seen from, and what is looked at
};

// A view that is passed at a time.
struct CameraKey {
    double time;  // [s]
    View view;
};

// Of a file {"schema": "knead.path/1", "keys": [{"time": 0, "eye": [x, y, z], "at": [x, y, z]}]},
// at least two keys, later and later, over at most an hour. Throws InputError with file and place.
std::vector<CameraKey> read_camera_path(const std::string& file);

// Between the keys, smoothly through each of them; before the first and behind the last, those.
// [Catmull 1974], with the keys' own times.
View view_at(const std::vector<CameraKey>& keys, double time);

}  // namespace knead
