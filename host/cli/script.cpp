#include "host/cli/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "host/base/errors.h"
#include "host/cli/verbs.h"
#include "host/document/command_text.h"
#include "host/hands/recording.h"
#include "host/run/report.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

bool is_there(const std::string& file)
{
    std::error_code problem;
    return std::filesystem::is_regular_file(file, problem);
}

std::string folder_of(const std::string& file)
{
    const auto folder = std::filesystem::path(file).parent_path();
    return folder.empty() ? "." : folder.string();
}

std::vector<LogEntry> entries_of(const CommandLog& log)
{
    std::vector<LogEntry> entries;
    for (const LoggedCommand& one : log.commands)
        entries.push_back({one.frame, one.command, one.line});
    return entries;
}

// What was recorded beside hands: commands, or the actions of older recordings.
struct Beside {
    std::string file;
    std::string scene, recording;
    std::vector<std::string> settings;
    std::vector<LogEntry> entries;
};
Beside recorded_beside(const std::string& recording, double rate, Vec3<double> origin)
{
    Beside found;
    if (const std::string file = command_log_of(recording); is_there(file)) {
        const CommandLog log = read_command_log(file, folder_of(file));
        std::vector<LogEntry> entries = entries_of(log);
        for (LogEntry& one : entries) one.line = 0;  // lines are those of --commands
        // Hands that are played again leave the files of their session alone.
        std::erase_if(entries, [](const LogEntry& one) {
            const Command* command = std::get_if<Command>(&one.done);
            return command && std::holds_alternative<Export>(*command);
        });
        return {file, log.scene, log.recording, log.settings, std::move(entries)};
    }
    if (const std::string file = actions_file(recording); is_there(file)) {
        ActionsFile actions = read_actions(file, rate, origin);
        return {file, actions.scene, actions.recording, actions.settings, std::move(actions.all)};
    }
    return found;
}

}  // namespace

RunScript::RunScript(const RunOptions& options, Scene& scene, const Note& by)
    : given(!options.commands.empty()),
      keep_going(options.keep_going),
      note(by),
      file(options.commands),
      first(std::make_shared<const Document>(document_of(scene))),
      ids(std::uint32_t(first->objects.size())),
      watches(scene.own_pieces)
{
    if (watches && !given)
        session = std::make_unique<RunSession>(options, scene, RunSession::Wants{});
    if (!given) return;
    const CommandLog read = read_command_log(file, options.out.empty() ? "." : options.out);
    log = entries_of(read);
    const auto has = [&](auto... of_type) {
        return std::ranges::any_of(log, [&](const LogEntry& entry) {
            const Command* c = std::get_if<Command>(&entry.done);
            return c && (std::holds_alternative<decltype(of_type)>(*c) || ...);
        });
    };
    session = std::make_unique<RunSession>(
        options, scene, RunSession::Wants{has(Undo{}, Redo{}, GoTo{}), has(Save{})});
    beginnings.push_back({"", first});
    if (read.recording.empty()) begin(scene);
}

void RunScript::refuse(const std::string& place, const Command& command, const Refusal& refusal,
                       SessionLoop* loop)
{
    const std::string field = refusal.field.empty() ? "" : "/" + refusal.field;
    const std::string text =
        fmt::format("{}/{}{}: refused: {}", place, row_of(command).name, field, refusal.why);
    if (keep_going) return (void)std::fprintf(stderr, "knead: %s\n", text.c_str());
    if (!loop) throw InputError(text);
    loop->refuse(text);
}

// Commands of the document before the first frame change the scene itself, up to the first one that
// reads the clay.
void RunScript::begin(Scene& scene)
{
    std::vector<LogEntry> later;
    DocumentPtr now = first;
    Situation situation;
    situation.live = false;
    bool clay = false;  // these commands have to wait for the clay
    for (LogEntry& entry : log) {
        const Command* command = std::get_if<Command>(&entry.done);
        clay = clay || reads_clay(*command);
        if (clay || entry.frame > 0 || row_of(*command).receiver != Receiver::document) {
            later.push_back(std::move(entry));
            continue;
        }
        const std::string place = fmt::format("{}:{}: ", file, entry.line);
        situation.document = now.get();
        if (const std::string why = row_of(*command).why_not(situation); !why.empty()) {
            refuse(place, *command, {why, ""}, nullptr);
            continue;
        }
        auto result = reduce(now, *command, ids);
        if (const Refusal* refusal = std::get_if<Refusal>(&result))
            refuse(place, *command, *refusal, nullptr);
        else
            now = std::get<DocumentPtr>(result);
        if (now != beginnings.back().document && row_of(*command).undo != UndoRule::none)
            beginnings.push_back({row_of(*command).label, now});
    }
    beginnings.back().document = now;
    log = std::move(later);
    if (now == first) return;
    first = now;
    scene = scene_of(std::move(scene), *now);
}

void RunScript::add_recorded(const Scene& scene, const Recording& of)
{
    recording = of;
    Beside found = recorded_beside(scene.hands.recording, scene.frame_rate, scene.origin);
    beside = found.file;
    if (beside.empty()) return;
    if (found.recording != file_hash(scene.hands.recording))
        throw InputError(beside + ": expected the commands recorded with " + scene.hands.recording +
                         ", found those of another recording; without the file, only the hands "
                         "are played");
    note(fmt::format("{}: played, too; commands: {}", beside, found.entries.size()));
    if (!found.settings.empty())
        note(fmt::format("{}: recorded of {} with --set {}", beside, found.scene,
                         fmt::join(found.settings, " --set ")));
    std::ranges::stable_sort(found.entries, {}, &LogEntry::frame);
    std::vector<LogEntry> all;
    std::ranges::merge(found.entries, log, std::back_inserter(all), {}, &LogEntry::frame,
                       &LogEntry::frame);
    log = std::move(all);
    hands = std::make_unique<RecordedHands>(of, scene.hands, scene.frame_rate);
}

std::vector<int> RunScript::simulated(ObjectId object) const
{
    if (editor) return editor->simulated(object);
    const auto at =
        std::ranges::find_if(first->objects, [&](const auto& one) { return one->id == object; });
    return {int(at - first->objects.begin())};
}

void RunScript::play(const Scene& scene, SceneSplats& splats, Simulator& solver,
                     const HandSource* played, int frames, RunObserver& watch)
{
    replay = std::make_unique<CommandReplay>(std::move(log));
    MotionSource motion = recorded_motion(played, scene.hands);
    if (hands) motion = [this](double from, double to) { return hands->motion(from, to); };
    watch.motion = motion;
    if (session)
        watch.motion = [this, motion](double from, double to) {
            return session->with_motion(motion(from, to));
        };
    watch.edits = [this, &scene, &splats, &solver, frames](int number, SessionLoop& loop) {
        if (!editor) {
            editor = std::make_unique<SceneEditor>(
                SceneEditor::Parts{scene, splats, loop, solver.editable(),
                                   [this, &loop, &solver, &splats](const HandsOptions& to) {
                                       const HandTools made = hand_tools(to);
                                       solver.editable()->set_tools(made.rig, made.tools);
                                       splats.set_rig(made.rig);
                                       if (hands) hands->set(to, loop.last().number);
                                   },
                                   [&loop, &scene](int nodes) {
                                       SurfaceOptions surface = loop.surface_options();
                                       surface.lattice =
                                           surface_lattice(scene.setup.lattice, nodes);
                                       loop.set_surface(surface);
                                   }},
                first, ids);
            frames_before = number;
            if (session)
                session->begin({scene, splats, loop, solver.editable(), *editor, session->steps()},
                               solver, beginnings, recording ? &*recording : nullptr);
        }
        if (!replay->due(number) && !editor->carries()) {
            if (session && number > frames_before) session->after_frame(loop.last());
            return;
        }
        if (number == frames) return after_last_frame(number, loop);
        // One that takes no edits has no frame in flight here, and commands may change names.
        if (solver.editable())
            loop.edit([this, number, &loop](EditableSimulator&) { after_frame(number, loop); });
        else
            after_frame(number, loop);
    };
}

void RunScript::after_frame(int number, SessionLoop& loop)
{
    editor->after_frame(loop.last());
    if (session && number > frames_before) session->after_frame(loop.last());
    play_entries(number, loop, [](const LogEntry&) { return true; });
}

// Results of the run are those of its last frame.
void RunScript::after_last_frame(int number, SessionLoop& loop)
{
    if (session && number > frames_before) session->after_frame(loop.last());
    play_entries(number, loop, [](const LogEntry& entry) {
        const Command* command = std::get_if<Command>(&entry.done);
        return command &&
               (std::holds_alternative<Save>(*command) ||
                std::holds_alternative<Export>(*command) || std::holds_alternative<Mark>(*command));
    });
}

void RunScript::play_entries(int number, SessionLoop& loop,
                             const std::function<bool(const LogEntry&)>& may)
{
    bool ended = false;  // by a refusal: the commands after it are not applied
    const auto refused = [&](const LogEntry& entry, const Refusal& why) {
        ended = entry.line && !keep_going;
        if (entry.line)
            return refuse(fmt::format("{}:{}: ", file, entry.line), std::get<Command>(entry.done),
                          why, &loop);
        std::fprintf(stderr, "knead: %s: refused after frame %ld: %s\n", beside.c_str(),
                     entry.frame, why.text().c_str());
    };
    const auto by_command = [this](const Command& command) { return apply(command); };
    const auto next = [&](const LogEntry& entry) { return !ended && may(entry); };
    replay->after_frame(number, *editor, {by_command, refused, next});
}

std::optional<Refusal> RunScript::apply(const Command& command)
{
    return session ? session->apply(command) : apply_in_run(*editor, command);
}

bool begin_with_hands(Scene& scene, const std::string& recording)
{
    for (const LogEntry& entry :
         recorded_beside(recording, scene.frame_rate, scene.origin).entries) {
        if (entry.frame > 0) return false;
        const Command* command = std::get_if<Command>(&entry.done);
        if (!command || !std::holds_alternative<SetHands>(*command)) continue;
        IdSource none;
        const auto document = std::make_shared<const Document>(document_of(scene));
        const auto result = reduce(document, *command, none);
        const DocumentPtr* with = std::get_if<DocumentPtr>(&result);
        if (!with) return false;
        scene.has_hands = true;
        scene.hands = hands_with(scene.hands, *(*with)->hands, scene.origin);
        return true;
    }
    return false;
}

}  // namespace knead
