// Text captions drawn into a scene's pictures.
#pragma once
#include <string>
#include <vector>

#include "host/base/json_reader.h"

namespace knead {

struct Caption {
    std::string text;  // printable ASCII
    Vec3<double> at;   // centre of the text, a point of the scene [m]
};

// Reads the key "captions" of a scene's "pictures": an array of at most 256 objects with text and
// position. Throws InputError.
std::vector<Caption> read_captions(ObjectReader& pictures);

}  // namespace knead
