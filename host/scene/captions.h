// Words that stand in a scene's pictures.
#pragma once
#include <string>
#include <vector>

#include "host/base/json_reader.h"

namespace knead {

struct Caption {
    std::string text;  // printable ASCII
    Vec3<double> at;   // where its middle is in the picture [m]
};

// The key "captions" of a scene's "pictures": an array of at most 256 objects with text and place.
std::vector<Caption> read_captions(ObjectReader& pictures);

}  // namespace knead
