// How the file of an object lies in its frame.
#pragma once
#include "cuda/math/vec.h"
#include "host/scene/scene.h"

namespace knead {

// From the file's frame to the object's, whose y is up. `turn`: about it, once upright [degrees].
Quat<double> upright(UpAxis up, double turn);

}  // namespace knead
