#include "host/desktop/view_panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "host/base/paths.h"
#include "host/hands/pointer.h"
#include "host/ui/scene_list.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

int preset_index(const std::string& name)
{
    const auto& all = material_specs();
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const auto& spec) { return spec.name == name; });
    return at == all.end() ? 0 : int(at - all.begin());
}

}  // namespace

std::vector<Slider> sliders_of(const MaterialSpec& spec)
{
    std::vector<Slider> sliders;
    for (const MaterialQuantity& q : material_quantities()) {
        if (!q.used(spec) || q.slider.high <= q.slider.low) continue;
        const double value = spec.*q.value;
        sliders.push_back({q.name, q.unit, value, std::min(q.slider.low, value),
                           std::max(q.slider.high, value), q.slider.logarithmic && value > 0});
    }
    return sliders;
}

MaterialSpec with_sliders(MaterialSpec spec, const std::vector<Slider>& sliders)
{
    const auto all = material_quantities();
    for (const Slider& s : sliders) {
        const auto q = std::find_if(all.begin(), all.end(), [&](const MaterialQuantity& one) {
            return s.name == one.name;
        });
        if (q == all.end() || !q->used(spec))
            throw std::invalid_argument("a material has no " + s.name);
        spec.*(q->value) = s.value;
    }
    return spec;
}

ViewPanels::ViewPanels(const std::string& path, std::vector<std::string> settings, int cells)
    : paths(scenes_beside(path)), settings_(std::move(settings)), cells_(cells)
{
    for (const std::string& one : paths) model.scenes.push_back(fs::path(one).stem().string());
    for (const MaterialSpec& spec : material_specs()) model.presets.push_back(spec.name);
    model.tools = tool_names();
    model.tools.insert(model.tools.begin(), "bare hand");
}

void ViewPanels::follow(const LiveState& state)
{
    model.paused = state.paused;
    model.recorded = state.recorded;
    model.failure = state.failure;
    const bool refused = state.refused != refused_ && !state.refusal.empty();
    refused_ = state.refused;
    if (!state.scene || state.history == history_) {
        if (!refused) return;
        model.note(state.refusal);
        show_held(state);
        return show_scene(state);
    }
    history_ = state.history;
    const bool other = state.scene.get() != scene_;
    scene_ = state.scene.get();
    const Scene& scene = state.scene->scene;
    model.gravity = gravity_ = -scene.setup.gravity.y;
    model.objects.clear(), specs_.clear(), presets_.clear();
    for (const Object& o : scene.objects) {
        specs_.push_back(o.stated);
        presets_.push_back(preset_index(o.stated.name));
        model.objects.push_back({o.name, presets_.back(), sliders_of(o.stated)});
    }
    model.has_recording = state.scene->recording.has_value();
    if (other) {
        model.notice.clear();
        show_tool(scene);
    }
    show_scene(state);
    if (refused) model.note(state.refusal);  // settings that are invalid for this scene
}

void ViewPanels::show_tool(const Scene& scene)
{
    model.object = 0;
    model.tool = 0;
    for (std::size_t i = 0; i < model.tools.size(); ++i)
        if (model.tools[i] == scene.hands.held[right])
            model.tool = int(i), model.posture = int(Posture::fist);
}

void ViewPanels::show_scene(const LiveState& state)
{
    if (!state.scene) return;
    const std::string key = path_key(state.scene->scene.path);
    for (std::size_t i = 0; i < paths.size(); ++i)
        if (path_key(paths[i]) == key) model.scene = int(i);
}

// After a refusal: resets the materials to those of the simulation.
void ViewPanels::show_held(const LiveState& state)
{
    for (std::size_t i = 0; i < model.objects.size() && i < state.materials.size(); ++i) {
        specs_[i] = stated(state.materials[i]);
        model.objects[i].preset = presets_[i];
        model.objects[i].sliders = sliders_of(specs_[i]);
    }
}

void ViewPanels::add_times(const LiveState& state, double raster, double gl, double show)
{
    TimeGraph::Stages stages;
    if (state.version != timed_ && state.frame.number > 0) {
        for (const StageTime& stage : state.stages) stages.push_back({stage.name, stage.seconds});
        if (state.stages.empty()) stages.push_back({"solver", state.frame.times.solver});
        stages.push_back({"surface", state.frame.times.surface});
    }
    timed_ = state.version;
    if (raster > 0) stages.push_back({"splats", raster});
    stages.push_back({"picture", gl});
    stages.push_back({"show", show});
    model.graph.add(stages);
}

HandsOptions ViewPanels::hands(const LiveState& state) const
{
    HandsOptions options = state.hands;
    options.held[right] = model.tool == 0 ? "" : model.tools[std::size_t(model.tool)];
    options.present[right] = true;
    return options;
}

void ViewPanels::load(int scene, LiveSession& session)
{
    session.load(paths.at(std::size_t(scene)), settings_, cells_);
}

bool ViewPanels::set_gravity(double gravity, LiveSession& session)
{
    if (!(std::abs(gravity) <= most_gravity)) {
        model.note(
            fmt::format("Gravity: expected {:g} m/s^2 at most, found {:g}", most_gravity, gravity));
        model.gravity = gravity_;
        return false;
    }
    gravity_ = gravity;
    session.set_gravity({0, -gravity, 0});
    return true;
}

bool ViewPanels::set_material(bool preset, LiveSession& session)
{
    const std::size_t at = std::size_t(model.object);
    if (at >= model.objects.size()) return false;  // a scene without objects
    ObjectPanel& object = model.objects[at];
    MaterialSpec spec = preset ? material_specs().at(std::size_t(object.preset))
                               : with_sliders(specs_.at(at), object.sliders);
    if (const auto fault = fault_of(spec)) {
        const MaterialQuantity* of = nullptr;
        for (const MaterialQuantity& q : material_quantities())
            if (q.key == fault->key) of = &q;
        model.note(fmt::format("{}: expected {}, found {}", of ? of->name : fault->key,
                               fault->expected, fault->found));
        object.sliders = sliders_of(specs_.at(at));
        return false;
    }
    // Ranges stay fixed while a slider is dragged.
    bool within = !preset;
    for (const Slider& s : object.sliders) within = within && s.value >= s.low && s.value <= s.high;
    if (!within) object.sliders = sliders_of(spec);
    if (!preset) presets_.at(at) = object.preset;
    specs_.at(at) = spec;
    session.set_material(int(at), made(spec));
    return true;
}

bool ViewPanels::apply(const PanelRequests& requests, LiveSession& session, const LiveState& state)
{
    bool other = false;
    if (requests.recorded) session.play(*requests.recorded);
    if (requests.gravity) other = set_gravity(*requests.gravity, session);
    if (requests.tool) {
        model.tool = *requests.tool;
        model.posture = int(model.tool == 0 ? Posture::relaxed : Posture::fist);
        session.set_hands(hands(state));
    }
    if (requests.preset || requests.material)
        other = set_material(requests.preset, session) || other;
    return other;
}

}  // namespace knead
