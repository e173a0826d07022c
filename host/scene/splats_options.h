// What a scene says of splats: of an object that is a photograph, and of how they are kept dense.
#pragma once
#include "host/base/json_reader.h"
#include "host/scene/scene.h"

namespace knead {

void read_splats_options(ObjectReader& r, SplatsOptions& splats);
void read_upkeep(ObjectReader& r, UpkeepOptions& upkeep);

}  // namespace knead
