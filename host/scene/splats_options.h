// Scene keys of objects of files, splats or a mesh, and of the upkeep of splats.
#pragma once
#include "host/base/json_reader.h"
#include "host/scene/scene.h"

namespace knead {

// `folder`: see read_object().
void read_splats_options(ObjectReader& r, SplatsOptions& splats, const std::string& folder);
// Writes the same keys into `object`, the file relative to the folder of a document at `path`.
void write_splats_options(const SplatsOptions& splats, const std::string& path, Json& object);
void read_mesh_options(ObjectReader& r, MeshOptions& mesh, const std::string& folder);
void write_mesh_options(const MeshOptions& mesh, const std::string& path, Json& object);
void read_upkeep(ObjectReader& r, UpkeepOptions& upkeep);

}  // namespace knead
