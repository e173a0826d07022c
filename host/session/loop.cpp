#include "host/session/loop.h"

#include <stdexcept>
#include <utility>

#include "host/base/machine.h"

namespace knead {
EditableSimulator& SessionLoop::editable()
{
    if (EditableSimulator* found = solver.editable()) return *found;
    throw std::logic_error(solver.name() + " takes no edits");
}

bool state_invalid(const FrameStats& stats, std::size_t particles)
{
    return double(stats[Count::repaired]) > 0.01 * double(particles);
}

SessionLoopOptions loop_options(const Scene& scene)
{
    SessionLoopOptions options;
    options.duration = frame_duration(scene);
    options.hand_rate = scene.frame_rate;
    options.materials = scene.setup.materials;
    options.surface = scene.surface;
    return options;
}

SessionLoop::SessionLoop(Simulator& of, MotionSource source, SessionLoopOptions by)
    : solver(of),
      motion(std::move(source)),
      options(std::move(by)),
      submitted(options.frames_before),
      completed(options.frames_before)
{
    last_result.number = options.frames_before;
    last_materials = materials(), last_version = solver.version();
    set_stop_check();
}

void SessionLoop::set_stop_check()
{
    solver.set_stop_check([this](const FrameProgress& progress) { return should_end(progress); });
}

void SessionLoop::launch_surfaces(bool kept)
{
    queues_surfaces = solver.clay() != nullptr;
    keeps_surfaces = kept;
    if (queues_surfaces) make_device_surface();
}

void SessionLoop::stop(End why)
{
    if (!ended) ended = why;
}

bool SessionLoop::step()
{
    if (submitted == completed && !begin()) return false;
    if (submits_ahead && edits.empty()) begin();
    if (!collect()) return false;
    notify_observers();
    return true;
}

void SessionLoop::check_end()
{
    if (!began) began = wall_seconds();
    if (options.interrupted && options.interrupted()) stop(End::interrupted);
    if (options.time_limit > 0 && wall_seconds() - *began > options.time_limit)
        stop(End::time_limit);
}

bool SessionLoop::may_begin()
{
    if (ended || submitted == options.frames) return false;
    check_end();
    return !ended;
}

// Whether to end the current frame after this substep.
bool SessionLoop::should_end(const FrameProgress& progress)
{
    if (!options.whole_frames) check_end();
    if (options.most_substeps > 0 && progress.substeps >= options.most_substeps)
        stop(End::substeps);
    if (options.on_progress) options.on_progress(submitted + 1, progress);
    return ended || (options.should_cut && options.should_cut(progress));
}

// Corrects the result of a frame that was cut: its end times, and the tool poses at the end.
void SessionLoop::apply_cut(FrameResult& f)
{
    const double share = f.stats.reached / options.duration;
    f.simulated = (f.number - 1) * options.duration + f.stats.reached - lost;
    lost += options.duration - f.stats.reached;
    f.hand_time = (options.first_frame + f.number - 1 + share) / options.hand_rate;
    for (std::size_t j = 0; j < f.motion.to.size(); ++j)
        f.motion.to[j] = between(f.motion.from[j], f.motion.to[j], share);
}

// Submits the next frame; false if there is none.
bool SessionLoop::begin()
{
    if (!may_begin()) return false;
    if (submitted == completed) make_edits(), follow_materials();
    if (ended) return false;
    const double start = wall_seconds();
    FrameResult& f = in_flight[submitted % 2];
    f = {};
    f.number = submitted + 1;
    f.hand_time = (options.first_frame + f.number) / options.hand_rate;
    f.motion = motion((options.first_frame + submitted) / options.hand_rate, f.hand_time);
    const double submit_start = wall_seconds();
    f.times.motion = submit_start - start;
    const long waits = gpu_waits();
    const int before = submitted;
    try {
        solver.submit(f.motion, options.duration);
        ++submitted;
        f.times.solver = wall_seconds() - submit_start;
        if (queues_surfaces) launch_surface(f.number);
    } catch (...) {
        stop(End::device);
        failed = std::current_exception();
    }
    f.waits = gpu_waits() - waits;
    return submitted > before;
}

// Waits for the end of the oldest frame in flight; false if the solver failed.
bool SessionLoop::collect()
{
    const double start = wall_seconds();
    FrameResult& f = in_flight[completed % 2];
    try {
        f.stats = solver.collect();
    } catch (...) {
        stop(End::device);
        if (!failed) failed = std::current_exception();
        submitted = completed;  // the frame submitted behind it is lost, too
        return false;
    }
    f.times.solver += wall_seconds() - start;
    f.simulated = f.number * options.duration - lost;
    if (f.stats.cut) apply_cut(f);
    last_result = std::move(f);
    ++completed;
    moved += last_result.stats[Count::moved], moved_on_device += last_result.stats[Count::moved];
    state.reset();
    last_version = solver.version();
    return true;
}

void SessionLoop::notify_observers()
{
    const double start = wall_seconds();
    for (const FrameObserver& observer : observers) observer(last_result);
    last_result.times.observers = wall_seconds() - start - last_result.times.surface;
}

void SessionLoop::make_edits()
{
    if (edits.empty()) return;
    if (submitted > completed) throw std::logic_error("edit while a frame is in flight");
    for (const Edit& edit : std::exchange(edits, {})) edit(editable());
    discard_surfaces();
}

// Keeps all surfaces until the end, so that memory is allocated for as many as are in use at once.
void SessionLoop::rehearse(const std::vector<Motion>& frames, double duration,
                           const std::function<void()>& meanwhile)
{
    if (submitted > completed) throw std::logic_error("warm-up while a frame is in flight");
    const std::shared_ptr<const Snapshot> before = editable().snapshot();
    std::vector<std::shared_ptr<const DeviceMesh>> held;
    const bool keeps = queues_surfaces && keeps_surfaces && on_device;
    solver.set_stop_check({});
    try {
        for (const Motion& frame : frames) {
            solver.submit(frame, duration);
            if (keeps) on_device->launch_kept(*solver.clay());
            solver.collect();
            if (keeps) held.push_back(on_device->launched());
            if (meanwhile) meanwhile();
        }
        editable().restore(*before);
    } catch (...) {
        set_stop_check();
        throw;
    }
    set_stop_check();
    discard_surfaces();
}

void SessionLoop::clay_edited()
{
    if (submitted > completed) throw std::logic_error("clay was edited while a frame is in flight");
    editable();
    discard_surfaces();
}

const std::vector<Material<double>>& SessionLoop::materials() const
{
    const EditableSimulator* const edited = std::as_const(solver).editable();
    return edited ? edited->config().materials : options.materials;
}

// Whether an edit has added or removed clay or changed its materials since the last surface. A
// frame changes the version, too; collect() takes note of it.
bool SessionLoop::materials_changed() const
{
    return solver.version() != last_version && materials() != last_materials;
}

void SessionLoop::follow_materials()
{
    if (materials_changed()) discard_surfaces();
    last_version = solver.version();
}

void SessionLoop::set_surface(const SurfaceOptions& surface)
{
    if (submitted > completed)
        throw std::logic_error("surface options were changed while a frame is in flight");
    options.surface = surface;
    last_meshes.reset(), last_on_device.reset(), on_device.reset(), surface_frame = -1;
    past = {};
    if (queues_surfaces) make_device_surface();
}

SharedParticles SessionLoop::particles()
{
    if (submitted > completed)
        throw std::logic_error("the state was requested while a frame is in flight");
    follow_materials();
    if (!state) state = std::make_shared<const std::vector<Particle<double>>>(solver.particles());
    return state;
}

// After a frame without motion the next one is likely to have none: its surface is not queued.
void SessionLoop::launch_surface(int frame)
{
    if (!on_device) return;
    if (!keeps_surfaces) return on_device->launch(*solver.clay());
    if (last_on_device && moved_on_device == 0) return;
    on_device->launch_kept(*solver.clay());
    surface_frame = frame;
}

// Creates nothing if there is no clay.
void SessionLoop::make_device_surface()
{
    surface_frame = -1;
    if (particles()->empty()) return;
    on_device = std::make_unique<GpuSurface>(*particles(), last_materials, options.surface);
}

// Discards the surfaces of the edited clay. Reuses device memory where possible: allocating and
// freeing so much would stall all drawing.
void SessionLoop::discard_surfaces()
{
    last_materials = materials(), last_version = solver.version();
    state.reset(), last_meshes.reset(), last_on_device.reset();
    surface_frame = -1;
    past = {};
    if (on_device && !on_device->set_materials(last_materials)) on_device.reset();
    if (on_device) on_device->reset_advance();
    if (queues_surfaces && !on_device) make_device_surface();
}

std::shared_ptr<const DeviceMesh> SessionLoop::device_mesh()
{
    if (submitted > completed)
        throw std::logic_error("a surface was requested while a frame is in flight");
    follow_materials();
    const gpu::Clay* clay = solver.clay();
    if (!clay || (last_on_device && moved_on_device == 0)) return last_on_device;
    const double start = wall_seconds();
    if (!on_device) make_device_surface();
    if (!on_device) return nullptr;
    last_on_device = surface_frame == last_result.number ? on_device->launched() : nullptr;
    if (!last_on_device) last_on_device = on_device->kept(*clay);
    moved_on_device = 0;
    last_result.times.surface += wall_seconds() - start;
    return last_on_device;
}

Meshes SessionLoop::meshes()
{
    if (submitted > completed)
        throw std::logic_error("a surface was requested while a frame is in flight");
    follow_materials();
    if (meshes_current()) return last_meshes;
    const double start = wall_seconds();
    std::vector<Mesh> made;
    if (const gpu::Clay* clay = solver.clay()) {
        if (!on_device) make_device_surface();
        if (on_device) made = on_device->surface(*clay);
    } else {
        made = surface(*particles(), last_materials, options.surface, nullptr, &past);
    }
    last_meshes = std::make_shared<const std::vector<Mesh>>(std::move(made));
    moved = 0;
    last_result.times.surface += wall_seconds() - start;
    return last_meshes;
}

}  // namespace knead
