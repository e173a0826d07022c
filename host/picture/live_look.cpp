#include "host/picture/live_look.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "host/hands/motion.h"
#include "host/hands/rig.h"
#include "host/scene/seed.h"
#include "render/hand_skin.h"
#include "render/tool_primitives.h"

namespace knead {
namespace {

Rig zoomed(Rig rig, double zoom)
{
    for (Binding<float>& b : rig.spheres) b = stretched(b, {float(zoom), float(zoom)});
    return rig;
}

}  // namespace

std::vector<HandLook> hand_looks(const HandsOptions& options, const Motion& motion, float opacity)
{
    std::vector<HandLook> looks;
    const std::vector<Side> sides = tool_sides(options);
    for (std::size_t tool = 0; tool < sides.size(); ++tool) {
        if (motion.to.empty() || (tool < motion.active.size() && !motion.active[tool])) continue;
        const Side side = sides[tool];
        const Mesh skin = hand_skin(options.topology, side)
                              .posed(motion.to, options.zoom, motion.stretch_of(tool));
        looks.push_back({{}, {skin}, opacity, true});
        const std::string& held = options.held[side];
        if (held.empty()) continue;
        Motion own_size;
        own_size.to = motion.to;
        const auto add = [&](const Rig& rig, bool metal) {
            looks.push_back({draw_primitives(zoomed(rig, options.zoom), own_size, 0),
                             {},
                             opacity,
                             false,
                             metal});
        };
        add(tool_rig(held, side), held == "knife" || held == "scissors");
        add(tool_handle(held, side), false);
    }
    return looks;
}

EyeLook live_look(const Scene& scene)
{
    const WallOptions& walls = scene.setup.walls;
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

bool splats_hidden(const LiveState& state)
{
    if (!state.document || !state.splats) return false;
    const auto shown = [](const std::shared_ptr<const SceneObject>& o) {
        return o->source.shape == ShapeKind::splats && !o->hidden;
    };
    return std::ranges::none_of(state.document->objects, shown);
}

namespace {

// sRGB to linear RGB.
Vec3<float> linear(Vec3<double> c)
{
    const auto one = [](double x) {
        return float(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
    };
    return {one(c.x), one(c.y), one(c.z)};
}

}  // namespace

ClayColours clay_colours(const Document& document, const std::vector<Mesh>* meshes,
                         const ObjectPlaces* places)
{
    ClayColours colours;
    if (std::ranges::none_of(document.objects, [](const auto& o) { return o->colour.has_value(); }))
        return colours;
    std::uint64_t hash = 14695981039346656037u;  // FNV-1a
    const auto add = [&](std::uint64_t number) { hash = (hash ^ number) * 1099511628211u; };
    std::map<int, const SceneObject*> first;
    std::map<int, bool> differ;
    for (const auto& o : document.objects) {
        const SceneObject* const other = first.try_emplace(o->category, o.get()).first->second;
        if (o->colour.has_value() != other->colour.has_value() ||
            (o->colour && !equal(*o->colour, *other->colour)))
            differ[o->category] = true;
        add(o->id.value), add(std::uint64_t(o->category));
        if (o->colour)
            for (const double x : {o->colour->x, o->colour->y, o->colour->z})
                add(std::bit_cast<std::uint64_t>(x));
    }
    for (const auto& [category, object] : first)
        if (object->colour && !differ.contains(category))
            colours.of_category[category] = linear(*object->colour);
    if (places && meshes && !differ.empty()) {
        add(std::uint64_t(places->history)), add(std::uint64_t(places->frame));
        add(std::uint64_t(places->edits));
        for (const Mesh& mesh : *meshes) {
            std::vector<Vec3<float>>& of = colours.of_vertices.emplace_back();
            if (!differ.contains(mesh.category)) continue;
            const Vec3<float> usual = category_colour(mesh.category);
            for (const ObjectId id : objects_of(mesh, document, *places)) {
                const SceneObject* const o = document.find(id);
                of.push_back(o && o->colour ? linear(*o->colour) : usual);
            }
        }
    }
    colours.version = long(hash >> 1) | 1;
    return colours;
}

ClayColours clay_colours(const LiveState& state, const ObjectPlaces* places)
{
    if (!state.document) return {};
    return clay_colours(*state.document, state.meshes.get(), places);
}

void show_clay(EyePainter& painter, const LiveState& state, const ClayColours* colours)
{
    static const std::vector<Mesh> nothing;
    const std::vector<int> unseen =
        state.document ? splat_categories(*state.document) : std::vector<int>();
    const std::vector<int> hidden =
        state.document ? state.document->hidden_categories() : std::vector<int>();
    const long version = clay_version(state);
    const ClayColours usual = colours ? ClayColours{} : clay_colours(state, nullptr);
    if (!colours) colours = &usual;
    if (state.on_device)
        painter.set_device_clay(*state.on_device, version, unseen, hidden, *colours);
    else
        painter.set_clay(state.meshes ? *state.meshes : nothing, version, unseen, hidden, *colours);
}

std::vector<HandLook> hand_looks(const LiveState& state)
{
    Motion motion = state.frame.motion;
    motion.active.clear();
    for (const LiveTool& tool : state.tools) motion.active.push_back(tool.active);
    motion.active.resize(tool_sides(state.hands).size(), false);
    return hand_looks(state.hands, motion);
}

std::vector<HandLook> tracked_looks(const HandFrame& frame, const HandsOptions& options,
                                    float opacity)
{
    Motion motion = no_motion();
    for (int side : {left, right})
        for (int j = 0; j < joint_count; ++j) {
            const Joint<float>& joint = frame.hand[side].joints[std::size_t(j)];
            motion.to[std::size_t(side * joint_count + j)] = {
                unit(cast<double>(joint.q)), options.at + options.zoom * cast<double>(joint.p)};
        }
    for (const Side side : tool_sides(options)) motion.active.push_back(frame.hand[side].tracked);
    return hand_looks(options, motion, opacity);
}

}  // namespace knead
