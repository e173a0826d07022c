// Scene keys of splat objects and of the upkeep of their splats.
#pragma once
#include "host/base/json_reader.h"
#include "host/scene/scene.h"

namespace knead {

void read_splats_options(ObjectReader& r, SplatsOptions& splats);
void read_upkeep(ObjectReader& r, UpkeepOptions& upkeep);

}  // namespace knead
