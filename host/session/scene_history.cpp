#include "host/session/scene_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "host/solver/between.h"

namespace knead {
namespace {

// Commands of the document that change no clay.
bool leaves_clay(const Command& command)
{
    return std::holds_alternative<Rename>(command) || std::holds_alternative<SetFlags>(command) ||
           std::holds_alternative<SetCategory>(command) ||
           std::holds_alternative<SetColour>(command);
}

// Clay slower than two cells per second has settled.
StepRuleOptions rule_options(const Scene& scene)
{
    StepRuleOptions by;
    by.calm_speed = 2 * scene.setup.lattice.dx;
    return by;
}

// Whether tools change the clay: a blade is in it, or at least a quarter of a particle a substep is
// put out of tools. What grazes it is no step.
bool presses(const FrameStats& stats)
{
    return stats.touched != 0 &&
           (stats[Count::covered] > 0 || 4 * stats[Count::projected] >= stats.substeps);
}

// Null: the lossless codec.
std::shared_ptr<const Quantisation> steps_by(Codec codec, std::size_t particles,
                                             const Quantisation& steps)
{
    if (codec == Codec::automatic)
        codec = particles > most_lossless_particles ? Codec::quantised : Codec::lossless;
    return codec == Codec::lossless ? nullptr : std::make_shared<const Quantisation>(steps);
}

ClayRows rows_at(const EditableSimulator& simulator)
{
    return simulator.rows(*simulator.snapshot());
}

}  // namespace

std::string SceneHistory::why_none(const Scene& scene, const Simulator& simulator)
{
    if (!simulator.editable()) return "this simulator takes no edits (--device cpu:double)";
    const bool local =
        std::ranges::any_of(scene.objects, [](const Object& o) { return o.local(); });
    if (local) return "a scene with splats.depth keeps no steps: most of its clay has no particles";
    return "";
}

SceneHistory::SceneHistory(Parts with, const std::string& label, StepSource decided_by)
    : parts(std::move(with)),
      none(parts.simulator ? why_none(parts.scene, *parts.simulator)
                           : "this simulator takes no edits (--device cpu:double)"),
      source(decided_by),
      rule(rule_options(parts.scene)),
      watch(parts.scene)
{
    if (!none.empty()) return;
    parts.simulator->reserve_snapshots(2);
    if (parts.past.count() > 0) {
        in_step = false;
        if (source == StepSource::rule && !label.empty()) begin(label), capture();
        return;
    }
    begin_past(label, has_velocity(*document()));
}

void SceneHistory::begin_past(const std::string& label, bool moves)
{
    HistoryStep first{
        0,        0,          label,
        0,        document(), std::make_shared<const ObjectNumbers>(parts.editor.numbers()),
        splats(), {},         true};
    if (moves)
        first.beginning = std::make_shared<const InitialState>(parts.simulator->save().contents);
    auto rows = std::make_shared<const ClayRows>(rows_at(*parts.simulator));
    parts.past.begin(std::move(first), std::move(rows));
}

void SceneHistory::begin_again()
{
    if (!none.empty()) return;
    last_splats.reset();
    begin_past("", true);
}

void SceneHistory::emit(const SessionEvent& event) const
{
    if (parts.events) parts.events(event);
}

// Shared between steps as long as no splat is split or added.
std::shared_ptr<const CarriedSplats> SceneHistory::splats() const
{
    const CarriedSplats& now = parts.splats.state();
    if (now.count() == 0) {
        last_splats.reset();  // the next may be as many, but others
        return nullptr;
    }
    if (!last_splats || last_splats->count() != now.count())
        last_splats = std::make_shared<const CarriedSplats>(now);
    return last_splats;
}

Situation SceneHistory::situation(bool live) const
{
    Situation s = parts.editor.situation(live);
    s.no_undo = s.no_redo = s.no_steps = none;
    if (!none.empty()) return s;
    if (!parts.past.undo()) s.no_undo = "there is nothing to undo";
    if (!parts.past.redo()) s.no_redo = "there is nothing to redo";
    return s;
}

void SceneHistory::begin(const std::string& label)
{
    const StepId parent = parts.past.current().id;
    const StepId id = parts.past.open(
        label, document(), std::make_shared<const ObjectNumbers>(parts.editor.numbers()));
    open_by_command = false, last = {};
    emit(StepBegun{id, parent, label});
}

// The snapshot is read and encoded on another thread, after the capture before it.
void SceneHistory::capture()
{
    const std::shared_ptr<const Snapshot> now = parts.simulator->snapshot();
    const HistoryStep& step = parts.past.current();
    parts.past.update(document(), std::make_shared<const ObjectNumbers>(parts.editor.numbers()));
    const FutureCapture made = thread.add([simulator = parts.simulator, now, codec = parts.codec,
                                           by = quantisation_of(parts.simulator->config()),
                                           before = parts.past.resident_later()] {
        ClayRows rows = simulator->rows(*now);
        const auto steps = steps_by(codec, rows.count, by);
        if (steps) rows = quantised(std::move(rows), *steps);
        return capture_of(*before.get(), std::make_shared<const ClayRows>(std::move(rows)), steps);
    });
    emit(StepCaptured{step.id});
    parts.past.capture(made, splats(), frame_count);
    in_step = true;
    if (parts.captured) parts.captured(parts.past.current(), made);
    open_by_command = false, last = {};
}

// From source_begin to source_end all is one step, unless something else begins one meanwhile.
bool SceneHistory::extrudes() const
{
    return open_by_command && of_source(last.command) && has_nozzle(*document());
}

namespace {

bool moves_or_scales(const Command& command)
{
    return std::holds_alternative<MoveObjects>(command) ||
           std::holds_alternative<ScaleObjects>(command);
}

}  // namespace

// Of several commands of a drag, the later ones change the step that the first began.
bool SceneHistory::merges(const Issued& issued) const
{
    if (extrudes() && of_source(issued.command)) return true;
    const bool same_drag = open_by_command && issued.drag != 0 && issued.drag == last.drag &&
                           issued.origin == last.origin;
    if (!same_drag) return false;
    // Two hands move and scale at once.
    if (moves_or_scales(issued.command) && moves_or_scales(last.command))
        return issued.command.index() != last.command.index();
    return issued.command.index() == last.command.index() &&
           row_of(issued.command).undo == UndoRule::merge;
}

void SceneHistory::before_change()
{
    if (!parts.past.current().captured) capture();
}

bool SceneHistory::takes(const Command& command)
{
    return row_of(command).receiver == Receiver::document ||
           std::holds_alternative<Carry>(command) || std::holds_alternative<Undo>(command) ||
           std::holds_alternative<Redo>(command) || std::holds_alternative<GoTo>(command);
}

CommandAnswer SceneHistory::apply(const Issued& issued, PreparedObject* ready)
{
    const Command& command = issued.command;
    const auto goes = [&](std::optional<StepId> to, const char* nothing) {
        CommandAnswer answer{{}, command};
        if (!none.empty())
            answer.refusal = Refusal{none, ""};
        else if (!to)
            answer.refusal = Refusal{nothing, ""};
        else
            answer.refusal = go_to(*to);
        if (!answer.refusal) emit(CommandEvent{issued});
        return answer;
    };
    if (std::holds_alternative<Undo>(command))
        return goes(parts.past.undo(), "there is nothing to undo");
    if (std::holds_alternative<Redo>(command))
        return goes(parts.past.redo(), "there is nothing to redo");
    if (const GoTo* to = std::get_if<GoTo>(&command)) {
        if (none.empty() && !parts.past.find(StepId(to->step)))
            return {Refusal{fmt::format("there is no step {}", to->step), "step"}, {}};
        return goes(StepId(to->step), "");
    }
    const DocumentPtr before = document();
    const CommandRow& row = row_of(command);
    const bool steps = none.empty() && source == StepSource::rule &&
                       row.receiver == Receiver::document && row.undo != UndoRule::none;
    const bool merging = steps && merges(issued);
    if (steps && !merging && !parts.editor.refusal_of(command)) before_change();
    CommandAnswer answer = parts.editor.apply(command, ready);
    if (answer.refusal) return answer;
    Issued applied = issued;
    applied.command = answer.applied;
    emit(CommandEvent{applied});
    // Splats have other places in their list, or other sizes.
    if (reads_clay(command)) last_splats.reset();
    if (!steps || document() == before) return answer;
    if (!merging) begin(row.label);
    parts.past.update(document(), std::make_shared<const ObjectNumbers>(parts.editor.numbers()));
    if (leaves_clay(command)) {
        parts.past.capture_unchanged(frame_count);
        in_step = true;
        emit(StepCaptured{parts.past.current().id, true});
        if (parts.captured) parts.captured(parts.past.current(), {});
    } else {
        open_by_command = true, last = applied;
        rule.command(issued.drag != 0);
    }
    return answer;
}

// As commands of the session. They belong to the step of the hands that cut, while it is open.
bool SceneHistory::split_pieces(const FrameResult& frame)
{
    if (source != StepSource::rule || !parts.simulator) return false;
    bool any = false;
    for (const ObjectId id :
         watch.after_frame(frame, presses(frame.stats), parts.editor, *parts.simulator)) {
        const Command command = SplitObject{{id}, {}, true, {}, {}, {}};
        const CommandAnswer answer = parts.editor.apply(command);
        if (answer.refusal) {
            watch.refused(id);
            continue;
        }
        any = true;
        emit(CommandEvent{{answer.applied, 0, Origin::script, 0}});
        last_splats.reset();
        if (!none.empty()) continue;
        if (parts.past.current().captured) begin(row_of(command).label), rule.command();
        parts.past.update(document(),
                          std::make_shared<const ObjectNumbers>(parts.editor.numbers()));
    }
    return any;
}

bool SceneHistory::after_frame(const FrameResult& frame)
{
    ++frame_count;
    const bool split = split_pieces(frame);
    if (!none.empty() || source != StepSource::rule) return split;
    const bool open = !parts.past.current().captured;
    const bool touched = presses(frame.stats) || parts.editor.carries();
    const double seconds = frame.stats.cut ? frame.stats.reached : parts.loop.duration();
    const StepRule::Decision decision =
        rule.after_frame(touched, frame.stats.fastest, seconds, open);
    // Behind a slow capture the step stays open: two become one.
    if (decision.captures && open && !extrudes() && parts.past.resident_ready()) capture();
    if (decision.begins && parts.past.current().captured)
        begin(parts.editor.carries() ? "Carry" : "Press");
    parts.past.evict();
    return split;
}

// What is there now becomes a step of its own, which redo or go_to return to.
std::optional<Refusal> SceneHistory::go_to(StepId id)
{
    try {
        before_change();
        restore_step(id);
        return {};
    } catch (const std::bad_alloc&) {
        return Refusal{"out of memory", ""};
    } catch (const std::exception& e) {
        return Refusal{e.what(), "step"};
    }
}

void SceneHistory::restore_step(StepId id)
{
    const HistoryStep* to = parts.past.find(id);
    if (!to) throw std::invalid_argument(fmt::format("there is no step {}", id));
    const std::shared_ptr<const ClayRows> rows = parts.past.rows_of(id);
    const StepId from = parts.past.current().id;
    // Another step with the same particles: the clay stays as it is, also if it has moved since.
    if (in_step && id != from && parts.past.same_clay(from, id)) {
        parts.editor.restore_document(*to);
    } else {
        parts.editor.restore(*to, *rows);
        last_splats = to->splats;
        rule.restored(), watch.restored();
        unreleased = true, released.clear();
        in_step = true;
    }
    parts.past.go_to(id, rows);
    emit(StepRestored{id});
}

// A hand that is not tracked may come back inside the clay.
void SceneHistory::release_tools(Motion& motion)
{
    // A tool that only grazed the clay would begin another step.
    constexpr float with_margin = 1.25;
    if (!unreleased) return;
    const SimulationConfig& config = parts.simulator->config();
    released.resize(config.tools.size(), 0), motion.active.resize(config.tools.size(), 1);
    bool any = false;
    for (std::size_t tool = 0; tool < released.size(); ++tool)
        any = any || (motion.active[tool] && !released[tool]);
    if (!any) return;
    const std::vector<char> inside = tools_in_clay(config, motion, *parts.simulator, with_margin);
    for (std::size_t tool = 0; tool < released.size(); ++tool) {
        if (!motion.active[tool]) continue;
        released[tool] = released[tool] || !inside[tool];
        motion.active[tool] = released[tool];
    }
    unreleased = std::ranges::count(released, 0) > 0;
}

void SceneHistory::begin_step(const StepBegun& step)
{
    if (source == StepSource::stored) return;
    if (parts.past.current().id != step.parent || !parts.past.current().captured)
        throw std::invalid_argument("a step does not follow the current one");
    begin(step.label);
    if (parts.past.current().id != step.id)
        throw std::invalid_argument("a step has another number");
}

void SceneHistory::capture_step(const StepCaptured& step)
{
    if (source == StepSource::stored) {
        if (!parts.past.find(step.id)) return;
        parts.past.go_to(step.id, parts.past.rows_of(step.id));
        in_step = true;
        return;
    }
    if (parts.past.current().id != step.id || parts.past.current().captured)
        throw std::invalid_argument("a step that is not open was captured");
    if (step.unchanged)
        parts.past.capture_unchanged(frame_count), in_step = true;
    else
        capture();
}

}  // namespace knead
