// Clay laid with the mouse or a hand: a pure model of one drag, from the press of the button or the
// pinch to its release.
#pragma once
#include <optional>
#include <string>

#include "host/document/command.h"
#include "host/ui/panel_model.h"
#include "host/ui/transform_gesture.h"

namespace knead {

struct NozzleTool {
    std::string name;  // of the new object
    SectionKind section = SectionKind::circle;
    double diameter = 0.04;  // [m]
    MaterialSpec material{};
    int category = 0;
};

// With section and diameter of the panel, and material and category of the active object, if that
// is of clay. `ring`: diameter of the circle that the hand forms, used if UiState::ring [m].
// Precondition: there is a document.
NozzleTool nozzle_tool(const UiState& ui, std::optional<double> ring = {});

class NozzleGesture {
  public:
    // `at`: what is below the pointer, on which the clay is laid. `origin`: of the simulation's
    // frame in that of the scene's file.
    NozzleGesture(const NozzleTool& tool, const TransformView& view, const TransformSurface& at,
                  Vec3<double> origin);
    // In the air.
    NozzleGesture(const NozzleTool& tool, Vec3<double> at, Vec3<double> origin);

    SourceBegin begin() const;
    // The pointer's new place: in the plane of the surface where the drag began, if it is seen at
    // more than 20 degrees, else across the gaze. Nothing if it has moved less than a tenth of
    // the diameter.
    std::optional<SourceMove> move(const TransformView& view);
    // To a point, as freely.
    std::optional<SourceMove> move_to(Vec3<double> to);
    const std::string& name() const { return tool_.name; }
    SourceEnd end() const { return {ObjectRef(tool_.name)}; }

  private:
    NozzleTool tool_;
    Vec3<double> origin_, last_, normal_{0, 1, 0};  // normal_: of the plane, unit
    double farthest_ = 0;                           // from the eye [m]
};

// Whether the nozzle has just laid none of the clay that it should have: other clay, or a wall, is
// in its place.
bool clogged(const LiveState& state, const NozzleGesture& nozzle);
inline constexpr const char* clogged_notice =
    "The nozzle is in other clay or in a wall: it lays nothing.";

}  // namespace knead
