#include "host/session/headset_hands.h"

#include <algorithm>

#include "cuda/contact/medial.h"
#include "host/scene/seed.h"
#include "host/session/live_look.h"

namespace knead {
namespace {

// Whether clay is at the tool, within so far [m] of it. Where no surface was made nobody can tell,
// and of one that is on a device only the box about it is known.
bool at_clay(const LiveTool& tool, const LiveState& state, float within)
{
    const Meshes& clay = state.meshes;
    const DeviceMesh* const away = clay ? nullptr : state.on_device.get();
    if (!(clay || away) || tool.primitives.empty()) return true;
    Vec3<float> low{1e30f, 1e30f, 1e30f}, high = -low;
    std::vector<Shape<float>> shapes;
    for (const DrawPrimitive& p : tool.primitives) {
        const Sphere<float>* s = p.sphere;
        for (int i = 0; i < p.count; ++i) {
            const Vec3<float> c = s[i].c;
            const float far = s[i].r + within;
            low = {min(low.x, c.x - far), min(low.y, c.y - far), min(low.z, c.z - far)};
            high = {max(high.x, c.x + far), max(high.y, c.y + far), max(high.z, c.z + far)};
        }
        const int last = p.count - 1;
        shapes.push_back(shape(p.count, s[0], s[std::min(1, last)], s[std::min(2, last)]));
    }
    if (away) {
        const Vec3<float> a = away->low(), b = away->high();
        return !away->empty() && low.x <= b.x && low.y <= b.y && low.z <= b.z && high.x >= a.x &&
               high.y >= a.y && high.z >= a.z;
    }
    for (const Mesh& mesh : *clay)
        for (const Vec3<float>& x : mesh.vertices) {
            if (x.x < low.x || x.y < low.y || x.z < low.z) continue;
            if (x.x > high.x || x.y > high.y || x.z > high.z) continue;
            for (const Shape<float>& s : shapes)
                if (closest_point(s, x).phi < within) return true;
        }
    return false;
}

bool has_blade(const LiveTool& tool) { return tool.held == "knife" || tool.held == "scissors"; }

}  // namespace

float HandFade::frame(double time, bool tracked, float size)
{
    const float step = float(std::max(0.0, time - last) / fading);
    last = time;
    const float wanted = tracked ? faint + (1 - faint) * size : 0;
    opacity =
        wanted > opacity ? std::min(wanted, opacity + step) : std::max(wanted, opacity - step);
    return opacity;
}

HandFrame hand_frame(const Sight& sight, const Workplace& workplace, double time)
{
    HandFrame frame;
    frame.time = time;
    for (int side = 0; side < side_count; ++side)
        frame.hand[side] = in_hands(workplace, sight.hands[std::size_t(side)].hand);
    return frame;
}

void HeadsetHands::set(const HandsRule& rule)
{
    hand_tools(rule);  // refuses a tool that is not known
    by = rule;
    HandsRule unplaced = rule;
    unplaced.zoom = 1, unplaced.at = {0, 0, 0};
    stream.emplace(unplaced);
}

void HeadsetHands::set_zoom(double zoom) { by.zoom = zoom; }

void HeadsetHands::push(const HandFrame& frame)
{
    newest = frame;
    stream->push(frame);
    stream->forget(frame.time - 1);
}

std::vector<HandLook> HeadsetHands::looks()
{
    std::vector<HandLook> all;
    if (stream->empty()) return all;
    std::vector<Joint<double>> joints(std::size_t(int(side_count) * joint_count));
    float size[side_count];
    stream->sample(newest.time, joints.data(), size);
    for (Joint<double>& joint : joints) joint.p = by.at + by.zoom * joint.p;
    float opacity[side_count];
    for (int side = 0; side < side_count; ++side)
        opacity[side] = fade[side].frame(newest.time, newest.hand[side].tracked, size[side]);
    const std::vector<Side> sides = tool_sides(by);
    for (std::size_t tool = 0; tool < sides.size(); ++tool) {
        const Side side = sides[tool];
        if (opacity[side] <= 0) continue;
        std::vector<char> alone(sides.size(), 0);
        alone[tool] = 1;
        for (HandLook& look : hand_looks(by, joints, alone, opacity[side]))
            all.push_back(std::move(look));
    }
    return all;
}

void HeadsetHands::feel(const LiveState& state, Feel felt[side_count])
{
    std::fill(felt, felt + int(side_count), Feel::nothing);
    if (state.version == felt_version) return;
    felt_version = state.version;
    const FrameStats& stats = state.frame.stats;
    // The surface is where half of the clay's density is: about a node of it away from the clay.
    const float within = 1.5f * state.surface.lattice.dx;
    bool now[side_count] = {false, false}, blade[side_count] = {false, false};
    for (const LiveTool& tool : state.tools) {
        if (stats.projected == 0 || !tool.active || !at_clay(tool, state, within)) continue;
        now[tool.side] = true, blade[tool.side] = has_blade(tool);
    }
    for (int side = 0; side < side_count; ++side) {
        const Feel steady = stats.yielded == 0 ? Feel::nothing
                            : blade[side]      ? Feel::cutting
                                               : Feel::yielding;
        if (now[side]) felt[side] = touched[side] ? steady : Feel::contact;
        touched[side] = now[side];
    }
}

float strength_of(Feel feel)
{
    switch (feel) {
        case Feel::nothing:
            return 0;
        case Feel::contact:
            return 0.5f;
        case Feel::yielding:
            return 0.15f;
        case Feel::cutting:
            return 0.35f;
    }
    return 0;
}

}  // namespace knead
