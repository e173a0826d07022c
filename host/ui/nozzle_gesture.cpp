#include "host/ui/nozzle_gesture.h"

#include <algorithm>
#include <cmath>

#include "host/scene/names.h"
#include "host/scene/presets.h"

namespace knead {

NozzleTool nozzle_tool(const UiState& ui, std::optional<double> ring)
{
    NozzleTool tool;
    tool.name = free_name(*ui.document, "strand");
    tool.section = ui.ring ? SectionKind::circle : nozzle_sections[std::size_t(ui.section)];
    tool.diameter = ui.diameter;
    if (ui.ring && ring) tool.diameter = std::clamp(*ring, nozzle_range.low, nozzle_range.high);
    const SceneObject* const like = ui.document->find(ui.chosen);
    const bool clay = like && like->source.shape != ShapeKind::splats;
    tool.material = clay ? like->material : material_spec("clay");
    tool.category = clay ? like->category : free_category(*ui.document);
    return tool;
}

NozzleGesture::NozzleGesture(const NozzleTool& tool, const TransformView& view,
                             const TransformSurface& at, Vec3<double> origin)
    : tool_(tool), origin_(origin)
{
    constexpr double seen_well = 0.34, farther = 10;
    last_ = at.point + tool.diameter / 2 * at.normal;
    const double facing = std::abs(dot(at.normal, view.ray)) / length(view.ray);
    normal_ = facing > seen_well ? at.normal : view.forward;
    farthest_ = farther * length(last_ - view.eye);
}

NozzleGesture::NozzleGesture(const NozzleTool& tool, Vec3<double> at, Vec3<double> origin)
    : tool_(tool), origin_(origin), last_(at)
{
}

SourceBegin NozzleGesture::begin() const
{
    SourceBegin begins;
    begins.name = tool_.name;
    begins.section = tool_.section, begins.diameter = tool_.diameter;
    begins.material = tool_.material, begins.category = tool_.category;
    begins.at = last_ + origin_;
    return begins;
}

std::optional<SourceMove> NozzleGesture::move(const TransformView& view)
{
    const double along = dot(view.ray, normal_);
    const double t = dot(last_ - view.eye, normal_) / along;
    if (!(t > 0) || !(t * length(view.ray) <= farthest_)) return {};
    return move_to(view.eye + t * view.ray);
}

std::optional<SourceMove> NozzleGesture::move_to(Vec3<double> to)
{
    constexpr double part = 0.1;  // of the diameter
    if (length(to - last_) < part * tool_.diameter) return {};
    last_ = to;
    return SourceMove{ObjectRef(tool_.name), to + origin_, {}};
}

bool clogged(const LiveState& state, const NozzleGesture& nozzle)
{
    if (!state.source.clogged || !state.document) return false;
    const SceneObject* const laid = state.document->find(state.source.object);
    return laid && laid->name == nozzle.name();
}

}  // namespace knead
