#include "host/ui/nozzle_gesture.h"

#include <cmath>

#include "host/scene/names.h"
#include "host/scene/presets.h"

namespace knead {

NozzleTool nozzle_tool(const UiState& ui)
{
    NozzleTool tool;
    tool.name = free_name(*ui.document, "strand");
    tool.section = section_kinds[std::size_t(ui.section)].second;
    tool.diameter = ui.diameter;
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
    constexpr double part = 0.1;  // of the diameter
    const double along = dot(view.ray, normal_);
    const double t = dot(last_ - view.eye, normal_) / along;
    if (!(t > 0) || !(t * length(view.ray) <= farthest_)) return {};
    const Vec3<double> to = view.eye + t * view.ray;
    if (length(to - last_) < part * tool_.diameter) return {};
    last_ = to;
    return SourceMove{ObjectRef(tool_.name), to + origin_, {}};
}

}  // namespace knead
