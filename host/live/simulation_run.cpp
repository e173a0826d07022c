#include "host/live/simulation_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>

#include "host/base/errors.h"
#include "host/hands/motion.h"
#include "host/scene/soften.h"
#include "render/tool_primitives.h"

namespace knead {

SimulationRun::SimulationRun(std::shared_ptr<const LiveScene> of, const LiveOptions& by,
                             IdSource& ids_of, History& past_of, RunLog recorder, double start,
                             std::function<double()> clock, StopCheck should_cut,
                             RunReplay* replay_of)
    : scene(std::move(of)),
      options(by),
      now(std::move(clock)),
      solver(options.make_solver(scene->scene.setup)),
      editable(solver->editable()),
      splats(scene->scene, scene->splats),
      past(past_of),
      ids(ids_of),
      log(std::move(recorder)),
      replaying(replay_of),
      hands(scene->scene.hands),
      tools{scene->scene.setup.rig, scene->scene.setup.tools},
      stream(hands),
      recorded(options.recorded && scene->recording),
      clock_offset(start),
      time(start),
      particles(scene->scene.setup.particles.size())
{
    if (splats.local() && !editable)
        throw std::invalid_argument(solver->name() + " has no local clay");
    if (splats.drawn().count() > 0) drawn = splats.picture();
    make_sources();
    SessionLoopOptions loop_by = loop_options(scene->scene);
    loop_by.surface.moving = options.with_motion;
    loop_by.most_substeps = scene->scene.most_substeps;
    loop_by.interrupted = [] { return false; };
    const double budget = options.stepped ? 0 : options.budget > 0 ? options.budget : period();
    loop_by.should_cut = [this, should_cut, budget](const FrameProgress& done) {
        return should_cut(done) || (budget > 0 && now() - began > budget);
    };
    splats.decide_by([this](bool ready) { return takes(ready); });
    loop = std::make_unique<SessionLoop>(
        *solver, [this](double from, double to) { return motion(from, to); }, loop_by);
    editor = std::make_unique<SceneEditor>(
        SceneEditor::Parts{scene->scene, splats, *loop, editable,
                           [this](const HandsOptions& to) { set_hands(to); },
                           [this](int nodes) { set_surface(nodes); }},
        std::make_shared<const Document>(document_of(scene->scene)), ids);
    history = std::make_unique<SceneHistory>(
        SceneHistory::Parts{scene->scene, splats, *loop, editable, *editor, past, log.event,
                            log.step, options.codec},
        log.step_label,
        !replaying                ? StepSource::rule
        : replaying->stored_steps ? StepSource::stored
                                  : StepSource::events);
    loop->observe([this](const FrameResult& frame) { after(frame); });
    if (options.on_device) loop->launch_surfaces(true);
}

// Without the warm-up the first frames and the first activation of local clay take some tenths of a
// second each: memory is touched, surfaces and graphs are created, kernels are loaded. The state is
// restored afterwards.
void SimulationRun::rehearse()
{
    if (options.stepped || !editable) return;
    if (particles > 0) rehearse_frames(far_away(no_motion()));
    if (splats.rehearse(*editable, [this](const Motion& away) { rehearse_frames(away); })) {
        clay_changed(), splats_changed();
        particles = scene->scene.setup.particles.size();
    }
    meshed = -1;
    mesh_stamp = gaussian_stamp = {};
    published = {};
}

// The GPU captures one graph each for frames without tools, with slow and with fast tools, and
// recaptures them once the number of substeps of a full frame is known. On the CPU two very short
// frames suffice. The Gaussians of all these frames are kept, as many snapshots as a renderer
// keeps.
void SimulationRun::rehearse_frames(const Motion& away)
{
    const bool on_gpu = solver->clay() != nullptr;
    std::vector<Motion> frames(on_gpu ? 5 : 2, away);
    for (std::size_t k = 0; k < frames.size(); ++k)
        frames[k].active.assign(tools.tools.size(), k > 0);
    const Vec3<double> swift{4 * scene->scene.setup.lattice.dx, 0, 0};
    if (on_gpu)
        for (Joint<double>& j : frames.back().to) j.p = j.p + swift;
    std::vector<std::shared_ptr<const DeviceGaussians>> held;
    const auto meanwhile = [&] {
        const gpu::MovedGaussians* moved = options.on_device ? solver->moved_gaussians() : nullptr;
        if (drawn && moved) held.push_back(gaussians.kept(*moved, true));
    };
    clay_changed();
    loop->rehearse(frames, (on_gpu ? 1 : 1e-6) * simulated_period(), meanwhile);
    meshed = -1;
    make_surface();
    if (drawn) follow_gaussians();
}

void SimulationRun::make_sources()
{
    stream = HandStream(hands);
    if (scene->recording) source = std::make_unique<HandSource>(*scene->recording, hands);
    replay = recorded_motion(source.get(), hands);
    last_valid = false;
}

void SimulationRun::push(const HandFrame& frame)
{
    stream.push(frame);
    if (log.hands) log.hands(frame);
}

void SimulationRun::record(const SessionEvent& event) const
{
    if (log.event) log.event(event);
}

// Whether the result of a background task is taken now.
bool SimulationRun::takes(bool ready)
{
    bool now_taken = options.take_background ? options.take_background(ready) : ready;
    if (replaying) {
        if (replaying->taken == replaying->frame.taken.size())
            throw std::runtime_error("a background task that the log does not have");
        now_taken = replaying->frame.taken[replaying->taken++];
    }
    taken.push_back(now_taken);
    return now_taken;
}

Motion SimulationRun::motion(double from, double to)
{
    if (replaying) return replaying->frame.motion;
    given = own_motion(from, to);
    history->release_tools(given);
    return given;
}

Motion SimulationRun::own_motion(double from, double to)
{
    if (recorded) return replay(from - replayed, to - replayed);
    return pushed(from, to);
}

// Each frame begins at the tool positions at which the previous one ended.
Motion SimulationRun::pushed(double from, double to)
{
    Motion m = no_motion();
    const double until = options.stepped ? to + clock_offset : now();
    float size[side_count], before[side_count];
    stream.sample(until, m.to.data(), size);
    if (last_valid)
        m.from = last.to;
    else
        stream.sample(options.stepped ? from + clock_offset : until, m.from.data(), before);
    for (Side side : tool_sides(hands))
        m.active.push_back(size[side] > 0), m.size.push_back(size[side]);
    m.stretch = stretches(hands, [&](Side side) { return stream.stretch(until, side); });
    if (!options.stepped) limit_tool_speed(m);
    stream.forget(until - 1);
    return m;
}

// If the simulation lags, hands move faster in simulated time than in real time. Active tools are
// limited to LiveOptions::max_tool_speed; inactive tools follow their hand at once.
void SimulationRun::limit_tool_speed(Motion& m) const
{
    const std::vector<Side> sides = tool_sides(hands);
    const double reach = options.max_tool_speed * hands.zoom * simulated_period();
    for (std::size_t tool = 0; tool < sides.size(); ++tool) {
        const std::size_t first = std::size_t(int(sides[tool]) * joint_count);
        const bool touched = last_valid && tool < last.active.size() && last.active[tool];
        double far = 0;
        for (std::size_t j = first; j < first + joint_count; ++j) {
            if (!touched) m.from[j] = m.to[j];
            far = std::max(far, length(m.to[j].p - m.from[j].p));
        }
        if (!(options.max_tool_speed > 0) || far <= reach) continue;
        for (std::size_t j = first; j < first + joint_count; ++j)
            m.to[j] = between(m.from[j], m.to[j], reach / far);
    }
}

void SimulationRun::after(const FrameResult& frame)
{
    last = frame.motion;
    last_valid = true;
    time = options.stepped ? frame.hand_time + clock_offset : now();
    if (state_invalid(frame.stats, particles)) {
        failure = fmt::format("frame {}: {} particles had to be reset", frame.number,
                              frame.stats[Count::repaired]);
        loop->stop(End::numerical_failure);
    } else {
        if (splats.changes() && editable) keep_splats(frame);
        const long before = editor->edits();
        editor->after_frame(frame);
        if (editor->edits() != before) ++edits;
    }
    record_frame();
    if (history->after_frame(frame)) {
        ++edits;
        splats_changed();
        particles = std::max(particles, solver->particle_count());
        meshed = -1;  // the frame's surface is made after this
    }
    if (!frame.stats.cut) return;
    const double left = simulated_period() - frame.stats.reached;
    ++cut;
    lost_time += left;
    replayed += left / simulated_period() * period();  // delays recorded hands
}

// Stepped: as after a frame of `knead run`. In real time, upkeep, which visits all splats and
// particles and takes as long as some frames, runs on a thread; only local clay is activated
// immediately.
void SimulationRun::keep_splats(const FrameResult& frame)
{
    PagingReport report;
    if (options.stepped) {
        report = splats.after(frame.number, frame.motion, *editable);
    } else {
        adopt_plan(report);
        splats.follow_hands(frame.motion, report, *editable);
    }
    if (report.clay_changed()) clay_changed();
    if (report.any()) splats_changed();
    if (options.stepped) return;
    if (report.cubes_activated == 0)  // freezing is not urgent
        splats.begin_freezing(frame.number, frame.motion, *editable);
    begin_plan(frame.number);
}

void SimulationRun::clay_changed()
{
    ++edits;
    loop->clay_edited();
    particles = std::max(particles, solver->particle_count());
}

void SimulationRun::splats_changed()
{
    splats.refresh();
    drawn = splats.picture();
    ++splat_version;
}

// A plan made before an edit is discarded.
void SimulationRun::adopt_plan(PagingReport& report)
{
    using namespace std::chrono_literals;
    if (splats.freezing()) return;
    if (!plan.valid() || !takes(plan.wait_for(0s) == std::future_status::ready)) return;
    UpkeepPlan made = plan.get();
    if (edits == planned_edits) splats.adopt(std::move(made), report, *editable);
}

void SimulationRun::begin_plan(int frame)
{
    if (plan.valid() || splats.freezing() || !splats.upkeep().due(frame)) return;
    planned_edits = edits;
    plan = std::async(std::launch::async,
                      [of = editable, then = editable->snapshot(), task = splats.upkeep().task(),
                       config = editable->config()] { return task.plan(of->held(*then), config); });
}

std::string SimulationRun::frame(bool shown)
{
    began = now();
    taken.clear();
    const bool going = loop->step();
    if (!failure.empty()) return failure;
    if (loop->failure()) std::rethrow_exception(loop->failure());
    if (!going || loop->end() != End::complete)
        return fmt::format("frame {}: not done after {} substeps (step.most_substeps)",
                           loop->last().number, loop->last().stats.substeps);
    // On the CPU a surface costs as much as many substeps: surfaces get at most half of the time.
    const bool due = options.stepped || solver->clay() || now() - mesh_made >= mesh_cost;
    if (!replaying && (due || shown)) make_surface();
    return {};
}

void SimulationRun::make_surface()
{
    const int number = loop->last().number;
    if (meshed == number) return;
    const double start = now();
    const long before = mesh_version;
    if (options.on_device && solver->clay()) {
        const auto made = loop->device_mesh();
        if (made != on_device) on_device = made, ++mesh_version;
    } else {
        const Meshes made = loop->meshes();
        if (made != meshes) meshes = made, ++mesh_version;
    }
    mesh_stamp = stamp_after(mesh_stamp);
    if (mesh_version == before) mesh_stamp.step = 0;  // unchanged: nothing to extrapolate
    meshed = number;
    mesh_made = now();
    mesh_cost = mesh_made - start;
}

// In real time the tools of a frame have the hand positions at its beginning.
MotionStamp SimulationRun::stamp_after(const MotionStamp& before) const
{
    const double at = options.stepped ? time : began;
    return {at, before.time > 0 ? at - before.time : 0};
}

double SimulationRun::next_end() const
{
    return (loop->last().number + 1) * period() + clock_offset;
}

void SimulationRun::skip_to(double to)
{
    const double offset = to - loop->last().number * period();
    if (offset <= clock_offset + 1e-9) return;  // sums of periods are rounded
    clock_offset = offset;
    last_valid = false;
}

// Called by the editor, after its other edits.
void SimulationRun::set_hands(const HandsOptions& by)
{
    HandTools made = hand_tools(by);
    editable->set_tools(made.rig, made.tools);
    splats.set_rig(made.rig);
    tools = std::move(made);
    const bool alike = move_alike(by, hands);
    hands = by;
    if (!alike) make_sources();
}

void SimulationRun::play(bool on)
{
    if (on && !source) throw std::invalid_argument("the scene has no recorded hands");
    recorded = on;
    replayed = loop->last().number * period();
    last_valid = false;
}

// The new object leaves room for the clay as it is now: in the milliseconds until it is added, clay
// moves little.
std::future<PreparedObject> SimulationRun::prepare(const AddObject& command)
{
    record(PreparationEvent{command});
    return std::async(std::launch::async,
                      [of = scene, walls = editable->config().walls, object = command.object,
                       simulator = editable, then = editable->snapshot()] {
                          PreparedObject made = prepared(of->scene, walls, object);
                          const Box3<double> box = surroundings(made);
                          std::vector<Vec3<double>> there;
                          for (const Particle<double>& p : simulator->held(*then).particles)
                              if (contains(box, p.x)) there.push_back(p.x);
                          leave_room(made, there);
                          return made;
                      });
}

CommandAnswer SimulationRun::apply(const Issued& issued, PreparedObject* ready)
{
    if (prepared_again && !ready) ready = &*prepared_again;
    if (editable && splats.finish_freezing(*editable)) clay_changed(), splats_changed();
    const long before = editor->edits(), clay_before = editor->clay_edits();
    const std::size_t splats_before = splats.state().count();
    CommandAnswer answer = history->apply(issued, ready);
    prepared_again.reset();
    if (editor->edits() != before) ++edits;
    const bool restored = std::holds_alternative<Undo>(issued.command) ||
                          std::holds_alternative<Redo>(issued.command) ||
                          std::holds_alternative<GoTo>(issued.command);
    if (splats.state().count() != splats_before || (restored && splats_before > 0))
        splats_changed();
    if (editor->clay_edits() == clay_before) return answer;
    clay_replaced();
    return answer;
}

void SimulationRun::clay_replaced()
{
    particles = std::max(particles, solver->particle_count());
    meshed = -1;
    if (!replaying) make_surface();
}

void SimulationRun::record_frame()
{
    if (!log.event) return;
    const FrameResult& f = loop->last();
    const bool was_cut = f.stats.cut;
    record(FrameEvent{time, was_cut ? f.stats.reached : simulated_period(),
                      was_cut ? f.stats.substeps : 0, taken, given});
}

void SimulationRun::replay_event(const SessionEvent& event)
{
    if (const auto* preparation = std::get_if<PreparationEvent>(&event)) {
        prepared_again = prepare(preparation->command).get();
    } else if (const StepBegun* begun = std::get_if<StepBegun>(&event)) {
        history->begin_step(*begun);
    } else if (const StepCaptured* captured = std::get_if<StepCaptured>(&event)) {
        history->capture_step(*captured);
    } else if (const StepRestored* restored = std::get_if<StepRestored>(&event)) {
        go_on(restored->id);
    }
}

std::size_t SimulationRun::stored_bytes() const
{
    return 100 * (solver->particle_count() + splats.state().count());
}

std::function<StoredState()> SimulationRun::stored_state(long frames) const
{
    if (!editable) throw std::invalid_argument(solver->name() + " cannot be saved");
    StoredState now_at = editor->stored();
    now_at.frames = frames, now_at.time = time;
    const auto later = std::make_shared<LaterState>();
    later->make = [of = editable, then = editable->snapshot(), rest = std::move(now_at)] {
        StoredState all = rest;
        all.state = of->saved(*then);
        return all;
    };
    std::erase_if(later_states, [](const auto& one) { return one.expired(); });
    later_states.push_back(later);
    return [later] { return later->get(); };
}

StoredState SimulationRun::LaterState::get()
{
    const std::lock_guard lock(mutex);
    return made ? *made : make();
}

void SimulationRun::LaterState::read()
{
    const std::lock_guard lock(mutex);
    try {
        made = make(), make = {};
    } catch (...) {
        make = [why = std::current_exception()]() -> StoredState { std::rethrow_exception(why); };
    }
}

// The published Gaussians on a device do not name their objects: they are read from a snapshot.
ShownScene SimulationRun::shown(std::shared_ptr<const LiveState> state)
{
    ShownScene all;
    all.document = document(), all.origin = scene->scene.origin;
    all.numbers = editor->numbers().number;
    all.splats = state->splats;
    if (state->gaussians_on_device && editable) {
        if (read.valid()) read.wait();
        read =
            std::async(std::launch::async, [of = editable, then = editable->snapshot()]() mutable {
                SnapshotData data = of->held(*then);
                then.reset();  // before the simulator
                return std::move(data.gaussians);
            }).share();
        all.gaussians = [made = read] { return made.get(); };
    } else if (state->gaussians) {
        all.gaussians = [state] { return *state->gaussians; };
    }
    all.surface = [state = std::move(state)] { return meshes_of(*state); };
    return all;
}

SimulationRun::~SimulationRun()
{
    if (read.valid()) read.wait();
    for (const std::weak_ptr<LaterState>& one : later_states)
        if (const std::shared_ptr<LaterState> later = one.lock()) later->read();
}

void SimulationRun::go_on(const StoredState& from)
{
    if (!editable) throw std::invalid_argument(solver->name() + " cannot be loaded");
    if (splats.finish_freezing(*editable)) clay_changed(), splats_changed();
    editor->load(from);
    history->state_loaded();
    ids.use({from.ids_used});
    ++edits, splats_changed();
    clay_replaced();
}

void SimulationRun::go_on(StepId step)
{
    history->restore_step(step);
    ++edits;
    if (splats.state().count() > 0 || drawn) splats_changed();
    clay_replaced();
}

void SimulationRun::set_surface(int nodes)
{
    SurfaceOptions to = loop->surface_options();
    to.lattice = surface_lattice(scene->scene.setup.lattice, nodes);
    loop->set_surface(to);
    meshed = -1;
    make_surface();
}

void SimulationRun::publish(LiveState& state)
{
    state.scene = scene;
    state.time = time;
    state.frame = loop->last();
    if (!solver->clay()) state.stages = stage_times(*solver);
    state.meshes = meshes, state.on_device = on_device;
    state.mesh_version = mesh_version, state.mesh_stamp = mesh_stamp;
    state.surface = loop->surface_options();
    if (drawn) publish_gaussians(state);
    state.splats = drawn;
    state.splat_version = splat_version;
    const std::vector<Side> sides = tool_sides(hands);
    for (std::size_t tool = 0; tool < tools.tools.size() && tool < sides.size(); ++tool) {
        const bool active = tool < last.active.size() && last.active[tool];
        const float size = tool < last.size.size() ? last.size[tool] : 0;
        state.tools.push_back({sides[tool], hands.held[sides[tool]], active, size,
                               draw_primitives(tools.rig, last, int(tool))});
    }
    state.hands = hands;
    state.document = editor->document();
    state.source = editor->source();
    state.recorded = recorded;
    state.recording_time = loop->last().number * period() - replayed;
    state.backlog.frames = cut;
    state.solver = solver->name();
}

void SimulationRun::publish_gaussians(LiveState& state)
{
    follow_gaussians();
    state.gaussians = published.host, state.gaussians_before = published.before;
    state.gaussians_on_device = published.device;
    state.gaussian_stamp = gaussian_stamp;
}

// A state between frames reuses the Gaussians of the previous state, unless they were edited.
void SimulationRun::follow_gaussians()
{
    const int number = loop->last().number;
    const bool same = published.edits == edits && published.version == splat_version;
    if (same && published.frame == number) return;
    const gpu::MovedGaussians* moved = options.on_device ? solver->moved_gaussians() : nullptr;
    published.before = same ? published.host : nullptr;
    published.host.reset(), published.device.reset();
    if (moved)
        published.device = gaussians.kept(*moved, same);
    else
        published.host = std::make_shared<const std::vector<Gaussian<double>>>(solver->gaussians());
    gaussian_stamp = stamp_after(same ? gaussian_stamp : MotionStamp{});
    published.frame = number, published.edits = edits, published.version = splat_version;
}

}  // namespace knead
