// What a live state looks like: from the simulation's words to a live painter's.
#pragma once
#include "host/live/live_session.h"
#include "host/picture/splat_layer.h"
#include "render/eye_painter.h"

namespace knead {

// Floor and stage of a scene.
EyeLook live_look(const Scene& scene);
// The version under which a painter is given the clay of a state: another for another history.
long clay_version(const LiveState& state);
// Where the splats of a state are.
inline SplatMotion splat_motion(const LiveState& state)
{
    return {state.gaussians.get(), state.gaussians_on_device.get()};
}
// Gives a painter the clay of a state, under that version.
void show_clay(EyePainter& painter, const LiveState& state);
// Hands as they are seen at the end of a motion: by their skin, as large as the motion has it, and
// what they hold, in its own size.
std::vector<HandLook> hand_looks(const HandsOptions& options, const Motion& motion,
                                 float opacity = 1);
// Those that touch clay, as the simulation has them.
std::vector<HandLook> hand_looks(const LiveState& state);
// Tracked hands as they are now, wherever the simulation has come to, that are so opaque.
std::vector<HandLook> tracked_looks(const HandFrame& frame, const HandsOptions& options,
                                    float opacity);

}  // namespace knead
