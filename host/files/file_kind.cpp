#include "host/files/file_kind.h"

#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/files/chunk_file.h"
#include "host/files/particle_file.h"
#include "host/files/splat_file.h"

namespace knead {
namespace {

constexpr std::size_t longest_header = 1 << 20;  // of a PLY file [bytes]

FileKind ply_kind(const PlyFile& header)
{
    if (holds_splats(header)) return FileKind::splats;
    return holds_particles(header) ? FileKind::particles : FileKind::mesh;
}

// The document of a .glb may be longer than `start`.
bool holds_splat_glb(const std::string& path, const std::string& start)
{
    if (start.size() < longest_header) return begins_splat_glb(start);
    return begins_splat_glb(read_start(path, max_json_bytes + 20));
}

// File extension for the format of these first bytes; "" if unknown.
std::string form_of(const std::string& start)
{
    if (start.starts_with("KNHANDS1")) return ".hands";
    if (start.starts_with("glTF")) return ".glb";
    if (start.starts_with("solid")) return ".stl";
    if (start.starts_with("ply\n") || start.starts_with("ply\r")) return ".ply";
    if (begins_spz(start)) return ".spz";
    const std::string line = start.substr(0, start.find('\n'));
    if (line.find("\"knead.hands/1\"") != std::string::npos) return ".jsonl";
    const std::size_t first = start.find_first_not_of(" \t\r\n");
    const bool json = first != std::string::npos && (start[first] == '{' || start[first] == '/');
    return json ? ".json" : "";
}

}  // namespace

std::string with_form(const std::string& path, const std::string& format)
{
    if (path != "-") return path;
    if (!format.empty()) return format.starts_with('.') ? "-" + format : "-." + format;
    const std::string form = form_of(read_start(path, longest_header));
    if (form.empty())
        throw InputError(
            "-: how it begins does not say what it is: obj, csv and splat do not; "
            "`knead convert` takes --from, others a file's name");
    return path + form;
}

FileKind file_kind(const std::string& path)
{
    if (is_sog_folder(path)) return FileKind::splats;
    const std::string start = read_start(path, longest_header);
    const std::string form = path == "-" ? form_of(start) : ending(path);
    if (form == ".ply" || start.starts_with("ply\n") || start.starts_with("ply\r"))
        return ply_kind(parse_ply_header(start, path));
    if (begins_session(start) || form == ".knead") return FileKind::session;
    if (begins_spz(start) || form == ".splat" || form == ".spz" || form == ".ksplat" ||
        form == ".sog")
        return FileKind::splats;
    refuse_unread_splats(path, start);
    if (form == ".glb" && holds_splat_glb(path, start)) return FileKind::splats;
    if (form == ".hands" || form == ".jsonl") return FileKind::recording;
    if (form == ".obj" || form == ".glb" || form == ".stl" || form == ".3mf") return FileKind::mesh;
    if (form == ".csv") return FileKind::particles;
    if (form == ".json") {
        const Json root = read_json(path);
        const Json schema = root.is_object() ? root.value("schema", Json()) : Json();
        if (schema == "knead.scene/1") return FileKind::scene;
        if (schema == "knead.report/1") return FileKind::report;
        throw InputError(path +
                         ": /schema: expected \"knead.scene/1\" or \"knead.report/1\", found " +
                         described(schema));
    }
    throw InputError(path +
                     ": expected a file ending in .json, .hands, .jsonl, .ply, .obj, .glb, "
                     ".stl, .3mf, .csv, .splat, .spz, .ksplat, .sog or .knead");
}

}  // namespace knead
