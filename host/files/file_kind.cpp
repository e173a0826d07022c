#include "host/files/file_kind.h"

#include <filesystem>

#include "host/base/json_reader.h"
#include "host/files/particle_file.h"

namespace knead {

FileKind file_kind(const std::string& path)
{
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".hands" || ending == ".jsonl") return FileKind::recording;
    if (ending == ".obj" || ending == ".glb") return FileKind::mesh;
    if (ending == ".ply")
        return holds_particles(read_ply(path)) ? FileKind::particles : FileKind::mesh;
    if (ending == ".json") {
        const Json root = read_json(path);
        const Json schema = root.is_object() ? root.value("schema", Json()) : Json();
        if (schema == "knead.scene/1") return FileKind::scene;
        if (schema == "knead.report/1") return FileKind::report;
        throw InputError(path +
                         ": /schema: expected \"knead.scene/1\" or \"knead.report/1\", found " +
                         described(schema));
    }
    throw InputError(path +
                     ": expected a file ending in .json, .hands, .jsonl, .ply, .obj or .glb");
}

}  // namespace knead
