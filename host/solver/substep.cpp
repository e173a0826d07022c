#include "host/solver/substep.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace knead {

const char* const limit_names[int(Limit::count)] = {"sound",     "speed", "tool",
                                                    "viscosity", "fixed", "frame end"};

static void check_motion(const SimulationConfig& setup, const Motion& motion)
{
    const auto wanted = std::size_t(joints_of(setup.rig));
    const std::size_t found = std::min(motion.from.size(), motion.to.size());
    if (found < wanted)
        throw std::invalid_argument("a motion needs " + std::to_string(wanted) +
                                    " joints at both ends of the frame, not " +
                                    std::to_string(found));
    for (const Stretch<float>& s : motion.stretch)
        if (!(s.across > 0 && s.along > 0 && std::isfinite(s.across) && std::isfinite(s.along)))
            throw std::invalid_argument("the stretch of a tool must be positive");
}

double tool_step(const SimulationConfig& setup, const Motion& motion, double duration)
{
    check_motion(setup, motion);
    double dt = 1e30;
    const double dx = setup.lattice.dx;
    std::vector<int> seen(setup.rig.spheres.size(), -1);  // per sphere, the last tool visited:
                                                          // primitives share spheres
    for (const Primitive& p : setup.rig.primitives) {
        const auto tool = std::size_t(p.tool);
        if (tool < motion.active.size() && !motion.active[tool]) continue;
        for (int k = 0; k < p.count; ++k) {
            const auto sphere = std::size_t(p.sphere[k]);
            if (std::exchange(seen[sphere], p.tool) == p.tool) continue;
            const auto b = stretched(cast<double>(setup.rig.spheres[sphere]),
                                     cast<double>(motion.stretch_of(tool)));
            const auto at = [](const std::vector<Joint<double>>& joints) {
                return [&joints](int j) { return joints[std::size_t(j)]; };
            };
            const double way = length(centre(b, at(motion.to)) - centre(b, at(motion.from)));
            const double room = setup.tools[tool].blade ? dx : std::min(b.radius, dx);
            if (way > 0) dt = std::min(dt, setup.step.tool * room / way * duration);
        }
    }
    return dt;
}

}  // namespace knead
