// The frame loop shared by `run`, `view`, `vr`, `bench` and `verify`. One frame:
//
//     edits -> motion of the tools -> solver: submit, collect -> observers
//
// The solver and everything that observers and edits refer to must outlive the loop.
#pragma once
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/interrupt.h"
#include "host/hands/motion.h"
#include "host/scene/scene.h"
#include "host/surface/gpu_surface.h"

namespace knead {

enum class End { complete, interrupted, time_limit, substeps, refused, numerical_failure, device };

struct SessionLoopOptions {
    double duration = 0;    // simulated per frame [s]
    double hand_rate = 0;   // frames per second of the hands' clock
    int first_frame = 0;    // frame of the hands' clock at which the loop begins
    int frames_before = 0;  // frames of an earlier loop: numbers and times continue from there
    int frames = -1;        // negative: until stop()

    // Stop conditions, checked before each frame and, on the CPU, between substeps.
    bool whole_frames = false;  // these end the loop between frames only, but for most_substeps
    double time_limit = 0;      // wall time [s]; 0: none
    long most_substeps = 0;     // per frame; a frame that needs more is cut short; 0: no limit
    std::function<bool()> interrupted = [] { return knead::interrupted() != 0; };
    // On the CPU, called between substeps; return true to end the frame early. The loop continues
    // with the next frame; the remaining time of this one is dropped.
    std::function<bool(const FrameProgress&)> should_cut;
    // Called between substeps with the progress of frame `number`.
    std::function<void(int number, const FrameProgress&)> on_progress;

    // Of a simulator that is not editable, for the surface. Others have their own.
    std::vector<Material<double>> materials;
    SurfaceOptions surface{};
};
// Frame duration, frame rate, materials and surface options of the scene.
SessionLoopOptions loop_options(const Scene& scene);

// Wall time of the parts of a frame on the host [s]. `solver`: after submit_ahead(), the time to
// submit the frame and to wait for its end.
struct FrameTimes {
    double motion = 0, solver = 0, surface = 0;
    double observers = 0;  // without the surfaces they request; set when step() returns
};

struct FrameResult {
    int number = 0;        // from 1
    double simulated = 0;  // since the loop began, at the frame's end; without dropped time [s]
    double hand_time = 0;  // of the hands' clock, at the frame's end [s]
    Motion motion;
    FrameStats stats;
    FrameTimes times;
    long waits = 0;  // of the host for a device, while the frame was submitted
};

// Immutable, shared ownership.
using SharedParticles = std::shared_ptr<const std::vector<Particle<double>>>;
using Meshes = std::shared_ptr<const std::vector<Mesh>>;

using FrameObserver = std::function<void(const FrameResult&)>;
using Edit = std::function<void(EditableSimulator&)>;

// Whether the state is invalid: the guards have reset more than 1 % of the particles in one frame.
bool state_invalid(const FrameStats& stats, std::size_t particles);

class SessionLoop {
  public:
    SessionLoop(Simulator& solver, MotionSource motion, SessionLoopOptions options);
    SessionLoop(const SessionLoop&) = delete;
    ~SessionLoop() { solver.set_stop_check({}); }

    // Adds an observer. Observers are called after each frame, in the order of addition, and must
    // not call this function.
    void observe(FrameObserver observer) { observers.push_back(std::move(observer)); }

    // Queues an edit. It is applied once, with no frame in flight, before the motion of the next
    // frame is sampled; if that frame is already submitted, before the frame after it.
    void edit(Edit edit) { edits.push_back(std::move(edit)); }

    // Applies the queued edits now. Throws std::logic_error while a frame is in flight, or if the
    // simulator is not editable.
    void make_edits();

    // From now on each frame is submitted while the previous one is computed. Observers receive
    // statistics but must not fetch the state: the next frame may be in flight.
    void submit_ahead() { submits_ahead = true; }
    // From now on the surface of each frame is queued behind it on the device, without waiting.
    // `kept`: keep it for device_mesh(), which then waits once. No effect on the CPU.
    void launch_surfaces(bool kept = false);

    // Warm-up: computes frames of `duration` [s] with these motions, and their surfaces, then
    // restores the solver's state, so that graphs, memory and kernels exist before the first frame.
    // `meanwhile` is called after each. Calls no observers; counts no frames. Throws
    // std::logic_error while a frame is in flight, or if the simulator is not editable.
    void rehearse(const std::vector<Motion>& frames, double duration,
                  const std::function<void()>& meanwhile);

    // Must be called by an observer that has moved clay by an edit. Other edits that change
    // surfaces also change materials(), which is noticed without it. Throws std::logic_error while
    // a frame is in flight.
    void clay_edited();
    // Of the simulator as edited so far.
    const std::vector<Material<double>>& materials() const;
    // Options of all further surfaces. Throws std::logic_error while a frame is in flight.
    void set_surface(const SurfaceOptions& surface);
    const SurfaceOptions& surface_options() const { return options.surface; }

    // Ends the loop: frames in flight are completed and observed, no further frame begins. The
    // first reason is kept.
    void stop(End why = End::complete);
    // Ends the loop by an edit that is refused, before another frame begins.
    void refuse(std::string why)
    {
        stop(End::refused);
        refused_why = std::move(why);
    }
    const std::string& refusal() const { return refused_why; }

    // Computes one frame; false if none is left or the solver failed.
    bool step();
    void run()
    {
        while (step()) {
        }
    }

    double duration() const { return options.duration; }     // simulated per frame [s]
    const FrameResult& last() const { return last_result; }  // last completed frame; number 0: none
    End end() const { return ended.value_or(End::complete); }
    // Exception of the solver that ended the loop; null: none. Observers were called for all frames
    // before it.
    std::exception_ptr failure() const { return failed; }

    // The functions below throw std::logic_error while a frame is in flight.
    // The state at the end of the last frame, fetched at the first call.
    SharedParticles particles();
    // Its surface, computed at the first call; the same object while no clay moves.
    Meshes meshes();
    // The surface on the device; null if the solver runs on the CPU or there is no clay.
    std::shared_ptr<const DeviceMesh> device_mesh();
    // Whether meshes() returns the last surface without computing one.
    bool meshes_current() const { return last_meshes && moved == 0 && !materials_changed(); }
    const GpuSurface* device_surface() const { return on_device.get(); }  // null: none was made

  private:
    EditableSimulator& editable();
    void set_stop_check();
    void check_end();
    bool may_begin();
    bool should_end(const FrameProgress& progress);
    bool begin();
    bool collect();
    void apply_cut(FrameResult& f);
    void notify_observers();
    void make_device_surface();
    void launch_surface(int frame);
    void discard_surfaces();
    bool materials_changed() const;
    void follow_materials();

    Simulator& solver;
    MotionSource motion;
    SessionLoopOptions options;
    std::vector<FrameObserver> observers;
    std::vector<Edit> edits;

    FrameResult in_flight[2];          // frames in flight, alternating
    FrameResult last_result;           // the last that ended
    int submitted = 0, completed = 0;  // frames
    double lost = 0;                   // simulated time dropped by frames that were cut [s]
    bool submits_ahead = false, queues_surfaces = false, keeps_surfaces = false;
    int surface_frame = -1;       // the frame whose kept surface was launched
    std::optional<double> began;  // wall time of the first frame [s]
    std::optional<End> ended;
    std::exception_ptr failed;
    std::string refused_why;

    SharedParticles state;  // null: not fetched
    Meshes last_meshes;     // null: none
    SurfaceHistory past;    // of surfaces computed on the host
    std::shared_ptr<const DeviceMesh> last_on_device;
    long moved = 0, moved_on_device = 0;  // particle-substeps since the surface was computed
    std::vector<Material<double>> last_materials;  // of all surfaces above and below
    long last_version = 0;  // of the solver, when they were compared with its materials
    std::unique_ptr<GpuSurface> on_device;
};

}  // namespace knead
