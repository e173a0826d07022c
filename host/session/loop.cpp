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

bool overrun(const FrameStats& stats, std::size_t particles)
{
    return double(stats[Count::repaired]) > 0.01 * double(particles);
}

SessionLoopOptions loop_options(const Scene& scene)
{
    SessionLoopOptions options;
    options.duration = frame_duration(scene);
    options.rate = scene.frame_rate;
    options.materials = scene.setup.materials;
    options.surface = scene.surface;
    return options;
}

SessionLoop::SessionLoop(Simulator& of, MotionSource source, SessionLoopOptions by)
    : solver(of),
      motion(std::move(source)),
      options(std::move(by)),
      begun(options.done),
      done(options.done)
{
    newest.number = options.done;
    set_stop_check();
}

void SessionLoop::set_stop_check()
{
    solver.set_stop_check([this](const FrameProgress& part) { return should_end(part); });
}

void SessionLoop::launch_surfaces(bool kept)
{
    launching = solver.clay() != nullptr;
    keeping = kept;
    if (launching) make_device_surface();
}

void SessionLoop::stop(End why)
{
    if (!ended) ended = why;
}

bool SessionLoop::step()
{
    if (begun == done && !begin()) return false;
    if (ahead && edits.empty()) begin();
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
    if (ended || begun == options.frames) return false;
    check_end();
    return !ended;
}

// Whether to end the current frame after this substep.
bool SessionLoop::should_end(const FrameProgress& part)
{
    check_end();
    if (options.most_substeps > 0 && part.substeps >= options.most_substeps) stop(End::substeps);
    if (options.part) options.part(begun + 1, part);
    return ended || (options.should_cut && options.should_cut(part));
}

// Corrects the result of a frame that was cut: its end times, and the tool poses at the end.
void SessionLoop::shorten(FrameResult& f)
{
    const double share = f.stats.reached / options.duration;
    f.simulated = (f.number - 1) * options.duration + f.stats.reached - lost;
    lost += options.duration - f.stats.reached;
    f.hand_time = (options.first + f.number - 1 + share) / options.rate;
    for (std::size_t j = 0; j < f.motion.to.size(); ++j)
        f.motion.to[j] = between(f.motion.from[j], f.motion.to[j], share);
}

// Submits the next frame; false if there is none.
bool SessionLoop::begin()
{
    if (!may_begin()) return false;
    if (begun == done) make_edits();
    const double start = wall_seconds();
    FrameResult& f = in_flight[begun % 2];
    f = {};
    f.number = begun + 1;
    f.hand_time = (options.first + f.number) / options.rate;
    f.motion = motion((options.first + begun) / options.rate, f.hand_time);
    const double submitted = wall_seconds();
    f.times.motion = submitted - start;
    const long waits = gpu_waits();
    const int before = begun;
    try {
        solver.submit(f.motion, options.duration);
        ++begun;
        f.times.solver = wall_seconds() - submitted;
        if (launching) launch_surface(f.number);
    } catch (...) {
        stop(End::device);
        failed = std::current_exception();
    }
    f.waits = gpu_waits() - waits;
    return begun > before;
}

// Waits for the end of the oldest frame in flight; false if the solver failed.
bool SessionLoop::collect()
{
    const double start = wall_seconds();
    FrameResult& f = in_flight[done % 2];
    try {
        f.stats = solver.collect();
    } catch (...) {
        stop(End::device);
        if (!failed) failed = std::current_exception();
        begun = done;  // the frame submitted behind it is lost, too
        return false;
    }
    f.times.solver += wall_seconds() - start;
    f.simulated = f.number * options.duration - lost;
    if (f.stats.cut) shorten(f);
    newest = std::move(f);
    ++done;
    moved += newest.stats[Count::moved], moved_on_device += newest.stats[Count::moved];
    state.reset();
    return true;
}

void SessionLoop::notify_observers()
{
    const double start = wall_seconds();
    for (const FrameObserver& observer : observers) observer(newest);
    newest.times.observers = wall_seconds() - start - newest.times.surface;
}

void SessionLoop::make_edits()
{
    if (edits.empty()) return;
    if (begun > done) throw std::logic_error("edit while a frame is in flight");
    for (const Edit& edit : std::exchange(edits, {})) edit(editable());
    options.materials = editable().config().materials;  // edits may have added some
    renew_surfaces();
}

// Keeps all surfaces until the end, so that memory is allocated for as many as are in use at once.
void SessionLoop::rehearse(const std::vector<Motion>& frames, double duration,
                           const std::function<void()>& meanwhile)
{
    if (begun > done) throw std::logic_error("warm-up while a frame is in flight");
    const std::shared_ptr<const Snapshot> before = editable().snapshot();
    std::vector<std::shared_ptr<const DeviceMesh>> held;
    const bool keeps = launching && keeping && on_device;
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
    renew_surfaces();
}

void SessionLoop::clay_edited()
{
    if (begun > done) throw std::logic_error("clay was edited while a frame is in flight");
    options.materials = editable().config().materials;
    renew_surfaces();
}

void SessionLoop::set_surface(const SurfaceOptions& surface)
{
    if (begun > done)
        throw std::logic_error("surface options were changed while a frame is in flight");
    options.surface = surface;
    last_meshes.reset(), last_on_device.reset(), on_device.reset(), launched = -1;
    past = {};
    if (launching) make_device_surface();
}

SharedParticles SessionLoop::particles()
{
    if (begun > done) throw std::logic_error("the state was requested while a frame is in flight");
    if (!state) state = std::make_shared<const std::vector<Particle<double>>>(solver.particles());
    return state;
}

// After a frame without motion the next one is likely to have none: its surface is not queued.
void SessionLoop::launch_surface(int frame)
{
    if (!on_device) return;
    if (!keeping) return on_device->launch(*solver.clay());
    if (last_on_device && moved_on_device == 0) return;
    on_device->launch_kept(*solver.clay());
    launched = frame;
}

// Creates nothing if there is no clay.
void SessionLoop::make_device_surface()
{
    launched = -1;
    if (particles()->empty()) return;
    on_device = std::make_unique<GpuSurface>(*particles(), options.materials, options.surface);
}

// Discards the surfaces of the edited clay. Reuses device memory where possible: allocating and
// freeing so much would stall all drawing.
void SessionLoop::renew_surfaces()
{
    state.reset(), last_meshes.reset(), last_on_device.reset();
    launched = -1;
    past = {};
    if (on_device && !on_device->set_materials(options.materials)) on_device.reset();
    if (on_device) on_device->leap();
    if (launching && !on_device) make_device_surface();
}

std::shared_ptr<const DeviceMesh> SessionLoop::device_mesh()
{
    if (begun > done) throw std::logic_error("a surface was requested while a frame is in flight");
    const gpu::Clay* clay = solver.clay();
    if (!clay || (last_on_device && moved_on_device == 0)) return last_on_device;
    const double start = wall_seconds();
    if (!on_device) make_device_surface();
    if (!on_device) return nullptr;
    last_on_device = launched == newest.number ? on_device->launched() : nullptr;
    if (!last_on_device) last_on_device = on_device->kept(*clay);
    moved_on_device = 0;
    newest.times.surface += wall_seconds() - start;
    return last_on_device;
}

Meshes SessionLoop::meshes()
{
    if (begun > done) throw std::logic_error("a surface was requested while a frame is in flight");
    if (meshes_stand()) return last_meshes;
    const double start = wall_seconds();
    std::vector<Mesh> made;
    if (const gpu::Clay* clay = solver.clay()) {
        if (!on_device) make_device_surface();
        if (on_device) made = on_device->surface(*clay);
    } else {
        made = surface(*particles(), options.materials, options.surface, nullptr, &past);
    }
    last_meshes = std::make_shared<const std::vector<Mesh>>(std::move(made));
    moved = 0;
    newest.times.surface += wall_seconds() - start;
    return last_meshes;
}

}  // namespace knead
