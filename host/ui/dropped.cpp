#include "host/ui/dropped.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/document/document.h"
#include "host/files/file_kind.h"
#include "host/scene/presets.h"
#include "host/ui/new_object.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

constexpr double floor_gap = 1e-3;  // of the table's size

DroppedKind kind_of(FileKind kind)
{
    switch (kind) {
        case FileKind::scene:
            return DroppedKind::scene;
        case FileKind::session:
            return DroppedKind::session;
        case FileKind::splats:
            return DroppedKind::splats;
        case FileKind::mesh:
            return DroppedKind::mesh;
        case FileKind::report:
        case FileKind::recording:
        case FileKind::particles:
            break;
    }
    return DroppedKind::other;
}

DroppedKind kind_of_glb(const std::string& path)
{
    try {
        if (file_kind(path) == FileKind::splats) return DroppedKind::splats;
    } catch (const InputError&) {  // has another ending
    }
    return DroppedKind::mesh;
}

// A scene that does not end in .json.
bool holds_scene(const std::string& path)
{
    std::error_code problem;
    const std::uintmax_t bytes = fs::file_size(path, problem);
    if (problem || bytes > max_json_bytes) return false;
    const Json root = Json::parse(read_text(path, max_json_bytes), nullptr, false, true);
    return root.is_object() && root.value("schema", Json()) == "knead.scene/1";
}

// The half of an object's extent along each axis, however it is turned [m].
double reach_of(const SceneObject& o)
{
    if (o.source.shape == ShapeKind::splats) return o.source.splats.size / 2;
    if (o.source.shape == ShapeKind::mesh)
        return std::max(o.source.mesh.size, length(own_extents(o))) / 2;
    return length(own_extents(o)) / 2;
}

// Above the floor, in the middle of it if nothing is there, else at the nearest of 5 x 5 places
// that is free, else above the middle one.
Vec3<double> free_place(const Document& document, double size)
{
    const WallOptions& walls = document.scene->walls;
    const Vec3<double> room = walls.max - walls.min;
    Vec3<double> middle = 0.5 * (walls.min + walls.max);
    middle.y = walls.min.y + size / 2 + floor_gap * room.y;
    const auto is_free = [&](Vec3<double> place) {
        return std::ranges::none_of(document.objects, [&](const auto& o) {
            const Vec3<double> d = o->pose.p - place;
            return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) <
                   size / 2 + reach_of(*o);
        });
    };
    std::vector<Vec3<double>> places;
    for (int i = -2; i <= 2; ++i)
        for (int k = -2; k <= 2; ++k)
            places.push_back(middle + Vec3<double>{i * std::max(0.0, room.x - size) / 4, 0,
                                                   k * std::max(0.0, room.z - size) / 4});
    std::ranges::stable_sort(places, {}, [&](Vec3<double> p) { return length(p - middle); });
    const auto found = std::ranges::find_if(places, is_free);
    if (found != places.end()) return *found;
    middle.y = std::max(middle.y, walls.max.y - size / 2 - floor_gap * room.y);
    return middle;
}

SceneObject object_of_splats(const std::string& path, const Document& document)
{
    const Vec3<double> room = document.scene->walls.max - document.scene->walls.min;
    SceneObject o;
    o.name = fs::path(path).stem().string();
    o.material = material_spec("soft-clay");
    o.source.shape = ShapeKind::splats;
    o.source.splats.file = fs::absolute(path).lexically_normal().string();
    o.source.splats.size = std::min({room.x, room.y, room.z}) / 2;
    // One of its own: other clay must not be of a category of splats.
    const auto taken = [&](int category) {
        return std::ranges::any_of(document.objects,
                                   [&](const auto& one) { return one->category == category; });
    };
    while (o.category < 255 && taken(o.category)) ++o.category;
    o.pose.p = free_place(document, o.source.splats.size);
    return o;
}

}  // namespace

DroppedKind dropped_kind(const std::string& path)
{
    std::error_code problem;
    if (fs::is_directory(path, problem)) throw InputError(path + ": is a folder");
    const std::string start = read_start(path, 6);
    if (start.starts_with("glTF")) return kind_of_glb(path);
    if (const auto first = start.find_first_not_of(" \t\r\n");
        first != std::string::npos && (start[first] == '{' || start[first] == '/')) {
        if (holds_scene(path)) return DroppedKind::scene;
        if (ending(path) != ".obj" && ending(path) != ".splat") return DroppedKind::other;
    }
    try {
        return kind_of(file_kind(path));
    } catch (const InputError&) {  // none that this program reads
        return DroppedKind::other;
    }
}

std::string refusal_of(DroppedKind kind)
{
    switch (kind) {
        case DroppedKind::scene:
        case DroppedKind::session:
        case DroppedKind::splats:
        case DroppedKind::mesh:
            return "";
        case DroppedKind::other:
            break;
    }
    return "expected a scene (.json), a session (.knead), splats (.ply, .spz, .sog, ...) or a "
           "mesh (.glb, .obj, .ply, .stl, .3mf)";
}

bool adds_object(const std::string& file)
{
    try {
        const DroppedKind kind = dropped_kind(file);
        return kind == DroppedKind::splats || kind == DroppedKind::mesh;
    } catch (const InputError&) {
        return false;
    }
}

std::variant<Command, Refusal> command_for_file(const std::string& path, const LiveState& state)
{
    const std::string name = fs::path(path).filename().string();
    DroppedKind kind = DroppedKind::other;
    try {
        kind = dropped_kind(path);
    } catch (const InputError& e) {
        return Refusal{e.what(), ""};
    }
    if (const std::string why = refusal_of(kind); !why.empty())
        return Refusal{name + ": " + why, ""};
    if (kind != DroppedKind::splats && kind != DroppedKind::mesh)
        return Command{Open{fs::absolute(path).lexically_normal().string(), {}, {}}};
    if (!state.document) return Refusal{name + ": there is no scene to add it to", ""};
    const Command add =
        AddObject{kind == DroppedKind::mesh ? new_mesh(state, path)
                                            : object_of_splats(path, *state.document)};
    if (const std::string why = row_of(add).why_not(state.situation); !why.empty())
        return Refusal{name + ": " + why, ""};
    return add;
}

}  // namespace knead
