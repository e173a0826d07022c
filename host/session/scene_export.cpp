#include "host/session/scene_export.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "cuda/math/rotation.h"
#include "host/files/mesh_file.h"
#include "host/files/splat_file.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

// Gaussians of objects that the document does not have are those of cubes of local clay, and splats
// without Gaussians are frozen: both are of its only object with a depth.
SplatCloud of_objects(const SplatCloud& cloud, const std::vector<Gaussian<double>>& gaussians,
                      const ExportPlan& plan, const ShownScene& scene)
{
    std::set<int> known, chosen;
    bool local = false;
    for (const auto& o : scene.document->objects) {
        const bool is_chosen = std::ranges::count(plan.objects, o->id) > 0;
        const auto number = scene.numbers.find(o->id);
        if (o->source.splats.depth > 0) {
            local = local || is_chosen;
        } else if (number != scene.numbers.end()) {
            known.insert(number->second.begin(), number->second.end());
            if (is_chosen) chosen.insert(number->second.begin(), number->second.end());
        }
    }
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const int object = i < gaussians.size() ? gaussians[i].object : -1;
        if (known.contains(object) ? chosen.contains(object) : local)
            indices.push_back(std::uint32_t(i));
    }
    return picked(cloud, indices);
}

void write_surface(const std::string& file, const ExportPlan& plan, const ShownScene& scene)
{
    const Meshes all = scene.surface();
    std::set<int> categories;
    for (const ObjectId id : plan.objects) categories.insert(scene.document->find(id)->category);
    const double scale = per_metre(plan.unit);
    std::vector<Mesh> meshes;
    MeshLabels labels{{}, plural(plan.unit)};
    for (const Mesh& mesh : *all) {
        if (mesh.triangles.empty() || !categories.contains(mesh.category)) continue;
        Mesh& placed = meshes.emplace_back(mesh);
        for (Vec3<float>& v : placed.vertices)
            v = cast<float>(scale * (cast<double>(v) + scene.origin));
        labels.names.push_back(surface_name(*scene.document, mesh.category));
    }
    if (meshes.empty()) throw std::invalid_argument("there is no surface to export");
    write_mesh(file, meshes, labels);
}

}  // namespace

SplatCloud splats_for_file(const SplatCloud& cloud, Vec3<double> origin, double scale)
{
    const Quat<double> turn{0, 1, 0, 0};
    return placed(cloud, turn, scale, scale * rotate(turn, origin));
}

void write_export(const std::string& file, const ExportPlan& plan, const ShownScene& scene)
{
    if (plan.what == ExportContent::surface) return write_surface(file, plan, scene);
    if (!scene.splats) throw std::invalid_argument("there are no splats to export");
    std::vector<Gaussian<double>> gaussians;
    if (scene.gaussians) gaussians = scene.gaussians();
    SplatCloud cloud = deformed(*scene.splats, gaussians);
    if (plan.partial) cloud = of_objects(cloud, gaussians, plan, scene);
    if (cloud.count() == 0) throw std::invalid_argument("there are no splats to export");
    write_splats(file, splats_for_file(cloud, scene.origin, per_metre(plan.unit)));
}

}  // namespace knead
