// 3MF, the format of 3D printing (3MF Core Specification 1.3): meshes with names, colours and a
// unit, as XML in a ZIP archive.
#pragma once
#include <string>
#include <vector>

#include "host/files/mesh_reader.h"

namespace knead {

// What its build places, in metres: objects and those that they are composed of, by their
// transforms, also of other parts of the archive (production extension). Colours of base materials
// and colour groups are those of the vertices. Throws InputError with path, part, byte, expected
// and found; also for an extension that the file requires and that is not known here.
MeshFile parse_3mf(const std::string& bytes, const std::string& path);

// One object per mesh. `unit`: of the vertices, as in MeshLabels. Throws OutputError for more than
// the 4 GiB of the archive; `path` is used in messages only.
std::string three_mf_bytes(const std::vector<const Mesh*>& meshes,
                           const std::vector<std::string>& names, const std::string& unit,
                           const std::string& path);

}  // namespace knead
