#include <fmt/format.h>

#include <algorithm>

#include "host/run/run.h"

namespace knead {

double moved_share(const RunRecord& record)
{
    double moved = 0, all = 0;
    for (const FrameRow& row : record.rows) {
        moved += double(row.stats[Count::moved]);
        all += double(record.particles) * row.stats.substeps;
    }
    return all > 0 ? moved / all : 1;
}

std::vector<std::string> left_at_rest(const RunRecord& record)
{
    std::vector<std::string> out;
    const double still = 1 - moved_share(record);
    if (still > 0)
        out.push_back(fmt::format("clay at rest: {:.3g} % of all particle-substeps", 100 * still));
    const auto frames = [&](bool FrameRow::*which) {
        return std::count_if(record.rows.begin(), record.rows.end(),
                             [&](const FrameRow& row) { return row.*which; });
    };
    if (frames(&FrameRow::kept) > 0)
        out.push_back(fmt::format("surface: of {} meshed frames in {} nothing had moved",
                                  frames(&FrameRow::meshed), frames(&FrameRow::kept)));
    return out;
}

std::vector<std::string> left_out(const Scene& scene, const BatchRunOptions& options)
{
    std::vector<std::string> out;
    if (!scene.has_hands)
        out.push_back("contact: the scene has no hands");
    else if (scene.setup.tools.empty())
        out.push_back("contact: neither hand is present");
    if (scene.has_hands && !scene.setup.grid_contact)
        out.push_back("grid contact: switched off by /contact/grid");
    if (scene.has_hands && scene.setup.passes == 0)
        out.push_back("particle projection: switched off by /contact/passes");
    const auto& tools = scene.setup.tools;
    if (std::none_of(tools.begin(), tools.end(), [](const Tool<double>& t) { return t.blade; }))
        out.push_back("cutting: no hand holds a blade");
    const auto yields = [](const Object& o) {
        return o.material.plasticity != Plasticity::none &&
               o.material.plasticity != Plasticity::fluid;
    };
    if (std::none_of(scene.objects.begin(), scene.objects.end(), yields))
        out.push_back("plasticity: no object yields");
    if (scene.setup.rest.mode == RestMode::none) out.push_back("sleep: not asked for (/rest/mode)");
    const auto splats = [](const Object& o) { return o.shape == ShapeKind::splats; };
    if (std::none_of(scene.objects.begin(), scene.objects.end(), splats))
        out.push_back("Gaussians: the scene has none");
    if (options.mesh_every == 0 && options.meshes_every == 0 && !options.last_mesh)
        out.push_back("surface: neither mesh nor pictures are asked for");
    else if (options.mesh_every == 0)
        out.push_back("pictures: not asked for");
    if (options.audit_every > 1)
        out.push_back(fmt::format("audits: of every frame; one in {}", options.audit_every));
    return out;
}

}  // namespace knead
