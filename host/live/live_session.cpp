#include "host/live/live_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/paths.h"
#include "host/live/simulation_run.h"
#include "host/scene/domain.h"
#include "host/scene/new_scene.h"
#include "host/session/scene_export.h"
#include "host/solver/audit.h"

namespace knead {
namespace fs = std::filesystem;

float MotionStamp::extrapolation(double now) const
{
    return step > 0 ? float(std::clamp((now - time) / step, 0.0, 1.0)) : 0;
}
namespace {

constexpr std::size_t most_waiting = 1024;  // frames of hands
constexpr std::size_t most_tasks = 4096, most_applied = 100000;
// Catching up: largest backlog that is caught up [s]; by how much frames are due earlier meanwhile
// [periods]; largest frame time at which the session catches up [periods], because the device also
// renders.
constexpr double most_backlog = 0.5, earlier = 0.2, quick = 0.5;

std::string reason_of(const std::exception_ptr& failure)
{
    try {
        std::rethrow_exception(failure);
    } catch (const std::bad_alloc&) {
        return "out of memory";
    } catch (const std::exception& e) {
        return e.what();
    }
}

// Commands that discard the current frame.
bool cuts(const Command& command)
{
    return std::holds_alternative<Open>(command) || std::holds_alternative<Reset>(command) ||
           std::holds_alternative<SetLattice>(command);
}

// A user's file, as the beginning of a new working log.
SessionFile copied(const SessionFile& file)
{
    const std::string to = (fs::path(log_folder()) / (new_session().session + log_ending)).string();
    copy_chunks(file.chunks().path(), file.chunks().end(), {}, to);
    return SessionFile(to);
}

// Whether each value that the former command sets is set by the later one, too.
template <class C>
bool covers(const C& later, const C& former)
{
    bool all = true;
    for_each_field(former, [&](const auto& f, const auto& value) {
        using T = std::remove_cvref_t<decltype(value)>;
        const T& other = later.*(f.member);
        if constexpr (std::is_same_v<T, ObjectRef>)
            all = all && value.by == other.by;
        else if constexpr (std::is_same_v<T, SetHand>)
            all = all && covers(other, value);
        else if constexpr (requires { value.has_value(); })
            all = all && (other.has_value() || !value.has_value());
    });
    return all;
}

// Whether the later of two commands makes the former one needless: those that set values of the
// same object.
bool replaces(const Command& later, const Command& former)
{
    const CommandRow& row = row_of(former);
    if (row.receiver != Receiver::document || row.undo == UndoRule::step) return false;
    if (later.index() != former.index()) return false;
    return std::visit([&]<class C>(const C& one) { return covers(std::get<C>(later), one); },
                      former);
}

}  // namespace

LiveSession::LiveSession(std::shared_ptr<const LiveScene> of, LiveOptions by)
    : options(std::move(by)),
      epoch(wall_seconds()),
      scene(std::move(of)),
      paused(options.paused),
      waiting(options.manual_start)
{
    published.store(std::make_shared<const LiveState>());
    thread = std::thread([this] { run_thread(); });
}

LiveSession::~LiveSession()
{
    {
        const std::lock_guard lock(mutex);
        quit = true;
    }
    wake.notify_all();
    thread.join();
}

double LiveSession::now() const { return options.clock ? options.clock() : wall_seconds() - epoch; }

void LiveSession::push(const HandFrame& hands)
{
    const std::lock_guard lock(mutex);
    incoming.push_back(hands);
    if (incoming.size() > most_waiting) incoming.pop_front();
}

void LiveSession::post(std::function<void()> work)
{
    {
        const std::lock_guard lock(mutex);
        tasks.push_back(std::move(work));
        ++posted;
    }
    wake.notify_all();
}

// The order of serial numbers is that of the queue.
long LiveSession::send(Command command, Origin origin, unsigned drag)
{
    long number = 0;
    {
        const std::lock_guard lock(mutex);
        if (tasks.size() >= most_tasks) return 0;
        number = ++serial;
        if (cuts(command)) ++cut_requests;
        tasks.push_back(Issued{std::move(command), number, origin, drag});
        ++posted;
    }
    wake.notify_all();
    return number;
}

std::vector<AppliedCommand> LiveSession::take_applied()
{
    const std::lock_guard lock(mutex);
    return std::exchange(applied, {});
}

// Whether a later command of the same drag waits. Precondition: the mutex is held.
bool LiveSession::superseded(const Task& task) const
{
    const Issued* one = std::get_if<Issued>(&task);
    if (!one || one->drag == 0) return false;
    return std::ranges::any_of(tasks, [&](const Task& later) {
        const Issued* other = std::get_if<Issued>(&later);
        return other && other->drag == one->drag && other->origin == one->origin &&
               replaces(other->command, one->command);
    });
}

void LiveSession::execute(const Task& task)
{
    if (const Issued* issued = std::get_if<Issued>(&task)) return execute(*issued);
    try {
        std::get<1>(task)();
    } catch (...) {
        refuse(reason_of(std::current_exception()));
    }
}

void LiveSession::execute(const Issued& issued)
{
    if (cuts(issued.command)) --cut_requests;
    CommandAnswer answer;
    try {
        answer = apply(issued);
    } catch (...) {
        answer.refusal = Refusal{reason_of(std::current_exception()), ""};
    }
    answered = issued.serial;
    if (answer.refusal)
        return refuse(fmt::format("{}: {}", row_of(issued.command).label, answer.refusal->text()));
    AppliedCommand entry{history, run ? run->number() : 0, run ? run->now_at() : now(), issued};
    entry.issued.command = std::move(answer.applied);
    // Those of the document, and of steps, are recorded where they are applied.
    if (!SceneHistory::takes(issued.command)) record(CommandEvent{entry.issued});
    const std::lock_guard lock(mutex);
    if (applied.size() < most_applied) applied.push_back(std::move(entry));
}

// Commands of the session are applied here, those of the document and of steps by the simulation.
CommandAnswer LiveSession::apply(const Issued& issued)
{
    const Command& command = issued.command;
    std::future<PreparedObject> clay = std::move(preparing);  // of this command, even if refused
    Situation situation = run ? run->situation() : Situation{};
    situation.simulation = run != nullptr && failure.empty();
    if (writer) situation.no_save.clear();
    if (const std::string why = row_of(command).why_not(situation);
        !why.empty() && !std::holds_alternative<Reset>(command))
        return {Refusal{why, ""}, {}};
    const DocumentPtr document =
        run ? run->document() : std::make_shared<const Document>(Document{});
    const CommandAnswer answer{{}, command};
    if (SceneHistory::takes(command)) {
        if (!run) return {Refusal{"there is no simulation", ""}, {}};
        if (!clay.valid()) return run->apply(issued);
        PreparedObject ready = clay.get();
        return run->apply(issued, &ready);
    }
    if (const auto checked = reduce(document, command, ids);
        const Refusal* refusal_of = std::get_if<Refusal>(&checked))
        return {*refusal_of, {}};
    if (std::holds_alternative<SetLattice>(command) && !scene)
        return {Refusal{"there is no simulation", ""}, {}};
    if (const Open* open = std::get_if<Open>(&command)) {
        if (is_session(open->file))
            open_session(open->file);
        else
            begin_file(open->file, open->settings, open->cells.value_or(0));
    } else if (const Save* to = std::get_if<Save>(&command)) {
        return {save(*to), command};
    } else if (const Export* one = std::get_if<Export>(&command)) {
        return {start_export(*one), with_ids(*document, command)};
    } else if (const SetLattice* lattice = std::get_if<SetLattice>(&command)) {
        begin_file(scene->scene.path, scene->settings, lattice->cells);
    } else if (std::holds_alternative<Reset>(command)) {
        if (run && failure.empty()) run->close_step();
        record(RunBegun{});
        make_run(row_of(command).label);
    } else if (const Pause* pause = std::get_if<Pause>(&command)) {
        paused = pause->on;
        next = now();
        if (paused && run && failure.empty()) run->make_surface();
    } else if (const Advance* advance = std::get_if<Advance>(&command)) {
        steps += advance->frames;
    } else if (const Play* play = std::get_if<Play>(&command)) {
        if (run) run->play(play->recorded);
    }
    return answer;
}

void LiveSession::wait_for_commands()
{
    std::unique_lock lock(mutex);
    const long ticket = posted;
    done.wait(lock, [&] { return finished >= ticket || quit; });
}

void LiveSession::run_thread()
{
    try {
        if (options.session.empty())
            begin(scene);
        else
            open_session(options.session);
    } catch (...) {
        failure = reason_of(std::current_exception());
        const std::lock_guard held(mutex);
        unopened = std::current_exception();
    }
    publish();
    std::unique_lock lock(mutex);
    ++finished;
    done.notify_all();
    while (!quit) {
        if (may_execute()) {
            const Task task = std::move(tasks.front());
            tasks.pop_front();
            if (superseded(task)) {
                ++finished;
                continue;
            }
            lock.unlock();
            execute(task);
            publish();
            lock.lock();
            ++finished;
            done.notify_all();
        } else if (wait_for_work(lock)) {
            lock.unlock();
            frame();
            publish();
            lock.lock();
        }
    }
    finished = posted;  // releases callers of wait_for_commands()
    tasks.clear();
    done.notify_all();
    lock.unlock();
    preparing = {}, hashing = {}, exporting = {};  // wait
    end_log();
    run.reset();  // on the thread that made it
}

// Whether the command at the head of the queue can be applied. Clay of a new object is prepared on
// another thread while frames go on; other commands wait behind it. Not in stepped time, where the
// frame after which a command is applied must not depend on the clock.
bool LiveSession::may_execute()
{
    using namespace std::chrono_literals;
    if (tasks.empty()) return false;
    const Issued* issued = std::get_if<Issued>(&tasks.front());
    const AddObject* adds = issued ? std::get_if<AddObject>(&issued->command) : nullptr;
    if (!adds || !run || !failure.empty() || options.stepped || !run->situation().editable)
        return true;
    if (!preparing.valid()) {
        IdSource unused = ids;
        if (std::holds_alternative<Refusal>(reduce(run->document(), issued->command, unused)))
            return true;
        preparing = run->prepare(*adds);
    }
    return preparing.wait_for(0s) == std::future_status::ready;
}

// Returns whether a frame is due; if not, waits at most 5 ms for one, or for a command.
bool LiveSession::wait_for_work(std::unique_lock<std::mutex>& lock)
{
    const bool going = run && failure.empty();
    if (going && steps > 0) return true;
    if (preparing.valid() && (!going || paused || waiting)) {
        wake.wait_for(lock, std::chrono::milliseconds(1));
        return false;
    }
    if (!going || paused || waiting || options.stepped || stopped()) {
        wake.wait(lock, [&] { return quit || !tasks.empty(); });
        return false;
    }
    const double left = next - now();
    if (left <= 1e-9) return true;  // sums of periods are rounded
    wake.wait_for(lock, std::chrono::duration<double>(std::clamp(left, 1e-4, 5e-3)));
    return false;
}

// Another scene: another session.
void LiveSession::begin(std::shared_ptr<const LiveScene> of)
{
    end_log();
    past = History(options.history);
    step_list.reset(), saved_as.clear();
    frames = 0;
    scene = std::move(of);
    make_run("");
    begin_log();
}

// The scene from its beginning. The session's past goes on.
void LiveSession::make_run(const std::string& step)
{
    preparing = {}, hashing = {};  // wait: they use the run
    run.reset();                   // before the new one: two may not fit into memory
    failure.clear();
    backlog = dropped = 0;
    ++history;
    if (options.restarts_time) stepped_to = 0;
    if (!scene) return;
    try {
        run = std::make_unique<SimulationRun>(
            scene, options, ids, past, run_log(step), options.stepped ? stepped_to : now(),
            [this] { return now(); },
            [this](const FrameProgress&) {
                return quit || cut_requests > 0 || stopping.cuts(stopped());
            });
        if (!waiting) run->rehearse();
        run->make_surface();
    } catch (...) {
        failure = reason_of(std::current_exception());
    }
    next = stored = now();  // the time to create the solver is not backlog
}

RunLog LiveSession::run_log(const std::string& step_label)
{
    RunLog log;
    log.step_label = step_label;
    log.event = [this](const SessionEvent& event) { record(event); };
    log.hands = [this](const HandFrame& hands) {
        if (writer) writer->add_hands(hands);
    };
    log.step = [this](const HistoryStep& step, const FutureCapture& made) {
        if (writer) writer->add_step(step, made);
    };
    return log;
}

void LiveSession::record(const SessionEvent& event)
{
    frames += std::holds_alternative<FrameEvent>(event);
    if (options.logs) events.events.push_back(event);
    if (writer) writer->add(event);
}

// The log of a session that cannot be written is left out; the state says so.
void LiveSession::begin_log()
{
    events = {scene, {}};
    if (options.logs) events.events.push_back(RunBegun{});
    if (!options.protects || !run || !failure.empty()) return;
    try {
        SessionMeta meta = new_session();
        meta.device = run->of().name(), meta.stepped = options.stepped;
        meta.deterministic = !run->of().clay() || scene->scene.setup.deterministic;
        writer = std::make_unique<SessionWriter>(
            meta, SceneSource{scene->scene.path, scene->text, scene->settings});
        writer->add(RunBegun{});
        if (past.count() > 0) writer->add_beginning(past.current(), past.resident());
    } catch (const std::exception& e) {
        refuse(fmt::format("the session is not protected: {}", e.what()));
    }
}

// A log without unsaved steps is not missed.
void LiveSession::end_log()
{
    if (!writer) return;
    try {
        if (run && failure.empty()) run->close_step();
    } catch (const std::exception&) {  // what is lost is the open step
    }
    if (!writer->changed()) writer->discard();
    writer.reset();
}

// Reads the whole file before the current scene is replaced.
void LiveSession::open_session(const std::string& name)
{
    const bool is_log = ending(name) == log_ending;
    const SessionFile file = session_to_continue(name);
    const std::shared_ptr<const LiveScene> of =
        live_scene_of(file.scene(), nullptr, options.memory);
    std::optional<StoredState> state;
    if (file.final_state()) state = file.state(file.final_state());
    History steps_of_file(options.history);
    file.read_history(steps_of_file, file.current());
    std::unique_ptr<SessionWriter> log;
    if (options.protects) log = std::make_unique<SessionWriter>(is_log ? file : copied(file));
    end_log();
    past = std::move(steps_of_file);
    step_list.reset();
    const bool without_past = past.count() == 0;
    ids.use({file.object_ids()});
    for (const StepInfo& step : past.list())
        for (const auto& object : past.find(step.id)->document->objects) ids.use(object->id);
    saved_as = is_log ? file.saved_as() : fs::absolute(name).string();
    if (file.run_record()) saved_as.clear();  // a run goes on with the file
    scene = of;
    events = {scene, {}};
    writer = std::move(log);
    frames = file.frames();
    const StepId at = past.count() > 0 ? past.current().id : 0;
    record(RunBegun{file.final_state(), nullptr});
    make_run("");
    if (!run || !failure.empty()) return;
    if (state) {
        run->go_on(*state);
        if (without_past) begin_past();
    } else if (!without_past) {
        run->go_on(at);
    } else if (writer && past.count() > 0) {  // killed before its beginning was committed
        writer->add_beginning(past.current(), past.resident());
    }
    run->play(false);  // recorded hands would begin again
    // Of a log the end is missing after a crash. The file is not replaced by what is left of it.
    if (const std::string& broken = file.chunks().broken_by(); !is_log && !broken.empty()) {
        saved_as.clear();
        refuse(fmt::format("{}: the file is damaged behind its first {} step{}: {}", name,
                           past.count(), past.count() == 1 ? "" : "s", broken));
    }
}

// With the state that a checkpoint has, not with the scene's beginning.
void LiveSession::begin_past()
{
    run->begin_past();
    if (writer && past.count() > 0) writer->add_beginning(past.current(), past.resident());
}

std::optional<Refusal> LiveSession::save(const Save& command)
{
    if (!writer || !run) return Refusal{"this session keeps no log", ""};
    if (auto why_not = refusal_of(command)) return why_not;
    run->close_step();
    const std::string to = fs::absolute(command.file).string();
    // On the log's thread: frames go on.
    const auto written = [this, to](const std::string& why) {
        post([this, to, why] {
            if (why.empty())
                saved_as = to;
            else
                refuse("Save: " + why);
        });
    };
    writer->save(to, command.input.value_or(true), past.count() > 0 ? past.current().id : 0,
                 run->stored_state(frames), written);
    return {};
}

// Of the published state, on another thread: frames go on. One file after the other.
std::optional<Refusal> LiveSession::start_export(const Export& command)
{
    constexpr int most = 4;  // each holds a state
    if (exports_waiting >= most) return Refusal{"the exports before it are not written yet", ""};
    const auto plan = export_plan(*run->document(), command);
    if (const Refusal* why_not = std::get_if<Refusal>(&plan)) return *why_not;
    const std::string to = fs::absolute(command.file).string();
    ShownScene shown = run->shown(published.load());
    exporting = std::async(std::launch::async,
                           [this, before = std::move(exporting), plan = std::get<ExportPlan>(plan),
                            shown = std::move(shown), to]() mutable {
                               if (before.valid()) before.wait();
                               before = {};
                               std::string why;
                               try {
                                   write_export(to, plan, shown);
                               } catch (...) {
                                   why = reason_of(std::current_exception());
                               }
                               shown = {};  // releases the state
                               post([this, to, why] { end_export(to, why); });
                           });
    ++exports_waiting;
    return {};
}

void LiveSession::end_export(const std::string& file, const std::string& why)
{
    --exports_waiting;
    if (!why.empty()) return refuse(fmt::format("{}: {}", Row<Export>::row.label, why));
    exported = file, ++exports;
}

// Of each 60th frame, on another thread: a replay compares it.
void LiveSession::hash_state()
{
    using namespace std::chrono_literals;
    constexpr long every = 60;
    if (hashing.valid() && hashing.wait_for(0s) == std::future_status::ready) record(hashing.get());
    if (!writer && !options.logs) return;
    const EditableSimulator* of = run->of().editable();
    if (!of || hashing.valid() || frames % every != 0) return;
    hashing = std::async(std::launch::async, [of, then = of->snapshot(), at = frames] {
        return HashEvent{at, hash(of->rows(*then))};
    });
}

void LiveSession::wait_until_open()
{
    std::unique_lock lock(mutex);
    done.wait(lock, [&] { return finished >= 1 || quit; });
    if (!options.session.empty() && unopened) std::rethrow_exception(unopened);
}

void LiveSession::set_picture(std::string png)
{
    post([this, png = std::move(png)] {
        if (writer) writer->set_picture(png);
    });
}

void LiveSession::rehearse()
{
    post([this] {
        if (!run || !failure.empty()) return;
        try {
            run->rehearse();
            run->make_surface();
        } catch (...) {
            failure = reason_of(std::current_exception());
        }
    });
}

void LiveSession::start()
{
    post([this] { waiting = false, next = now(); });
}

void LiveSession::frame()
{
    {
        const std::lock_guard lock(mutex);
        for (const HandFrame& hands : incoming) run->push(hands);
        incoming.clear();
    }
    const bool single = steps > 0;
    if (single) --steps;
    const double began = now();
    try {
        failure = run->frame(single);
    } catch (...) {
        failure = reason_of(std::current_exception());
    }
    if (failure.empty()) hash_state();
    if (writer) {
        constexpr double state_every = 60;  // [s]
        if (failure.empty() && now() - stored > state_every) {
            stored = now();
            writer->add_state(run->stored_state(frames), run->stored_bytes());
        }
        writer->poll();
    }
    if (!single && !options.stepped) schedule(now() - began);
}

// Schedules the next frame after one that took `took` [s]. If several are overdue, one is computed
// at once; the others go to the backlog.
void LiveSession::schedule(double took)
{
    const double period = run->period(), before = now() - period;
    const double gained = took < quick * period ? std::min(backlog, earlier * period) : 0;
    backlog -= gained;
    next += period - gained;
    if (next >= before) return;
    backlog += before - next;
    next = before;
    if (backlog <= most_backlog) return;
    dropped += backlog - most_backlog;
    backlog = most_backlog;
}

void LiveSession::publish()
{
    auto state = std::make_shared<LiveState>();
    try {
        if (run) run->publish(*state);
    } catch (...) {
        if (failure.empty()) failure = reason_of(std::current_exception());
    }
    state->scene = scene;
    state->history = history;
    state->version = ++version;
    state->paused = paused;
    if (run)
        state->backlog.missing_time =
            run->lost() + (backlog + dropped) / run->period() * run->simulated_period();
    state->failure = failure;
    state->answered = answered;
    state->refused = refused;
    state->refusal = refusal;
    if (run) {
        state->situation = run->situation();
        state->situation.document = state->document.get();
        if (past.count() > 0) publish_steps(*state);
    }
    state->situation.simulation = run && failure.empty();
    if (writer) {
        state->situation.no_save.clear();
        state->log = writer->state();
        const bool open = past.count() > 0 && !past.current().captured;
        state->unsaved = writer->changed() || open;
    }
    state->saved_as = saved_as;
    state->exported = exported, state->exports = exports;
    published.store(std::move(state));
    if (options.published) options.published();
}

// The list is made anew when steps have begun, ended or moved.
void LiveSession::publish_steps(LiveState& state)
{
    if (!step_list || steps_version != past.version()) {
        step_list = std::make_shared<const std::vector<StepInfo>>(past.list());
        steps_version = past.version();
    }
    state.steps = step_list;
    state.history_bytes = past.bytes();
}

void LiveSession::refuse(const std::string& why)
{
    ++refused;
    refusal = why;
}

// Strong guarantee: if the file cannot be read, the current scene is kept.
void LiveSession::begin_file(const std::string& path, const std::vector<std::string>& settings,
                             int cells)
{
    std::vector<std::string> wanted = settings, left_out;
    if (cells > 0) wanted.push_back(cells_setting(parse_json(scene_text(path), path), cells));
    wanted = fitting_settings(path, wanted, left_out);
    begin(load_live_scene(path, wanted, options.memory));
    if (!left_out.empty())
        refuse(fmt::format("{} does not take --set {}: left out", path,
                           fmt::join(left_out, ", --set ")));
}

bool LiveSession::inspect_solver(const std::function<void(const Simulator&)>& inspect)
{
    bool seen = false;
    post([this, &inspect, &seen] {
        if (!run) return;
        inspect(run->of());
        seen = true;
    });
    wait_for_commands();
    return seen;
}

SessionLog LiveSession::session_log()
{
    SessionLog log;
    post([this, &log] { log = events; });
    wait_for_commands();
    return log;
}

ClayDigest LiveSession::digest()
{
    ClayDigest found;
    inspect_solver([&](const Simulator& solver) {
        const EditableSimulator* edited = solver.editable();
        const SimulationConfig& config = edited ? edited->config() : scene->scene.setup;
        const std::vector<Particle<double>> particles = solver.particles();
        found.hash = hexadecimal(audit(particles, config.materials, config.lattice.dx).hash);
        found.particles = long(particles.size());
    });
    return found;
}

void LiveSession::request_object_places()
{
    if (finding_places.exchange(true)) return;
    post([this] {
        const double begin = wall_seconds();
        ObjectPlaces found;
        try {
            if (run) found = run->places();
        } catch (const std::exception&) {  // out of memory: as without objects
        }
        found.history = history, found.frame = run ? run->number() : 0;
        found.took = wall_seconds() - begin;
        found_places = std::make_shared<const ObjectPlaces>(std::move(found));
        finding_places = false;
    });
}

std::shared_ptr<const ObjectPlaces> LiveSession::object_places()
{
    finding_places = false;  // one that is under way may be older than the last command
    request_object_places();
    wait_for_commands();
    const auto found = latest_object_places();
    return found ? found : std::make_shared<const ObjectPlaces>();
}

void LiveSession::advance_to(double time)
{
    if (!options.stepped) throw std::logic_error("advance_to() of a session in real time");
    post([this, time] {
        constexpr double rounding = 1e-9;  // [s]
        while (run && failure.empty() && (!paused || steps > 0) && !quit && !stopped() &&
               run->next_end() <= time + rounding) {
            frame();
            publish();
        }
        if (run && paused) run->skip_to(time);
        stepped_to = std::max(stepped_to, time);
    });
    wait_for_commands();
}

}  // namespace knead
