#include "host/cli/view_panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "host/base/paths.h"
#include "host/hands/pointer.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

struct Quantity {
    const char *name, *unit;
    double MaterialSpec::*value;
    double low, high;
    bool logarithmic;
    bool (*used)(const MaterialSpec&);
};

bool always(const MaterialSpec&) { return true; }
bool solid(const MaterialSpec& s) { return s.plasticity != Plasticity::fluid; }
bool yields(const MaterialSpec& s)
{
    return s.plasticity == Plasticity::von_mises || s.plasticity == Plasticity::herschel_bulkley;
}
bool flows(const MaterialSpec& s)
{
    return s.plasticity == Plasticity::fluid || s.plasticity == Plasticity::herschel_bulkley;
}
bool grains(const MaterialSpec& s) { return s.plasticity == Plasticity::drucker_prager; }

const Quantity quantities[] = {
    {"Density", "kg/m3", &MaterialSpec::density, 100, 5000, false, always},
    {"Stiffness", "Pa", &MaterialSpec::young, 1e3, 1e7, true, solid},
    {"Poisson", "", &MaterialSpec::poisson, 0, 0.45, false, solid},
    {"Yield", "Pa", &MaterialSpec::yield, 100, 1e6, true, yields},
    {"Hardening", "Pa", &MaterialSpec::hardening, 0, 1e6, false,
     [](const MaterialSpec& s) { return s.plasticity == Plasticity::von_mises; }},
    {"Viscosity", "Pa s", &MaterialSpec::viscosity, 0.1, 1e4, true, flows},
    {"Friction", "deg", &MaterialSpec::friction_angle, 1, 60, false, grains},
    {"Cohesion", "Pa", &MaterialSpec::cohesion, 0, 1e4, false, grains}};

int preset_index(const std::string& name)
{
    const auto& all = material_specs();
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const auto& spec) { return spec.name == name; });
    return at == all.end() ? 0 : int(at - all.begin());
}

std::string path_key(const std::string& path)
{
    std::error_code problem;
    const fs::path whole = fs::weakly_canonical(path, problem);
    return problem ? path : whole.string();
}

}  // namespace

MaterialSpec stated(const Object& object)
{
    MaterialSpec spec = material_specs()[std::size_t(preset_index(object.preset))];
    const Material<double>& m = object.material;
    spec.elasticity = m.elasticity, spec.plasticity = m.plasticity;
    spec.density = m.density;
    if (solid(spec) && m.lambda + m.mu > 0) {
        spec.young = m.mu * (3 * m.lambda + 2 * m.mu) / (m.lambda + m.mu);
        spec.poisson = m.lambda / (2 * (m.lambda + m.mu));
    }
    if (yields(spec)) spec.yield = m.yield, spec.hardening = m.hardening;
    if (flows(spec)) spec.viscosity = m.viscosity, spec.exponent = m.exponent;
    if (spec.plasticity == Plasticity::fluid) spec.bulk = m.bulk;
    spec.yield_floor = m.yield_floor;
    return spec;
}

std::vector<Slider> sliders_of(const MaterialSpec& spec)
{
    std::vector<Slider> sliders;
    for (const Quantity& q : quantities)
        if (q.used(spec)) {
            const double value = spec.*q.value;
            sliders.push_back({q.name, q.unit, value, std::min(q.low, value),
                               std::max(q.high, value), q.logarithmic && value > 0});
        }
    return sliders;
}

MaterialSpec with_sliders(MaterialSpec spec, const std::vector<Slider>& sliders)
{
    for (const Slider& s : sliders) {
        const auto q = std::find_if(std::begin(quantities), std::end(quantities),
                                    [&](const Quantity& one) { return s.name == one.name; });
        if (q == std::end(quantities) || !q->used(spec))
            throw std::invalid_argument("a material has no " + s.name);
        spec.*(q->value) = s.value;
    }
    return spec;
}

std::vector<std::string> scenes_beside(const std::string& path)
{
    std::vector<std::string> found{path};
    std::error_code problem;
    const fs::path folder = fs::path(path).parent_path();
    for (fs::directory_iterator at(folder.empty() ? "." : folder, problem), end;
         !problem && at != end; at.increment(problem)) {
        const std::string one = at->path().lexically_normal().string();
        if (ending(one) == ".json" && path_key(one) != path_key(path)) found.push_back(one);
    }
    std::sort(found.begin(), found.end());
    return found;
}

ViewPanels::ViewPanels(const std::string& path) : paths(scenes_beside(path))
{
    for (const std::string& one : paths) model.scenes.push_back(fs::path(one).stem().string());
    for (const MaterialSpec& spec : material_specs()) model.presets.push_back(spec.name);
    model.tools = {"bare hand", "slab", "rod", "cone", "ball", "knife", "scissors"};
}

void ViewPanels::follow(const LiveState& state)
{
    model.paused = state.paused;
    model.recorded = state.recorded;
    model.trouble = state.trouble;
    if (state.refused != refused_ && !state.refusal.empty()) model.note(state.refusal);
    refused_ = state.refused;
    if (!state.scene || state.history == history_) return;
    history_ = state.history;
    const bool other = state.scene.get() != scene_;
    scene_ = state.scene.get();
    const Scene& scene = state.scene->scene;
    model.gravity = -scene.setup.gravity.y;
    model.objects.clear(), specs_.clear();
    for (const Object& o : scene.objects) {
        specs_.push_back(stated(o));
        model.objects.push_back({o.name, preset_index(o.preset), sliders_of(specs_.back())});
    }
    model.has_recording = state.scene->recording.has_value();
    if (!other) return;
    model.notice.clear();
    model.object = 0;
    model.tool = 0;
    for (std::size_t i = 0; i < model.tools.size(); ++i)
        if (model.tools[i] == scene.hands.held[right])
            model.tool = int(i), model.posture = int(Posture::fist);
    for (std::size_t i = 0; i < paths.size(); ++i)
        if (path_key(paths[i]) == path_key(scene.path)) model.scene = int(i);
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

HandsRule ViewPanels::hands(const LiveState& state) const
{
    HandsRule rule = state.hands;
    rule.held[right] = model.tool == 0 ? "" : model.tools[std::size_t(model.tool)];
    rule.present[right] = true;
    return rule;
}

void ViewPanels::obey(const PanelAsks& asks, LiveSession& session, const LiveState& state)
{
    if (asks.load) session.load(paths.at(std::size_t(*asks.load)), {});
    if (asks.reset) session.reset();
    if (asks.pause) session.pause(*asks.pause);
    if (asks.step) session.step();
    if (asks.recorded) session.play(*asks.recorded);
    if (asks.gravity) session.set_gravity({0, -*asks.gravity, 0});
    if (asks.tool) {
        model.tool = *asks.tool;
        model.posture = int(model.tool == 0 ? Posture::relaxed : Posture::fist);
        session.set_hands(hands(state));
    }
    if (!asks.preset && !asks.material) return;
    const std::size_t at = std::size_t(model.object);
    ObjectPanel& object = model.objects.at(at);
    MaterialSpec& spec = specs_.at(at);
    if (asks.preset)
        spec = material_specs().at(std::size_t(object.preset)), object.sliders = sliders_of(spec);
    else
        spec = with_sliders(spec, object.sliders);
    session.set_material(int(at), made(spec));
}

}  // namespace knead
