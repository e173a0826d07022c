#include "host/desktop/view_panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/paths.h"
#include "host/hands/pointer.h"
#include "host/ui/scene_list.h"
#include "host/ui/session_line.h"

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
    const bool anew = state.scene && state.history != history_;
    if (anew) {
        history_ = state.history;
        const bool other = state.scene.get() != scene_;
        scene_ = state.scene.get();
        model.has_recording = state.scene->recording.has_value();
        model.objects.clear();
        if (other) {
            model.notice.clear();
            show_tool(state.scene->scene);
        }
    }
    show_session(state);
    if (refused) model.note(state.refusal);
    if (anew || refused) show_scene(state);
    // Controls may be ahead of the state until all commands are answered.
    const bool other = state.document != shown_ || refused;
    if (state.document && (anew || (other && state.answered >= sent_))) show(state.document);
}

void ViewPanels::show_session(const LiveState& state)
{
    const auto button = [&](const Command& command) -> CommandButton {
        return {row_of(command).label, why_not(command, state)};
    };
    model.undo = button(Undo{}), model.redo = button(Redo{}), model.save = button(Save{});
    model.session = session_line(state);
    std::erase_if(model.recoverable,
                  [&](const RecoverRow& row) { return row.file == state.log.file; });
    if (state.steps == steps_) return;
    steps_ = state.steps;
    model.steps.clear(), model.steps_changed = true;
    if (!steps_) return;
    for (const StepInfo& step : *steps_)
        model.steps.push_back(
            {int(step.id), step.id == 0 ? "Beginning" : step.label, step.current, step.on_line});
}

void ViewPanels::list_recoverable(std::vector<Recoverable> all)
{
    model.recoverable.clear();
    for (const Recoverable& one : all) {
        RecoverRow row{one.file,
                       fs::path(one.scene).stem().string(),
                       fmt::format("{} ago, {} steps", duration_text(one.age), one.steps - 1),
                       {}};
        try {
            if (!one.picture.empty())
                row.picture = std::make_shared<const Image>(decoded_png(one.picture, one.file));
        } catch (const InputError&) {  // the session may be valid without it
        }
        model.recoverable.push_back(std::move(row));
    }
}

// The ranges of sliders stay fixed while all values are within them.
void ViewPanels::show(DocumentPtr document)
{
    shown_ = std::move(document);
    model.gravity = 0.0 - shown_->scene->gravity.y;
    model.objects.resize(shown_->objects.size());
    for (std::size_t i = 0; i < model.objects.size(); ++i) {
        const SceneObject& from = *shown_->objects[i];
        ObjectPanel& to = model.objects[i];
        to.name = from.name, to.preset = preset_index(from.material.name);
        std::vector<Slider> sliders = sliders_of(from.material);
        const bool fixed =
            std::ranges::equal(sliders, to.sliders, [](const Slider& now, const Slider& before) {
                return now.name == before.name && now.logarithmic == before.logarithmic &&
                       now.value >= before.low && now.value <= before.high;
            });
        for (std::size_t k = 0; fixed && k < sliders.size(); ++k)
            sliders[k].low = to.sliders[k].low, sliders[k].high = to.sliders[k].high;
        to.sliders = std::move(sliders);
    }
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

std::string ViewPanels::held() const
{
    return model.tool == 0 ? "" : model.tools[std::size_t(model.tool)];
}

HandsOptions ViewPanels::hands(const LiveState& state) const
{
    HandsOptions options = state.hands;
    options.held[right] = held();
    options.present[right] = true;
    return options;
}

void ViewPanels::send(Command command, LiveSession& session, unsigned drag)
{
    if (shown_) {
        IdSource ids;  // no control adds an object
        const auto next = reduce(shown_, command, ids);
        if (const DocumentPtr* to = std::get_if<DocumentPtr>(&next); to && *to != shown_) show(*to);
    }
    sent_ = std::max(sent_, session.send(std::move(command), Origin::window, drag));
}

void ViewPanels::load(int scene, LiveSession& session)
{
    const std::optional<int> cells = cells_ > 0 ? std::optional(cells_) : std::nullopt;
    send(Open{paths.at(std::size_t(scene)), settings_, cells}, session);
}

void ViewPanels::recover(const std::string& file, LiveSession& session)
{
    send(Open{file, {}, {}}, session);
}

void ViewPanels::discard_log(const std::string& file)
{
    try {
        delete_log(file);
        std::erase_if(model.recoverable, [&](const RecoverRow& row) { return row.file == file; });
    } catch (const OutputError& e) {
        model.note(e.what());
    }
}

void ViewPanels::send_tool(LiveSession& session)
{
    SetHands command;
    command.right = {true, held()};
    send(std::move(command), session);
}

SetMaterial ViewPanels::chosen_material(bool preset)
{
    const std::size_t at = std::size_t(model.object);
    ObjectPanel& object = model.objects.at(at);
    const SceneObject& now = *shown_->objects.at(at);
    if (!preset) return {now.id, with_sliders(now.material, object.sliders)};
    object.sliders.clear();  // their ranges are those of another material
    return {now.id, material_specs().at(std::size_t(object.preset))};
}

void ViewPanels::apply(const PanelRequests& requests, LiveSession& session)
{
    // Before send() sets the controls.
    std::optional<SetMaterial> material;
    if ((requests.preset || requests.material) && shown_)
        material = chosen_material(requests.preset);
    if (requests.undo) send(Undo{}, session);
    if (requests.redo) send(Redo{}, session);
    if (requests.go_to) send(GoTo{*requests.go_to}, session);
    if (requests.save) send(save_command(*session.state()), session);
    if (requests.hide_recoverable) model.recoverable.clear();
    if (requests.recorded) send(Play{*requests.recorded}, session);
    if (requests.gravity) send(SetGravity{{0, 0.0 - *requests.gravity, 0}}, session, requests.drag);
    if (requests.tool) {
        model.tool = *requests.tool;
        model.posture = int(model.tool == 0 ? Posture::relaxed : Posture::fist);
        send_tool(session);
    }
    if (material) send(*material, session, requests.preset ? 0 : requests.drag);
}

}  // namespace knead
