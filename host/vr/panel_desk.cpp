#include "host/vr/panel_desk.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/scene/presets.h"
#include "host/scene/soften.h"
#include "host/ui/scene_list.h"

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

int surface_of(const LiveState& state)  // nodes along its longest side
{
    const Int3 size = state.surface.lattice.size;
    return std::max({size.x, size.y, size.z});
}

std::size_t moved(std::size_t at, int step, std::size_t count)
{
    return (at + count + std::size_t(step < 0 ? count - 1 : 1)) % count;
}

std::size_t place(const std::vector<std::string>& all, const std::string& one)
{
    const auto found = std::find(all.begin(), all.end(), one);
    return found == all.end() ? 0 : std::size_t(found - all.begin());
}

bool has(const char* quantity, const Material<double>& m)
{
    return material_quantity(quantity).used(stated(m));
}
// The same ranges as the sliders of the window.
double slid(const char* quantity, float share)
{
    const SliderRange range = material_quantity(quantity).slider;
    return value_of(share, range.low, range.high);
}
float slider_share(const char* quantity, const Material<double>& m)
{
    const MaterialQuantity& q = material_quantity(quantity);
    return share_of(stated(m).*q.value, q.slider.low, q.slider.high);
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

// After a load or reset, takes materials and gravity of the scene. After a refusal, resets the
// sliders to the state's material.
void PanelDesk::follow(const LiveState& state)
{
    if (state.refused != refused && !state.materials.empty()) material = state.materials[0];
    refused = state.refused;
    if (state.history == history || !state.scene) return;
    history = state.history;
    const Scene& of = state.scene->scene;
    touched = false, gravity = length(of.setup.gravity) > 0;
    preset = of.objects.empty() ? "" : of.objects[0].stated.name;
    if (!of.setup.materials.empty()) material = of.setup.materials[0];
}

void PanelDesk::load(LiveSession& live)
{
    std::vector<std::string> all = settings;
    if (cells > 0) all.push_back("domain.cells=" + std::to_string(cells));
    live.load(scenes[scene], all);
}

void PanelDesk::choose_scene(int step, LiveSession& live)
{
    scene = moved(scene, step, scenes.size());
    cells = 0;
    load(live);
}

void PanelDesk::give(const LiveState& state, LiveSession& live)
{
    touched = true;
    for (std::size_t i = 0; i < state.scene->scene.setup.materials.size(); ++i)
        live.set_material(int(i), material);
}

void PanelDesk::choose_material(int step, const LiveState& state, LiveSession& live)
{
    const std::vector<std::string>& names = preset_names();
    preset = names[moved(place(names, preset), step, names.size())];
    material = knead::preset(preset);
    give(state, live);
}

void PanelDesk::choose_tool(Side side, int step, LiveSession& live, HeadsetHands& hands)
{
    HandsOptions options = hands.options();
    options.held[side] =
        holdable()[moved(place(holdable(), options.held[side]), step, holdable().size())];
    hands.set(options);
    live.set_hands(options);
}

void PanelDesk::apply(const PanelCommand& command, const LiveState& state, LiveSession& live,
                      HeadsetHands& hands)
{
    follow(state);
    switch (command.act) {
        case PanelAct::scene:
            return choose_scene(command.step, live);
        case PanelAct::left_tool:
            return choose_tool(left, command.step, live, hands);
        case PanelAct::right_tool:
            return choose_tool(right, command.step, live, hands);
        case PanelAct::reset:
            return live.reset();
        default:
            break;
    }
    if (!state.scene) return;
    const Setup& setup = state.scene->scene.setup;
    switch (command.act) {
        case PanelAct::material:
            return choose_material(command.step, state, live);
        case PanelAct::stiffness: {
            // Scales both moduli, which keeps Poisson's ratio.
            const double young = stated(material).young;
            if (!has("young", material) || !(young > 0)) return;
            material = softer(material, young / slid("young", command.value));
            return give(state, live);
        }
        case PanelAct::yield:
            if (!has("yield", material)) return;
            material.yield = slid("yield", command.value);
            return give(state, live);
        case PanelAct::cells: {
            // A scene's lattice has some nodes more than the requested cells.
            const int now = cells > 0 ? cells : setup.lattice.size.x / 16 * 16;
            const bool between = cells == 0 && setup.lattice.size.x % 16 != 0;
            const int next = between && command.step < 0 ? now : now + 16 * command.step;
            cells = std::clamp(next, fewest_cells, most_cells);
            return load(live);
        }
        case PanelAct::surface:
            return live.set_surface(
                std::clamp(surface_of(state) + 16 * command.step, fewest_cells, most_surface));
        case PanelAct::gravity:
            gravity = !gravity;
            return live.set_gravity(gravity_of(state));
        default:
            return;
    }
}

Vec3<double> PanelDesk::gravity_of(const LiveState& state)
{
    follow(state);
    if (!gravity || !state.scene) return {0, 0, 0};
    const Vec3<double> own = state.scene->scene.setup.gravity;
    return length(own) > 0 ? own : Vec3<double>{0, -9.81, 0};
}

PanelView PanelDesk::view(const LiveState& state, const HeadsetHands& hands)
{
    follow(state);
    PanelView shown;
    shown.scene = std::filesystem::path(scenes[scene]).stem().string();
    shown.material = preset + (touched ? " (CHANGED)" : "");
    shown.left_tool = hands.options().held[left], shown.right_tool = hands.options().held[right];
    shown.failure = state.failure;
    shown.stiffness = slider_share("young", material);
    shown.yield = has("yield", material) ? slider_share("yield", material) : -1;
    if (state.scene) shown.nodes = state.scene->scene.setup.lattice.size.x;
    shown.surface = surface_of(state);
    shown.gravity = gravity;
    return shown;
}

}  // namespace knead
