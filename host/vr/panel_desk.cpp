#include "host/vr/panel_desk.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "host/scene/presets.h"
#include "host/ui/panel_commands.h"
#include "host/ui/scene_list.h"
#include "host/ui/session_line.h"

namespace knead {
namespace {
// "" is the bare hand.
const std::vector<std::string>& holdable()
{
    static const std::vector<std::string> all = [] {
        std::vector<std::string> names = tool_names();
        names.insert(names.begin(), "");
        return names;
    }();
    return all;
}
constexpr int fewest_cells = 16, most_cells = 128, most_surface = 256;

std::size_t moved(std::size_t at, int step, std::size_t count)
{
    return (at + count + std::size_t(step < 0 ? count - 1 : 1)) % count;
}

std::size_t place(const std::vector<std::string>& all, const std::string& one)
{
    const auto found = std::find(all.begin(), all.end(), one);
    return found == all.end() ? 0 : std::size_t(found - all.begin());
}

// The same ranges as the sliders of the window.
double slid(const char* quantity, float share)
{
    const SliderRange range = material_quantity(quantity).slider;
    return value_of(share, range.low, range.high);
}
// Negative: the material has no such quantity.
float slider_share(const char* quantity, const MaterialSpec& m)
{
    const MaterialQuantity& q = material_quantity(quantity);
    return q.used(m) ? share_of(m.*q.value, q.slider.low, q.slider.high) : -1;
}

// The panel has one material for all objects: that of the first, as far as they differ.
const SceneObject* first_object(const LiveState& state)
{
    if (!state.document || state.document->objects.empty()) return nullptr;
    return state.document->objects.front().get();
}

// Whether an object has another material than when the scene was opened.
bool changed(const SceneObject& object, const Scene& opened)
{
    const std::size_t number = std::size_t(object.id.value) - 1;
    return number >= opened.objects.size() ||
           !equal(object.material, scene_object(opened.objects[number], object.id).material);
}

// The first object's material after a press; nothing: it stays.
std::optional<MaterialSpec> pressed_material(const PanelCommand& command, MaterialSpec now)
{
    const auto set = [&](const char* quantity) -> std::optional<MaterialSpec> {
        const MaterialQuantity& q = material_quantity(quantity);
        if (!q.used(now)) return {};
        now.*q.value = slid(quantity, command.value);
        return now;
    };
    if (command.act == PanelAct::stiffness) return set("young");
    if (command.act == PanelAct::yield) return set("yield");
    if (command.act != PanelAct::material) return {};
    const std::vector<std::string>& names = preset_names();
    return material_spec(names[moved(place(names, now.name), command.step, names.size())]);
}

// The commands that a press of a control of the document gives.
std::vector<Command> document_commands(const PanelCommand& command, const LiveState& state)
{
    const SceneSettings& now = *state.document->scene;
    switch (command.act) {
        case PanelAct::material:
        case PanelAct::stiffness:
        case PanelAct::yield: {
            std::vector<Command> all;
            const SceneObject* first = first_object(state);
            if (!first) return {};
            if (const auto to = pressed_material(command, first->material))
                for (const auto& o : state.document->objects)
                    all.push_back(SetMaterial{o->id, *to});
            return all;
        }
        case PanelAct::cells: {
            // A number between two multiples of 16 goes to one of them first.
            const bool between = now.cells % 16 != 0 && command.step < 0;
            const int next = now.cells / 16 * 16 + (between ? 0 : 16 * command.step);
            return {SetLattice{std::clamp(next, fewest_cells, most_cells)}};
        }
        case PanelAct::surface:
            return {SetSurface{
                std::clamp(now.surface_nodes + 16 * command.step, fewest_cells, most_surface)}};
        case PanelAct::gravity:
            return {SetGravity{length(now.gravity) > 0 ? Vec3<double>{} : usual_gravity(state)}};
        default:
            return {};
    }
}

}  // namespace

float share_of(double value, double low, double high)
{
    if (!(value > 0)) return 0;
    return float(clamp(std::log(value / low) / std::log(high / low), 0.0, 1.0));
}
double value_of(float share, double low, double high)
{
    return low * std::pow(high / low, double(clamp(share, 0.f, 1.f)));
}

PanelDesk::PanelDesk(std::string file, std::vector<std::string> with) : settings(std::move(with))
{
    scenes = scenes_beside(file);
    scene = place(scenes, file);
}

void PanelDesk::choose_scene(int step, LiveSession& live)
{
    scene = moved(scene, step, scenes.size());
    live.send(Open{scenes[scene], settings, {}}, Origin::headset);
}

void PanelDesk::choose_tool(Side side, int step, LiveSession& live, HeadsetHands& hands)
{
    HandsOptions options = hands.options();
    options.held[side] =
        holdable()[moved(place(holdable(), options.held[side]), step, holdable().size())];
    hands.set(options);
    SetHands command;
    (side == left ? command.left : command.right).held = options.held[side];
    live.send(std::move(command), Origin::headset);
}

void PanelDesk::apply(const PanelCommand& command, const LiveState& state, LiveSession& live,
                      HeadsetHands& hands)
{
    switch (command.act) {
        case PanelAct::scene:
            return choose_scene(command.step, live);
        case PanelAct::left_tool:
            return choose_tool(left, command.step, live, hands);
        case PanelAct::right_tool:
            return choose_tool(right, command.step, live, hands);
        case PanelAct::reset:
            live.send(Reset{}, Origin::headset);
            return;
        // Sent where they are not available, too: the refusal has the reason.
        case PanelAct::undo:
            live.send(Undo{}, Origin::headset);
            return;
        case PanelAct::redo:
            live.send(Redo{}, Origin::headset);
            return;
        case PanelAct::save:
            live.send(save_command(state), Origin::headset);
            return;
        default:
            break;
    }
    if (!state.document) return;
    for (Command& one : document_commands(command, state))
        live.send(std::move(one), Origin::headset, command.drag);
}

PanelView PanelDesk::view(const LiveState& state, const HeadsetHands& hands) const
{
    PanelView shown;
    shown.scene = std::filesystem::path(scenes[scene]).stem().string();
    shown.left_tool = hands.options().held[left], shown.right_tool = hands.options().held[right];
    shown.failure = state.failure;
    shown.no_undo = why_not(Undo{}, state), shown.no_redo = why_not(Redo{}, state);
    shown.no_save = why_not(Save{}, state);
    if (state.scene) shown.nodes = state.scene->scene.setup.lattice.size.x;
    if (!state.document) return shown;
    if (const SceneObject* first = first_object(state)) {
        const MaterialSpec& material = first->material;
        shown.material = material.name + (changed(*first, state.scene->scene) ? " (CHANGED)" : "");
        shown.stiffness = std::max(0.f, slider_share("young", material));
        shown.yield = slider_share("yield", material);
    }
    shown.surface = state.document->scene->surface_nodes;
    shown.gravity = length(state.document->scene->gravity) > 0;
    return shown;
}

}  // namespace knead
