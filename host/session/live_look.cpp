#include "host/session/live_look.h"

#include "host/scene/seed.h"
#include "host/session/frame_writer.h"
#include "host/session/motion.h"
#include "render/hand_skin.h"

namespace knead {
namespace {

// A bare hand by its skin, a thing by its primitives.
HandLook look_of(const HandsRule& rule, Side side, const std::vector<Joint<double>>& joints,
                 std::vector<DrawPrimitive> primitives, float opacity)
{
    if (!rule.held[side].empty()) return {std::move(primitives), {}, opacity, false};
    return {{}, {hand_skin(rule.topology, side).posed(joints, rule.zoom)}, opacity, true};
}

}  // namespace

EyeLook live_look(const Scene& scene)
{
    const WallRule& walls = scene.setup.walls;
    EyeLook look;
    look.floor = float(walls.min.y);
    look.stage = {cast<float>(0.5 * (walls.min + walls.max)),
                  float(length(walls.max - walls.min) / 2)};
    return look;
}

long clay_version(const LiveState& state)
{
    return (long(state.history) << 40) + state.mesh_version;
}

std::vector<HandLook> hand_looks(const LiveState& state)
{
    std::vector<HandLook> looks;
    for (const LiveTool& tool : state.tools)
        if (tool.active)
            looks.push_back(
                look_of(state.hands, tool.side, state.frame.motion.to, tool.primitives, 1));
    return looks;
}

std::vector<HandLook> tracked_looks(const HandFrame& frame, const HandsRule& rule, float opacity)
{
    std::vector<Joint<double>> joints = no_motion().to;
    for (int side : {left, right})
        for (int j = 0; j < joint_count; ++j) {
            const Joint<float>& joint = frame.hand[side].joints[std::size_t(j)];
            joints[std::size_t(side * joint_count + j)] = {
                unit(cast<double>(joint.q)), rule.at + rule.zoom * cast<double>(joint.p)};
        }
    const HandTools tools = hand_tools(rule);
    const std::vector<Side> sides = tool_sides(rule);
    std::vector<HandLook> looks;
    for (std::size_t tool = 0; tool < sides.size(); ++tool)
        if (frame.hand[sides[tool]].tracked)
            looks.push_back(look_of(rule, sides[tool], joints,
                                    draw_primitives(tools.rig, joints, int(tool)), opacity));
    return looks;
}

}  // namespace knead
