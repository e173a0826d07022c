#include "host/ui/panel_controller.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "host/base/errors.h"
#include "host/base/paths.h"
#include "host/document/command_table.h"
#include "host/scene/new_scene.h"
#include "host/ui/dropped.h"
#include "host/ui/recent_files.h"
#include "host/ui/scene_list.h"
#include "host/ui/session_line.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

std::string name_of(const std::string& path) { return fs::path(path).filename().string(); }

// What the front end does, because it has a camera, a clock, a headset.
bool is_of_front_end(Control control)
{
    switch (control) {
        case Control::frame_view:
        case Control::frame_all:
        case Control::move:
        case Control::turn:
        case Control::scale:
        case Control::screenshot:
        case Control::film:
        case Control::pause:
        case Control::advance:
        case Control::quit:
        case Control::carry:
        case Control::choose:
        case Control::lay:
        case Control::recentre:
        case Control::standing:
            return true;
        default:
            return false;
    }
}

}  // namespace

PanelController::PanelController(unsigned place, const std::string& scene,
                                 std::vector<std::string> settings, int cells)
    : asks(place == in_window)
{
    ui.place = place, ui.scene = scene;
    ui.settings = std::move(settings), ui.cells = cells;
    ui.beside = scenes_beside(scene);
}

void PanelController::remember_files()
{
    remembers_ = true;
    ui.recent = recent_files();
}

void PanelController::remember(const std::string& file)
{
    if (!remembers_ || ending(file) == log_ending || file == new_scene_name) return;
    add_recent_file(file);
    ui.recent = recent_files();
}

void PanelController::note(const std::string& text) { ui.notice = text, noticed_ = now_; }

void PanelController::follow(const LiveState& state, LiveSession& session, double now)
{
    now_ = now;
    if (now_ > noticed_ + notice_for) ui.notice.clear();
    const bool refused = state.refused != refused_ && !state.refusal.empty();
    refused_ = state.refused;
    const bool anew = state.scene && state.history != history_;
    if (anew) follow_scene(state);
    if (refused) {
        note(state.refusal);
        opens_.clear();
        if (pending_ && pending_->saves) pending_.reset();
    }
    // Controls may be ahead of the state until all commands are answered.
    const bool other = state.document != shown_ || refused;
    if (state.document && (anew || (other && state.answered >= sent_))) {
        shown_ = ui.document = state.document;
        choose_object(anew, state.frame.number);
    }
    if (!state.saved_as.empty() && state.saved_as != saved_as_) {
        remember(state.saved_as);
        ui.saves_as = state.saved_as;
    }
    saved_as_ = state.saved_as;
    if (state.exports > exports_) note("Wrote " + state.exported);
    exports_ = state.exports;
    std::erase_if(ui.recoverable,
                  [&](const RecoverRow& row) { return row.file == state.log.file; });
    if (pending_ && pending_->saves && !state.unsaved)
        act(std::exchange(pending_, {})->event, session);
    if (goes_to_ && state.answered >= sent_) send(GoTo{*std::exchange(goes_to_, {})}, session);
    ui.question = {};
    if (pending_ && !pending_->saves) ui.question = {pending_->text, pending_->answers};
    refresh(state);
}

// After a load or reset.
void PanelController::follow_scene(const LiveState& state)
{
    history_ = state.history;
    ui.placing.reset();
    const bool other = state.scene.get() != scene_;
    scene_ = state.scene.get();
    if (!other) return;
    const std::string opened = std::exchange(opens_, {});
    // A working log has no name that tells anything.
    if (!opened.empty()) ui.scene = ending(opened) == log_ending ? state.scene->scene.path : opened;
    ui.beside = scenes_beside(state.scene->scene.path);
    remember(ui.scene);
    ui.saves_as = save_command(state).file;
    // A tool is held in a fist.
    ui.posture = int(state.hands.held[right].empty() ? Posture::relaxed : Posture::fist);
}

// New objects are chosen; in place of the active one that is gone, another chosen one, else the
// first of all. If none was chosen, none is.
void PanelController::choose_object(bool anew, long frame)
{
    std::vector<ObjectId> now;
    for (const auto& one : ui.document->objects) now.push_back(one->id);
    std::vector<ObjectId> added;
    std::set_difference(now.begin(), now.end(), objects_.begin(), objects_.end(),
                        std::back_inserter(added));
    if (anew) ui.appeared.clear();
    std::erase_if(ui.appeared, [&](const auto& one) { return !ui.document->find(one.first); });
    for (const ObjectId id : added)
        if (!anew) ui.appeared[id] = frame;
    const bool none = ui.chosen.value == 0;
    std::erase_if(ui.also_chosen, [&](ObjectId id) { return !ui.document->find(id); });
    if (!ui.document->find(ui.chosen)) unchoose(ui, ui.chosen);
    if (!anew && !added.empty()) {
        choose(ui, {});
        for (const ObjectId id : added) choose_more(ui, id);
    }
    if (!ui.chosen.value && !now.empty() && (anew || !none)) ui.chosen = now.front();
    objects_ = std::move(now);
}

void PanelController::list_recoverable(std::vector<Recoverable> all)
{
    ui.recoverable.clear();
    for (const Recoverable& one : all) {
        RecoverRow row{one.file,
                       fs::path(one.scene).stem().string(),
                       fmt::format("{} ago, {} step{}", duration_text(one.age), one.steps - 1,
                                   one.steps == 2 ? "" : "s"),
                       {}};
        try {
            if (!one.picture.empty())
                row.picture = std::make_shared<const Image>(decoded_png(one.picture, one.file));
        } catch (const InputError&) {  // the session may be valid without it
        }
        ui.recoverable.push_back(std::move(row));
    }
}

void PanelController::discard_log(std::size_t at)
{
    if (at >= ui.recoverable.size()) return;
    try {
        delete_log(ui.recoverable[at].file);
        ui.recoverable.erase(ui.recoverable.begin() + std::ptrdiff_t(at));
    } catch (const OutputError& e) {
        note(e.what());
    }
}

void PanelController::send(Command command, LiveSession& session, unsigned drag)
{
    if (ui.document) {
        IdSource ids;  // unused: an added object appears once the session has numbered it
        const auto next = reduce(ui.document, command, ids);
        if (const DocumentPtr* to = std::get_if<DocumentPtr>(&next))
            if (!adds_objects(command)) ui.document = *to;
    }
    if (const Open* open = std::get_if<Open>(&command)) opens_ = open->file;
    const long serial = session.send(std::move(command), ui.origin(), drag);
    if (serial == 0) note("too many commands are waiting");
    sent_ = std::max(sent_, serial);
}

// Whether something would be lost, or is not saved. Undo reverses a reset where there are steps; a
// session with a log can be recovered.
bool PanelController::loses(Control control, const LiveState& state) const
{
    if (control == Control::discard_log) return true;
    const bool keeps_steps = state.situation.no_steps.empty();
    if (control == Control::reset) return loses_clay && !keeps_steps;
    if (control == Control::cells) return false;  // the command is refused then
    return state.unsaved || (loses_clay && (!keeps_steps || state.log.file.empty()));
}

void PanelController::ask(const ControlEvent& event, const LiveState& state)
{
    const Control control = event.id.control;
    Pending question{event, {}, {}, false};
    const std::string* file = std::get_if<std::string>(&event.value);
    std::string verb = row_of(control).label, what;
    if (control == Control::open && file) what = name_of(*file);
    if (const std::size_t row = std::size_t(event.id.index);
        (control == Control::recover || control == Control::discard_log) &&
        row < ui.recoverable.size())
        what = ui.recoverable[row].name;
    question.text = what.empty() ? verb + "?" : fmt::format("{} \"{}\"?", verb, what);
    if (control == Control::discard_log)
        question.text += " It cannot be recovered then.";
    else if (state.unsaved)
        question.text += " This session is not saved; it can be recovered.";
    else
        question.text += " The shaped clay will be lost.";
    const bool saves =
        state.unsaved && control != Control::discard_log && why_not(Save{}, state).empty();
    if (saves)
        question.answers = {"Save first", verb + " without saving", "Cancel"};
    else
        question.answers = {verb, "Cancel"};
    pending_ = std::move(question);
    ui.question = {pending_->text, pending_->answers};
}

void PanelController::answer(int button, LiveSession& session)
{
    if (!pending_ || pending_->saves) return;
    const int last = int(pending_->answers.size()) - 1;
    ui.question = {};
    if (button < 0 || button >= last) return pending_.reset();
    if (last == 2 && button == 0) {
        pending_->saves = true;
        return send(save_command(*session.state()), session);
    }
    act(std::exchange(pending_, {})->event, session);
}

bool PanelController::decline()
{
    if (!pending_ || pending_->saves) return false;
    pending_.reset();
    ui.question = {};
    return true;
}

void PanelController::apply(const ControlEvent& event, LiveSession& session)
{
    const std::shared_ptr<const LiveState> state = session.state();
    ui.notice.clear();
    const std::string* const file = std::get_if<std::string>(&event.value);
    if (event.id.control == Control::open && file && adds_object(*file)) {
        take_object(*file, *state, session);
    } else if (event.id.control == Control::answer) {
        answer(event.id.index, session);
    } else if (asks && row_of(event.id.control).discards && loses(event.id.control, *state)) {
        ask(event, *state);
    } else {
        act(event, session);
    }
    refresh(*state);
}

void PanelController::take_object(const std::string& file, const LiveState& state,
                                  LiveSession& session)
{
    auto what = command_for_file(file, state);
    if (const Refusal* refusal = std::get_if<Refusal>(&what))
        note(refusal->text());
    else
        send(std::move(std::get<Command>(what)), session);
}

void PanelController::begin_placing(SceneObject object)
{
    note(ui.place == in_window ? "A click puts it down; Esc or the right button cancels."
                               : "A pinch puts it down; a fist cancels.");
    ui.placing = std::move(object);
}

void PanelController::act(const ControlEvent& event, LiveSession& session)
{
    const Control control = event.id.control;
    if (change(ui, event)) return;
    if (control == Control::discard_log) return discard_log(std::size_t(event.id.index));
    if (is_of_front_end(control)) return execute(event);
    const std::shared_ptr<const LiveState> state = session.state();
    if (control == Control::go_to && event.drag && std::holds_alternative<int>(event.value)) {
        // One step at a time while the slider is dragged: the newest, when the last is reached.
        goes_to_ = std::get<int>(event.value);
        if (state->answered < sent_) return;
        return send(GoTo{*std::exchange(goes_to_, {})}, session);
    }
    if (control == Control::duplicate || control == Control::centre)
        ui.places = session.object_places();
    for (Command& one : commands_for(*state, ui, event)) {
        if (const std::string why = why_not(one, *state); !why.empty())
            note(why);
        else if (AddObject* const adds = std::get_if<AddObject>(&one); adds && ui.puts_down)
            begin_placing(std::move(adds->object));
        else
            send(std::move(one), session, event.drag);
    }
    const bool* const on = std::get_if<bool>(&event.value);
    const int* const whole = std::get_if<int>(&event.value);
    if (control == Control::right_tool && whole)
        ui.posture = int(*whole == 0 ? Posture::relaxed : Posture::fist);
    if (control == Control::recorded && on && *on) ui.mouse_hand = false;
    // Before the first frame, so that recorded hands do not move the tools.
    if (row_of(control).discards && ui.mouse_hand) send(Play{false}, session);
}

}  // namespace knead
