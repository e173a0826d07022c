#include "host/live/session_log.h"

#include <fmt/format.h>

#include <map>
#include <stdexcept>
#include <utility>

#include "host/document/command_table.h"
#include "host/live/simulation_run.h"

namespace knead {

struct SessionReplay::Work {
    std::shared_ptr<const LiveScene> scene;
    ReplayOptions options;
    LiveOptions live{};
    IdSource ids{};
    History past{std::size_t(1) << 40};
    RunReplay frame{};
    std::unique_ptr<SimulationRun> run{};
    std::map<long, std::uint64_t> expected{};
    long frames = 0;
    bool stopped = false, began = false;

    void begin(const RunBegun& begun);
    void compute(const FrameEvent& event);
    void compare();
    void apply(const Issued& issued);
};

void SessionReplay::Work::begin(const RunBegun& begun)
{
    const bool first = !std::exchange(began, true);
    run.reset();
    std::shared_ptr<const LiveScene> of = scene;
    if (begun.document)
        of = live_scene_of({scene->scene.path, scene->text, scene->settings}, begun.document);
    run = std::make_unique<SimulationRun>(
        of, live, ids, past, RunLog{}, 0, [this] { return frame.frame.time; },
        [](const FrameProgress&) { return false; }, &frame);
    run->rehearse();
    if (first && !begun.state) run->is_first_step();
    if (begun.state) run->go_on(options.stored_state(begun.state));
    if (frames == 0) compare();
}

void SessionReplay::Work::compute(const FrameEvent& event)
{
    frame.frame = event, frame.taken = 0;
    run->set_substep_bound(event.cut_after);
    const std::string failure = run->frame(false);
    ++frames;
    if (!failure.empty()) throw std::runtime_error(failure);
    if (frame.taken != event.taken.size())
        throw std::runtime_error(
            fmt::format("frame {}: fewer background tasks than in the log", frames));
    compare();
    if (options.after_frame && !options.after_frame(frames, run->of())) stopped = true;
}

void SessionReplay::Work::compare()
{
    const auto found = expected.find(frames);
    const EditableSimulator* of = run->of().editable();
    if (found == expected.end() || !of || !options.compared) return;
    options.compared({frames, hash(of->rows(*of->snapshot())) == found->second});
}

// Commands of the session change no clay, but for what is carried; those of steps are events of
// their own.
void SessionReplay::Work::apply(const Issued& issued)
{
    if (row_of(issued.command).receiver == Receiver::session &&
        !std::holds_alternative<Carry>(issued.command))
        return;
    if (const auto refusal = run->apply(issued).refusal)
        throw std::runtime_error(fmt::format("after frame {}: {} is refused: {}", frames,
                                             row_of(issued.command).name, refusal->text()));
}

SessionReplay::SessionReplay(std::shared_ptr<const LiveScene> scene, ReplayOptions options)
    : work(std::make_unique<Work>(Work{std::move(scene), std::move(options)}))
{
    work->live.make_solver = work->options.make_solver;
    work->live.stepped = work->options.stepped;
    work->live.recorded = false;
    work->live.codec = work->options.codec;
    work->live.budget = 1e30;  // cuts are those of the log
    if (work->options.read_history) {
        work->options.read_history(work->past);
        work->frame.stored_steps = true;
    }
}

SessionReplay::~SessionReplay() = default;

void SessionReplay::expect(const HashEvent& hash) { work->expected[hash.frame] = hash.hash; }

bool SessionReplay::add(const SessionEvent& event)
{
    if (work->stopped) return false;
    if (const RunBegun* begun = std::get_if<RunBegun>(&event)) {
        work->begin(*begun);
    } else if (!work->run) {
        throw std::runtime_error("the log begins without a scene");
    } else if (const FrameEvent* frame = std::get_if<FrameEvent>(&event)) {
        work->compute(*frame);
    } else if (const CommandEvent* command = std::get_if<CommandEvent>(&event)) {
        work->apply(command->issued);
    } else if (!std::holds_alternative<HashEvent>(event)) {
        work->run->replay_event(event);
    }
    const StepCaptured* captured = std::get_if<StepCaptured>(&event);
    if (captured && work->options.to_step == captured->id) work->stopped = true;
    return !work->stopped;
}

long SessionReplay::frames() const { return work->frames; }
const Simulator& SessionReplay::simulator() const { return work->run->of(); }
DocumentPtr SessionReplay::document() const { return work->run->document(); }
const Scene& SessionReplay::scene() const { return work->scene->scene; }

std::vector<Particle<double>> replayed(
    const SessionLog& log, const std::function<std::unique_ptr<Simulator>(const Setup&)>& make)
{
    ReplayOptions options;
    options.make_solver = make;
    SessionReplay replay(log.scene, options);
    for (const SessionEvent& event : log.events) replay.add(event);
    return replay.simulator().particles();
}

}  // namespace knead
