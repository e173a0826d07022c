// Clay laid with the mouse: a pure model of one drag, from the button's press to its release.
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
// is of clay. Precondition: there is a document.
NozzleTool nozzle_tool(const UiState& ui);

class NozzleGesture {
  public:
    // `at`: what is below the pointer, on which the clay is laid. `origin`: of the simulation's
    // frame in that of the scene's file.
    NozzleGesture(const NozzleTool& tool, const TransformView& view, const TransformSurface& at,
                  Vec3<double> origin);

    SourceBegin begin() const;
    // The pointer's new place: in the plane of the surface where the drag began, if it is seen at
    // more than 20 degrees, else across the gaze. Nothing if it has moved less than a tenth of
    // the diameter.
    std::optional<SourceMove> move(const TransformView& view);
    SourceEnd end() const { return {ObjectRef(tool_.name)}; }

  private:
    NozzleTool tool_;
    Vec3<double> origin_, last_, normal_;  // normal_: of the plane, unit
    double farthest_;                      // from the eye [m]
};

}  // namespace knead
