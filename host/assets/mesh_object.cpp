#include "host/assets/mesh_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <vector>

#include "host/assets/upright.h"
#include "host/base/errors.h"
#include "host/files/mesh_reader.h"
#include "host/scene/shapes.h"
#include "host/scene/solid_mesh.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_kept = 16;

// Of a file when it was read.
struct Stamp {
    std::uintmax_t bytes = 0;
    fs::file_time_type changed;
    bool operator==(const Stamp&) const = default;
};
struct Kept {
    std::string file;
    UpAxis up;
    double turn;
    Stamp stamp;
    std::shared_ptr<const SolidMesh> solid;
};
struct KeptSolids {
    std::mutex mutex;
    std::vector<Kept> all;  // the one read last is the last
};
KeptSolids& kept_solids()
{
    static KeptSolids kept;
    return kept;
}

bool same_source(const Kept& one, const MeshOptions& mesh)
{
    return one.file == mesh.file && one.up == mesh.up && one.turn == mesh.turn;
}

Stamp stamp_of(const std::string& file)
{
    std::error_code problem;
    Stamp stamp;
    stamp.bytes = fs::file_size(file, problem);
    stamp.changed = fs::last_write_time(file, problem);
    return stamp;
}

std::shared_ptr<const SolidMesh> solid_of(const MeshOptions& mesh)
{
    const Stamp stamp = stamp_of(mesh.file);
    KeptSolids& kept = kept_solids();
    {
        const std::lock_guard lock(kept.mutex);
        for (const Kept& one : kept.all)
            if (same_source(one, mesh) && one.stamp == stamp) return one.solid;
    }
    const MeshFile file = read_mesh_file(mesh.file);
    std::vector<Vec3<double>> vertices;
    std::vector<Int3> triangles;
    for (const FileMesh& one : file.meshes) {
        const int before = int(vertices.size());
        vertices.insert(vertices.end(), one.vertices.begin(), one.vertices.end());
        for (const Int3 t : one.triangles) triangles.push_back(t + Int3{before, before, before});
    }
    MadeSolid made = SolidMesh::make(vertices, triangles, upright(mesh.up, mesh.turn));
    if (!made.solid)
        throw InputError(
            fmt::format("{}: expected a closed surface, found {}", mesh.file, made.why));
    const std::lock_guard lock(kept.mutex);
    std::erase_if(kept.all, [&](const Kept& one) { return same_source(one, mesh); });
    if (kept.all.size() >= most_kept) kept.all.erase(kept.all.begin());
    kept.all.push_back({mesh.file, mesh.up, mesh.turn, stamp, made.solid});
    return made.solid;
}

}  // namespace

void load_meshes(Scene& scene)
{
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        Object& o = scene.objects[i];
        if (o.shape != ShapeKind::mesh) continue;
        const std::string where = fmt::format("{}: /objects/{}", scene.path, i);
        try {
            o.solid = solid_of(o.mesh);
        } catch (const InputError& e) {
            throw InputError(where + ": " + e.what());
        }
        if (const auto fault = shape_fault(o))
            throw InputError(fmt::format("{}/{}: expected {}, found {}", where, fault->key,
                                         fault->expected, fault->found));
    }
}

std::shared_ptr<const SolidMesh> known_solid(const Object& o)
{
    if (o.shape != ShapeKind::mesh) return nullptr;
    KeptSolids& kept = kept_solids();
    const std::lock_guard lock(kept.mutex);
    for (const Kept& one : kept.all)
        if (same_source(one, o.mesh)) return one.solid;
    return nullptr;
}

}  // namespace knead
