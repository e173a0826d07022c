// Conversion of a live state to the input of a live painter.
#pragma once
#include "host/live/live_session.h"
#include "host/picture/splat_layer.h"
#include "render/eye_painter.h"

namespace knead {

// Floor and stage of a scene.
EyeLook live_look(const Scene& scene);
// Version of a state's clay for a painter; differs between histories.
long clay_version(const LiveState& state);
// The motion of a state's splats.
inline SplatMotion splat_motion(const LiveState& state)
{
    return {state.gaussians.get(), state.gaussians_on_device.get()};
}
// Whether there are splats and all their objects are hidden.
bool splats_hidden(const LiveState& state);
// Colours of objects that have one. `places`: of about this state, for the surface on the host,
// vertex by vertex; null: by category, where all its objects have the same.
ClayColours clay_colours(const Document& document, const std::vector<Mesh>* meshes,
                         const ObjectPlaces* places);
ClayColours clay_colours(const LiveState& state, const ObjectPlaces* places);
// Sets the clay of a state in a painter, with clay_version(), without that of hidden categories.
// `colours`: null: by category.
void show_clay(EyePainter& painter, const LiveState& state, const ClayColours* colours = nullptr);
// Hands at the end of a motion: their skin, scaled by the motion's size, and the tools that they
// hold, unscaled.
std::vector<HandLook> hand_looks(const HandsOptions& options, const Motion& motion,
                                 float opacity = 1);
// The active tools of the simulation.
std::vector<HandLook> hand_looks(const LiveState& state);
// Tracked hands at their current position, independent of the simulation's progress.
std::vector<HandLook> tracked_looks(const HandFrame& frame, const HandsOptions& options,
                                    float opacity);

}  // namespace knead
