#include "host/ui/panel_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/document/command_table.h"
#include "host/document/export_plan.h"
#include "host/scene/new_scene.h"
#include "host/scene/presets.h"
#include "host/ui/arrange.h"
#include "host/ui/material_feel.h"
#include "host/ui/panel_commands.h"
#include "host/ui/session_line.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

// Choices of the panel; the first leaves it to the command.
template <class T>
std::vector<std::string> with_automatic(const Names<T>& names)
{
    std::vector<std::string> all{"automatic"};
    for (const auto& [name, value] : names) all.push_back(name);
    return all;
}

constexpr const char* finger_names[] = {"Thumb", "Index", "Middle", "Ring", "Little"};

// An outline has points, which no control gives.
std::vector<std::string> section_names()
{
    std::vector<std::string> names;
    for (const SectionKind kind : nozzle_sections)
        for (const auto& [name, section] : section_kinds)
            if (section == kind) names.push_back(name);
    return names;
}

const SceneObject* chosen_object(const UiState& ui)
{
    return ui.document ? ui.document->find(ui.chosen) : nullptr;
}

bool is_chosen(const UiState& ui, ObjectId id)
{
    return id == ui.chosen || std::ranges::count(ui.also_chosen, id) > 0;
}

int place_of(const std::vector<std::string>& all, const std::string& one)
{
    const auto at = std::find(all.begin(), all.end(), one);
    return at == all.end() ? -1 : int(at - all.begin());
}

// Builds the sections: each control that is shown in this place is added to the section of its row.
class Builder {
  public:
    Builder(const LiveState& of, const UiState& by, PanelModel& to) : state(of), ui(by), model(to)
    {
    }

    // Null: it is not shown here.
    ControlState* add(Control control, ControlValue value = {}, int index = 0)
    {
        const ControlRow& row = row_of(control);
        if (!(row.shown & ui.place)) return nullptr;
        auto at = std::find_if(model.sections.begin(), model.sections.end(),
                               [&](const PanelSection& s) { return s.part == row.part; });
        if (at == model.sections.end()) {
            at = model.sections.insert(at, PanelSection{row.part, {}});
            at->controls.reserve(32);
        }
        ControlState& one = at->controls.emplace_back();
        one.id = {control, index}, one.label = row.label, one.value = std::move(value);
        return &one;
    }
    void number(Control control, double value, SliderRange range, const char* unit, int index = 0,
                const char* label = nullptr)
    {
        ControlState* const one = add(control, value, index);
        if (!one) return;
        if (label) one->label = label;
        one->unit = unit;
        one->low = std::min(range.low, value), one->high = std::max(range.high, value);
        one->logarithmic = range.logarithmic && value > 0;
        one->why_not = reason(control, value, index);
    }
    void whole(Control control, int value, WholeRange range)
    {
        ControlState* const one = add(control, value);
        if (!one) return;
        one->low = std::min(range.low, value), one->high = std::max(range.high, value);
        one->step = range.step;
        one->why_not = reason(control, value);
    }
    void choice(Control control, int value, std::vector<std::string> choices)
    {
        ControlState* const one = add(control, value);
        if (!one) return;
        one->choices = std::move(choices);
        one->why_not = reason(control, value);
    }
    void button(Control control, const std::string& why_not = {}, int index = 0)
    {
        if (ControlState* const one = add(control, {}, index)) one->why_not = why_not;
    }
    void toggle(Control control, bool on)
    {
        if (ControlState* const one = add(control, on)) one->why_not = reason(control, on);
    }

  private:
    // Why the command that this control sends is not available.
    std::string reason(Control control, ControlValue value, int index = 0) const
    {
        for (const Command& one : commands_for(state, ui, {{control, index}, std::move(value), 0}))
            if (std::string why = why_not(one, state); !why.empty()) return why;
        return {};
    }

    const LiveState& state;
    const UiState& ui;
    PanelModel& model;
};

void add_session(Builder& to, const LiveState& state, const UiState& ui)
{
    to.button(Control::undo, why_not(Undo{}, state));
    to.button(Control::redo, why_not(Redo{}, state));
    to.button(Control::save, why_not(Save{}, state));
    to.button(Control::new_scene, why_not(Open{}, state));
    if (ControlState* const one = to.add(Control::open, std::string()))
        one->why_not = why_not(Open{}, state);
    if (ControlState* const one = to.add(Control::save_as, std::string()))
        one->why_not = why_not(Save{}, state);
    if (ControlState* const one = to.add(Control::export_file, std::string()))
        one->why_not = why_not(Export{}, state);
    if (state.steps)
        if (ControlState* const one = to.add(Control::go_to, 0)) {
            one->why_not = why_not(GoTo{}, state);
            one->label = "Steps";
        }
    to.choice(Control::export_what, ui.export_what, with_automatic(export_contents));
    to.choice(Control::export_unit, ui.export_unit, with_automatic(length_units));
    to.toggle(Control::export_chosen, ui.export_chosen);
}

void add_material(Builder& to, const SceneObject& object)
{
    std::vector<std::string> names;
    for (const MaterialSpec& spec : material_specs()) names.push_back(spec.name);
    to.choice(Control::preset, place_of(names, object.material.name), names);
    int number = 0;
    for (const MaterialQuantity& q : material_quantities()) {
        if (q.used(object.material) && q.slider.high > q.slider.low)
            to.number(Control::quantity, object.material.*q.value, q.slider, q.unit, number,
                      q.name);
        ++number;
    }
}

// A choice without a current one: each choice adds an object.
void add_adding(Builder& to, const LiveState& state, const UiState& ui)
{
    if (ControlState* const one = to.add(Control::add, -1)) {
        for (const NewShape& shape : new_shapes) one->choices.push_back(shape.name);
        one->why_not = why_not(AddObject{}, state);
    }
    if (ControlState* const one = to.add(Control::add_text, ui.text))
        one->why_not = why_not(AddObject{}, state);
    to.toggle(Control::place, ui.puts_down);
}

// Why no command applies to the chosen objects; "": none of them is locked.
std::string locked_of(const UiState& ui)
{
    const std::vector<ObjectId> all = selection(ui);
    for (const ObjectId id : all)
        if (const SceneObject* const o = ui.document->find(id); o->locked)
            return all.size() == 1 ? "the object is locked" : "\"" + o->name + "\" is locked";
    return {};
}

int colour_of(const SceneObject& object)
{
    if (!object.colour) return 0;
    for (std::size_t i = 1; i < object_colours.size(); ++i)
        if (equal(object_colours[i].colour, *object.colour)) return int(i);
    return -1;
}
std::vector<std::string> colour_names()
{
    std::vector<std::string> names;
    for (const NamedColour& one : object_colours) names.push_back(one.name);
    return names;
}

// What moves, copies and joins the chosen objects.
void add_arranging(Builder& to, const LiveState& state, const UiState& ui)
{
    const auto why = [&](const Command& command) {
        const std::string not_available = why_not(command, state);
        return not_available.empty() ? locked_of(ui) : not_available;
    };
    to.toggle(Control::several, ui.several);
    to.toggle(Control::snap, ui.snaps);
    to.button(Control::move, why(MoveObjects{}));
    to.button(Control::turn, why(MoveObjects{}));
    to.button(Control::scale, why(ScaleObjects{}));
    to.toggle(Control::on_surface, ui.on_surface);
    to.button(Control::duplicate, why_not(CopyObjects{}, state));
    const bool one = selection(ui).size() < 2;
    to.button(Control::merge, one ? "at least two objects have to be chosen" : why(MergeObjects{}));
    to.button(Control::split, why(SplitObject{}));
    to.button(Control::centre, why(MoveObjects{}));
    to.button(Control::reset_object, why(ResetObjects{}));
}

void add_clay(Builder& to, PanelModel& model, const LiveState& state, const UiState& ui)
{
    if (!ui.document) return;
    for (const auto& object : ui.document->objects) {
        ControlState* const one =
            to.add(Control::object, is_chosen(ui, object->id), int(object->id.value));
        if (one) one->label = object->name;
    }
    add_adding(to, state, ui);
    to.button(Control::choose_all, ui.document->objects.empty() ? "there is no object" : "");
    const SceneObject* const object = chosen_object(ui);
    if (!object) return;
    if (ControlState* const one = to.add(Control::rename, object->name)) one->label = "Name";
    to.toggle(Control::lock, object->locked);
    to.toggle(Control::hide, object->hidden);
    to.button(Control::remove, locked_of(ui));
    add_material(to, *object);
    for (PanelSection& section : model.sections)
        for (ControlState& one : section.controls)
            if (one.id.control == Control::preset) one.note = feel_of(object->material);
    add_arranging(to, state, ui);
    to.choice(Control::colour, colour_of(*object), colour_names());
}

void add_hands(Builder& to, const UiState& ui)
{
    if (ui.document) {
        std::vector<std::string> names = holdable_tools();
        names.front() = "bare hand";
        const auto held = [&](Side side) {
            return place_of(holdable_tools(), ui.document->hands->held[side]);
        };
        to.choice(Control::left_tool, held(left), names);
        to.choice(Control::right_tool, held(right), names);
    }
    to.toggle(Control::mouse_hand, ui.mouse_hand);
    to.choice(Control::posture, ui.posture, {posture_names, posture_names + posture_count});
    to.number(Control::press, ui.press, {press_range.low, press_range.high}, "m");
    to.number(Control::tilt, ui.tilt, {-1.5, 1.5}, "rad");
    to.number(Control::roll, ui.roll, {-3.14, 3.14}, "rad");
    for (int i = 0; i < 5; ++i)
        to.number(Control::curl, ui.curl[i], {0, 1}, "", i, finger_names[i]);
    to.toggle(Control::carry, ui.hand_mode == HandMode::carry);
    to.toggle(Control::choose, ui.hand_mode == HandMode::choose);
    to.toggle(Control::lay, ui.hand_mode == HandMode::lay);
    to.toggle(Control::nozzle, ui.nozzle);
    to.choice(Control::nozzle_section, ui.section, section_names());
    to.number(Control::nozzle_diameter, ui.diameter, nozzle_range, "m");
    to.toggle(Control::nozzle_ring, ui.ring);
    to.button(Control::recentre);
    to.toggle(Control::standing, ui.standing);
    to.toggle(Control::panel_side, ui.panel_side == left);
    to.toggle(Control::support, ui.support == left);
}

void add_scene(Builder& to, const LiveState& state, const UiState& ui)
{
    to.toggle(Control::pause, ui.paused);
    to.button(Control::advance, ui.paused ? "" : "the session is not paused");
    to.button(Control::reset, why_not(Reset{}, state));
    if (state.scene && state.scene->recording) to.toggle(Control::recorded, state.recorded);
    if (!ui.document) return;
    const SceneSettings& scene = *ui.document->scene;
    to.number(Control::gravity, 0.0 - scene.gravity.y, gravity_slider,
              std::get<0>(Row<SetGravity>::fields).range.unit);
    to.choice(Control::contact, scene.contact.separate, {"weld", "are separate"});
    if (scene.contact.separate)
        to.number(Control::contact_friction, scene.contact.friction, {0, 1}, "");
    to.whole(Control::cells, scene.cells, cells_range);
    to.whole(Control::surface, scene.surface_nodes, surface_range);
}

void add_view(Builder& to, const UiState& ui)
{
    to.button(Control::frame_view);
    to.button(Control::frame_all);
    to.button(Control::screenshot);
    if (ControlState* const one = to.add(Control::film, ui.filming))
        if (ui.filming) one->label = "End film";
    to.toggle(Control::help, ui.help);
    to.toggle(Control::panels, ui.open);
    to.button(Control::quit);
}

// The value of an event, if it has this type.
template <class T>
const T* value_of(const ControlEvent& event)
{
    return std::get_if<T>(&event.value);
}

std::vector<Command> material_commands(const UiState& ui, const ControlEvent& event)
{
    const SceneObject* const object = chosen_object(ui);
    if (!object) return {};
    if (event.id.control == Control::preset) {
        const int* const at = value_of<int>(event);
        if (!at || *at < 0 || std::size_t(*at) >= material_specs().size()) return {};
        return {SetMaterial{object->id, material_specs()[std::size_t(*at)]}};
    }
    const auto all = material_quantities();
    const double* const value = value_of<double>(event);
    if (!value || event.id.index < 0 || std::size_t(event.id.index) >= all.size()) return {};
    const MaterialQuantity& q = all[std::size_t(event.id.index)];
    if (!q.used(object->material)) return {};
    MaterialSpec to = object->material;
    to.*q.value = *value;
    return {SetMaterial{object->id, to}};
}

std::vector<Command> add_command(const LiveState& state, const UiState& ui,
                                 const ControlEvent& event)
{
    const int* const at = value_of<int>(event);
    if (!at || *at < 0 || std::size_t(*at) >= new_shapes.size() || !state.document) return {};
    const SceneObject* const like = chosen_object(ui);
    const MaterialSpec& material = like ? like->material : material_spec("clay");
    // A surface is made every few frames.
    constexpr long lag = 30;
    std::vector<ObjectId> recent;
    for (const auto& [id, frame] : ui.appeared)
        if (state.frame.number <= frame + lag) recent.push_back(id);
    return {AddObject{new_object(state, recent, new_shapes[std::size_t(*at)], material, ui.text)}};
}

// Of gravity, contact of objects, cells and surface.
std::vector<Command> scene_command(const ControlEvent& event)
{
    const double* const number = value_of<double>(event);
    const int* const whole = value_of<int>(event);
    switch (event.id.control) {
        case Control::gravity:
            if (number) return {SetGravity{{0, 0.0 - *number, 0}}};
            return {};
        case Control::contact:
            if (whole) return {SetContact{CategoryContact(std::clamp(*whole, 0, 1)), {}}};
            return {};
        case Control::contact_friction:
            if (number) return {SetContact{{}, *number}};
            return {};
        case Control::cells:
            if (whole) return {SetLattice{*whole}};
            return {};
        default:
            if (whole) return {SetSurface{*whole}};
            return {};
    }
}

std::vector<Command> tool_command(const ControlEvent& event)
{
    const int* const at = value_of<int>(event);
    if (!at || *at < 0 || std::size_t(*at) >= holdable_tools().size()) return {};
    SetHands command;
    (event.id.control == Control::left_tool ? command.left : command.right).held =
        holdable_tools()[std::size_t(*at)];
    return {command};
}

// Commands take the active object first: of several that are merged it stays.
std::vector<ObjectRef> chosen_refs(const UiState& ui)
{
    std::vector<ObjectRef> refs;
    for (const ObjectId id : selection(ui)) refs.push_back(id);
    return refs;
}

std::vector<Command> object_command(const UiState& ui, const ControlEvent& event)
{
    const SceneObject* const object = chosen_object(ui);
    if (!object) return {};
    if (event.id.control == Control::remove) return {RemoveObjects{chosen_refs(ui)}};
    if (event.id.control == Control::rename) {
        const std::string* const name = value_of<std::string>(event);
        if (!name || *name == object->name) return {};
        return {Rename{object->id, *name}};
    }
    const bool* const on = value_of<bool>(event);
    if (!on) return {};
    std::vector<Command> all;
    for (const ObjectId id : selection(ui)) {
        SetFlags command{id, {}, {}};
        (event.id.control == Control::lock ? command.locked : command.hidden) = *on;
        all.push_back(command);
    }
    return all;
}

// Of controls that move, copy, join or colour the chosen objects; of others nothing. `ui.places`
// are those of this moment.
std::vector<Command> arranging_command(const LiveState& state, const UiState& ui,
                                       const ControlEvent& event)
{
    const std::vector<ObjectRef> refs = chosen_refs(ui);
    const Control control = event.id.control;
    if (refs.empty() || !state.scene) return {};
    if (control == Control::merge) return {MergeObjects{refs, {}}};
    if (control == Control::reset_object) return {ResetObjects{refs}};
    if (control == Control::split) {
        std::vector<Command> all;
        for (const ObjectRef& ref : refs) all.push_back(SplitObject{ref, {}, true, {}, {}});
        return all;
    }
    if (control == Control::colour) {
        const int* const at = value_of<int>(event);
        if (!at || *at < 0 || std::size_t(*at) >= object_colours.size()) return {};
        return {SetColour{refs, *at == 0 ? std::nullopt
                                         : std::optional(object_colours[std::size_t(*at)].colour)}};
    }
    if (!ui.places || (control != Control::duplicate && control != Control::centre)) return {};
    const std::vector<ObjectId> chosen = selection(ui);
    const WallOptions& walls = ui.document->scene->walls;
    const Vec3<double> origin = state.scene->scene.origin;
    const CommonPlace common = common_place(*ui.places, chosen);
    const Vec3<double> size = common.box.high - common.box.low;
    // A surface is about a cell around its clay.
    const double gap =
        std::min(2 * state.scene->scene.setup.lattice.dx, std::max({size.x, size.y, size.z}) / 4);
    const Surroundings around{*ui.places, {walls.min - origin, walls.max - origin}, gap};
    if (control == Control::duplicate) return {CopyObjects{refs, beside(around, chosen), {}, {}}};
    return {MoveObjects{refs, to_middle(around, chosen), {}, {}}};
}

Open open_command(const UiState& ui, const std::string& file)
{
    // A session has its own settings.
    if (fs::path(file).extension() == session_ending) return {file, {}, {}};
    return {file, ui.settings, ui.cells > 0 ? std::optional(ui.cells) : std::nullopt};
}

Export export_command(const UiState& ui, const std::string& file)
{
    Export command{file, {}, {}, {}};
    if (ui.export_what > 0)
        command.what = export_contents.at(std::size_t(ui.export_what - 1)).second;
    if (ui.export_unit > 0) command.unit = length_units.at(std::size_t(ui.export_unit - 1)).second;
    if (ui.export_chosen && chosen_object(ui)) command.objects = chosen_refs(ui);
    return command;
}

std::vector<Command> file_command(const LiveState& state, const UiState& ui,
                                  const ControlEvent& event)
{
    if (event.id.control == Control::new_scene) return {open_command(ui, new_scene_name)};
    if (event.id.control == Control::save) return {save_command(state)};
    const std::string* const file = value_of<std::string>(event);
    if (!file || file->empty()) return {};
    if (event.id.control == Control::save_as) return {Save{*file, {}}};
    if (event.id.control == Control::export_file) return {export_command(ui, *file)};
    return {open_command(ui, *file)};
}

// Of the nozzle that the mouse leads.
bool change_nozzle(UiState& ui, const ControlEvent& event)
{
    const bool* const on = value_of<bool>(event);
    const double* const number = value_of<double>(event);
    const int* const whole = value_of<int>(event);
    switch (event.id.control) {
        case Control::nozzle:
            ui.nozzle = on ? *on : !ui.nozzle;
            if (ui.nozzle) ui.mouse_hand = false;
            return true;
        case Control::nozzle_section:
            if (whole) ui.section = std::clamp(*whole, 0, int(section_names().size()) - 1);
            return true;
        case Control::nozzle_ring:
            ui.ring = on ? *on : !ui.ring;
            return true;
        case Control::nozzle_diameter:
            if (number) ui.diameter = std::clamp(*number, nozzle_range.low, nozzle_range.high);
            return true;
        default:
            return false;
    }
}

// Of what is chosen and how it is moved.
bool change_choice(UiState& ui, const ControlEvent& event)
{
    const bool* const on = value_of<bool>(event);
    switch (event.id.control) {
        case Control::object: {
            const ObjectId id{std::uint32_t(event.id.index)};
            if (on || ui.several)
                (on ? *on : !is_chosen(ui, id)) ? choose_more(ui, id) : unchoose(ui, id);
            else
                choose(ui, id);
            return true;
        }
        case Control::choose_all:
            choose(ui, {});
            for (std::size_t i = 0; ui.document && i < ui.document->objects.size(); ++i)
                choose_more(ui, ui.document->objects[i]->id);
            return true;
        case Control::several:
            ui.several = on ? *on : !ui.several;
            return true;
        case Control::snap:
            ui.snaps = on ? *on : !ui.snaps;
            return true;
        case Control::on_surface:
            ui.on_surface = on ? *on : !ui.on_surface;
            return true;
        default:
            return false;
    }
}

}  // namespace

const ControlState* PanelModel::find(ControlId id) const
{
    for (const PanelSection& section : sections)
        for (const ControlState& one : section.controls)
            if (one.id == id) return &one;
    return nullptr;
}

const std::vector<std::string>& holdable_tools()
{
    static const std::vector<std::string> all = [] {
        std::vector<std::string> names = tool_names();
        names.insert(names.begin(), "");
        return names;
    }();
    return all;
}

std::vector<ObjectId> selection(const UiState& ui)
{
    std::vector<ObjectId> all;
    const auto add = [&](ObjectId id) {
        if (ui.document && ui.document->find(id)) all.push_back(id);
    };
    add(ui.chosen);
    for (const ObjectId id : ui.also_chosen) add(id);
    return all;
}

void choose(UiState& ui, ObjectId object) { ui.chosen = object, ui.also_chosen.clear(); }

void choose_more(UiState& ui, ObjectId object)
{
    if (object == ui.chosen) return;
    std::erase(ui.also_chosen, object);
    if (ui.chosen.value) ui.also_chosen.push_back(ui.chosen);
    ui.chosen = object;
}

void unchoose(UiState& ui, ObjectId object)
{
    std::erase(ui.also_chosen, object);
    if (object != ui.chosen) return;
    ui.chosen = {};
    if (ui.also_chosen.empty()) return;
    ui.chosen = ui.also_chosen.back();
    ui.also_chosen.pop_back();
}

PanelModel panel_model(const LiveState& state, const UiState& ui)
{
    PanelModel model;
    Builder to(state, ui, model);
    add_session(to, state, ui);
    add_clay(to, model, state, ui);
    add_hands(to, ui);
    add_scene(to, state, ui);
    add_view(to, ui);
    model.steps = state.steps;
    model.recoverable = ui.recoverable;
    model.files = ui.recent;
    for (const std::string& one : ui.beside)
        if (place_of(model.files, one) < 0) model.files.push_back(one);
    model.folder = fs::path(ui.scene).parent_path().string();
    model.saves_as = ui.saves_as;
    model.exports_as = fs::path(model.saves_as).replace_extension(".glb").string();
    model.session = session_line(state);
    model.failure = state.failure, model.notice = ui.notice, model.pointing = ui.pointing;
    model.facts = ui.facts, model.question = ui.question;
    model.open = ui.open, model.help = ui.help;
    model.active = int(ui.chosen.value);
    return model;
}

std::vector<Command> commands_for(const LiveState& state, const UiState& ui,
                                  const ControlEvent& event)
{
    const auto on = [&]() -> bool { return value_of<bool>(event) && *value_of<bool>(event); };
    switch (event.id.control) {
        case Control::undo:
            return {Undo{}};
        case Control::redo:
            return {Redo{}};
        case Control::go_to:
            if (const int* const step = value_of<int>(event)) return {GoTo{*step}};
            return {};
        case Control::new_scene:
        case Control::open:
        case Control::save:
        case Control::save_as:
        case Control::export_file:
            return file_command(state, ui, event);
        case Control::recover: {
            const std::size_t row = std::size_t(event.id.index);
            if (row >= ui.recoverable.size()) return {};
            return {Open{ui.recoverable[row].file, {}, {}}};
        }
        case Control::preset:
        case Control::quantity:
            return material_commands(ui, event);
        case Control::add:
            return add_command(state, ui, event);
        case Control::rename:
        case Control::lock:
        case Control::hide:
        case Control::remove:
            return object_command(ui, event);
        case Control::left_tool:
        case Control::right_tool:
            return tool_command(event);
        case Control::reset:
            return {Reset{}};
        case Control::pause:
            return {Pause{on()}};
        case Control::advance:
            return {Advance{1}};
        case Control::recorded:
            return {Play{on()}};
        case Control::gravity:
        case Control::contact:
        case Control::contact_friction:
        case Control::cells:
        case Control::surface:
            return scene_command(event);
        default:
            return arranging_command(state, ui, event);
    }
}

bool change(UiState& ui, const ControlEvent& event)
{
    if (change_choice(ui, event) || change_nozzle(ui, event)) return true;
    const bool* const on = value_of<bool>(event);
    const double* const number = value_of<double>(event);
    const int* const whole = value_of<int>(event);
    switch (event.id.control) {
        case Control::add_text:
            if (const std::string* const text = value_of<std::string>(event)) ui.text = *text;
            return true;
        case Control::place:
            ui.puts_down = on ? *on : !ui.puts_down;
            return true;
        case Control::mouse_hand:
            ui.mouse_hand = on ? *on : !ui.mouse_hand;
            if (ui.mouse_hand) ui.nozzle = false;
            return true;
        case Control::posture:
            ui.posture =
                whole ? std::clamp(*whole, 0, posture_count - 1) : (ui.posture + 1) % posture_count;
            return true;
        case Control::press:
            if (number) ui.press = *number;
            return true;
        case Control::tilt:
            if (number) ui.tilt = *number;
            return true;
        case Control::roll:
            if (number) ui.roll = *number;
            return true;
        case Control::curl:
            if (number && event.id.index >= 0 && event.id.index < 5)
                ui.curl[event.id.index] = *number;
            return true;
        case Control::export_what:
            if (whole) ui.export_what = std::clamp(*whole, 0, int(export_contents.size()));
            return true;
        case Control::export_unit:
            if (whole) ui.export_unit = std::clamp(*whole, 0, int(length_units.size()));
            return true;
        case Control::export_chosen:
            if (on) ui.export_chosen = *on;
            return true;
        case Control::support:
            if (on) ui.support = *on ? left : right;
            return true;
        case Control::panel_side:
            if (on) ui.panel_side = *on ? left : right;
            return true;
        case Control::panels:
            ui.open = on ? *on : !ui.open;
            return true;
        case Control::help:
            ui.help = on ? *on : !ui.help;
            return true;
        case Control::hide_recoverable:
            ui.recoverable.clear();
            return true;
        default:
            return false;
    }
}

}  // namespace knead
