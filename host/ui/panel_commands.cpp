#include "host/ui/panel_commands.h"

namespace knead {

SetHands hands_command(const HandSettings& to)
{
    return {{to.present[left], to.held[left]}, {to.present[right], to.held[right]}, to.zoom, to.at};
}

Vec3<double> usual_gravity(const LiveState& state)
{
    const Vec3<double> own = state.scene ? state.scene->scene.setup.gravity : Vec3<double>{};
    return length(own) > 0 ? own : Vec3<double>{0, -9.81, 0};
}

}  // namespace knead
