#include "host/live/live_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/live/simulation_run.h"
#include "host/scene/domain.h"
#include "host/solver/audit.h"

namespace knead {

float MotionStamp::extrapolation(double now) const
{
    return step > 0 ? float(std::clamp((now - time) / step, 0.0, 1.0)) : 0;
}
namespace {

constexpr std::size_t most_waiting = 1024;  // frames of hands
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

void LiveSession::post(Command command, bool at_once)
{
    {
        const std::lock_guard lock(mutex);
        if (at_once) ++cut_requests;
        commands.push_back([this, command = std::move(command), at_once] {
            if (at_once) --cut_requests;
            try {
                command();
            } catch (...) {
                refuse(reason_of(std::current_exception()));
            }
        });
        ++posted;
    }
    wake.notify_all();
}

void LiveSession::wait_for_commands()
{
    std::unique_lock lock(mutex);
    const long ticket = posted;
    done.wait(lock, [&] { return finished >= ticket || quit; });
}

void LiveSession::run_thread()
{
    begin(scene);
    publish();
    std::unique_lock lock(mutex);
    ++finished;
    done.notify_all();
    while (!quit) {
        if (!commands.empty()) {
            const Command command = std::move(commands.front());
            commands.pop_front();
            lock.unlock();
            command();
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
    commands.clear();
    done.notify_all();
    lock.unlock();
    run.reset();  // on the thread that made it
}

// Returns whether a frame is due; if not, waits at most 5 ms for one, or for a command.
bool LiveSession::wait_for_work(std::unique_lock<std::mutex>& lock)
{
    const bool going = run && failure.empty();
    if (going && steps > 0) return true;
    if (!going || paused || waiting || options.stepped || stopped()) {
        wake.wait(lock, [&] { return quit || !commands.empty(); });
        return false;
    }
    const double left = next - now();
    if (left <= 1e-9) return true;  // sums of periods are rounded
    wake.wait_for(lock, std::chrono::duration<double>(std::clamp(left, 1e-4, 5e-3)));
    return false;
}

void LiveSession::begin(std::shared_ptr<const LiveScene> of)
{
    run.reset();  // before the new one: two may not fit into memory
    scene = std::move(of);
    failure.clear();
    backlog = dropped = 0;
    ++history;
    if (options.restarts_time) stepped_to = 0;
    if (!scene) return;
    try {
        run = std::make_unique<SimulationRun>(
            scene, options, options.stepped ? stepped_to : now(), [this] { return now(); },
            [this] { return quit || cut_requests > 0 || stopping.cuts(stopped()); });
        if (!waiting) run->rehearse();
        run->make_surface();
    } catch (...) {
        failure = reason_of(std::current_exception());
    }
    next = now();  // the time to create the solver is not backlog
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
    state->refused = refused;
    state->refusal = refusal;
    published.store(std::move(state));
    if (options.published) options.published();
}

void LiveSession::refuse(const std::string& why)
{
    ++refused;
    refusal = why;
}

void LiveSession::pause(bool on)
{
    post([this, on] {
        paused = on;
        next = now();
        if (on && run && failure.empty()) run->make_surface();
    });
}

void LiveSession::step(int frames)
{
    post([this, frames] { steps += std::max(0, frames); });
}

void LiveSession::reset()
{
    post([this] { begin(scene); }, true);
}

void LiveSession::load(std::shared_ptr<const LiveScene> of)
{
    post([this, of = std::move(of)] { begin(of); }, true);
}

void LiveSession::load(const std::string& path, const std::vector<std::string>& settings, int cells)
{
    post([this, path, settings, cells] { begin_file(path, settings, cells); }, true);
}

// Strong guarantee: if the file cannot be read, the current scene is kept.
void LiveSession::begin_file(const std::string& path, const std::vector<std::string>& settings,
                             int cells)
{
    std::vector<std::string> wanted = settings, left_out;
    if (cells > 0) wanted.push_back(cells_setting(read_json(path), cells));
    wanted = fitting_settings(path, wanted, left_out);
    begin(load_live_scene(path, wanted, options.memory));
    if (!left_out.empty())
        refuse(fmt::format("{} does not take --set {}: left out", path,
                           fmt::join(left_out, ", --set ")));
}

void LiveSession::edit_clay(Edit edit, bool reshapes)
{
    post([this, edit = std::move(edit), reshapes] {
        if (!run) throw std::invalid_argument("there is no simulation to edit");
        run->edit(edit, reshapes);
    });
}

void LiveSession::record_action(HandAction action, ActionType act) const
{
    action.act = act;
    if (options.on_action) options.on_action(action);
}

void LiveSession::set_hands(const HandsOptions& hands)
{
    HandAction action;
    action.hands = hands;
    record_action(action, ActionType::hands);
    post([this, hands] {
        if (!run) throw std::invalid_argument("there is no simulation with tools");
        run->set_hands(hands);
    });
}

void LiveSession::play(bool recorded)
{
    post([this, recorded] {
        if (run) return run->play(recorded);
        if (recorded) throw std::invalid_argument("there is no simulation for hands to act on");
    });
}

void LiveSession::set_gravity(Vec3<double> gravity)
{
    HandAction action;
    action.gravity = gravity;
    record_action(action, ActionType::gravity);
    edit_clay([gravity](EditableSimulator& solver) { solver.set_gravity(gravity); }, false);
}

void LiveSession::set_surface(int nodes)
{
    post([this, nodes] {
        if (!run) throw std::invalid_argument("there is no simulation with a surface");
        run->set_surface(nodes);
    });
}

void LiveSession::move_clay(int object, const RigidMotion<double>& motion)
{
    HandAction action;
    action.object = object, action.motion = motion;
    record_action(action, ActionType::move);
    edit([object, motion](EditableSimulator& solver) { solver.move(object, motion); });
}

void LiveSession::set_material(int object, const Material<double>& material)
{
    HandAction action;
    action.object = object, action.material = material;
    record_action(action, ActionType::material);
    post([this, object, material] {
        if (!run) throw std::invalid_argument("there is no simulation to edit");
        run->set_material(object, material);
    });
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
