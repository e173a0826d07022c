// One run of a live scene, from a load or reset to the next: solver, loop, hands. Not thread-safe:
// used by the thread of a LiveSession only.
#pragma once
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "host/hands/motion.h"
#include "host/live/live_session.h"
#include "host/paging/scene_splats.h"
#include "host/scene/seed.h"
#include "host/session/scene_editor.h"
#include "host/session/scene_export.h"
#include "host/session/scene_history.h"

namespace knead {

// What a run records; each function may be empty.
struct RunLog {
    std::function<void(const SessionEvent&)> event;
    std::function<void(const HandFrame&)> hands;
    std::function<void(const HistoryStep&, const FutureCapture&)> step;
    std::string step_label;  // of a step for the beginning of the run; "": there is none
};

// A run that computes a session again: motions, cuts and steps are given.
struct RunReplay {
    FrameEvent frame;           // the next
    std::size_t taken = 0;      // polls of background results so far in it
    bool stored_steps = false;  // the past has all steps: they are not captured again
};

class SimulationRun {
  public:
    // `began`: the session's time [s]. `should_cut`: called between substeps; true cuts the frame.
    // `ids`, `past`: of the session. `replay`: null, or a session's frames. Throws as
    // LiveOptions::make_solver.
    SimulationRun(std::shared_ptr<const LiveScene> scene, const LiveOptions& options, IdSource& ids,
                  History& past, RunLog log, double began, std::function<double()> now,
                  StopCheck should_cut, RunReplay* replay = nullptr);
    ~SimulationRun();  // reads the states that were not read yet
    SimulationRun(const SimulationRun&) = delete;

    void push(const HandFrame& frame);
    void set_substep_bound(int most) { solver->set_substep_bound(most); }
    // Computes one frame, and its surface if that is due or `shown`. Returns "", or why the
    // simulation ended.
    std::string frame(bool shown);
    // See LiveSession::rehearse(). Precondition: before the first frame.
    void rehearse();
    // Computes the surface of the last frame, if not done yet.
    void make_surface();
    double next_end() const;  // end of the next frame on the clock of a stepped session [s]
    // Advances the session's time to `time` [s] without simulating.
    void skip_to(double time);

    // A command that SceneHistory applies.
    CommandAnswer apply(const Issued& issued, PreparedObject* ready = nullptr);
    // An event of a session that is replayed: a preparation, or of a step.
    void replay_event(const SessionEvent& event);
    // Complete state now, after `frames` of the session. The function may be called on any thread,
    // also after the run.
    std::function<StoredState()> stored_state(long frames) const;
    std::size_t stored_bytes() const;  // about
    // What an export of the state after the last frame or command writes. May be used on any
    // thread, also after the run.
    ShownScene shown(std::shared_ptr<const LiveState> state);
    // Goes on from a state of the same scene, or from a step. Throws std::invalid_argument.
    void go_on(const StoredState& state);
    void go_on(StepId step);
    // The past begins with the present state.
    void begin_past() { history->begin_again(); }
    // Of a replay: the past, which has later steps already, begins with this run.
    void is_first_step() { history->state_loaded(); }
    // The open step, if any, is captured.
    void close_step() { history->close(); }
    // Prepares the object of a command on another thread.
    std::future<PreparedObject> prepare(const AddObject& command);
    void play(bool recorded);
    const DocumentPtr& document() const { return editor->document(); }
    ObjectPlaces places() const { return editor->places(); }
    Situation situation() const { return history->situation(true); }
    bool keeps_steps() const { return history->keeps(); }
    int number() const { return loop->last().number; }  // of the last frame; 0: none
    double now_at() const { return time; }              // of the session, at its end [s]

    // Fills the members of a state that describe the simulation.
    void publish(LiveState& state);
    const Simulator& of() const { return *solver; }
    double lost() const { return lost_time; }
    double period() const { return 1 / scene->scene.frame_rate; }             // [s]
    double simulated_period() const { return frame_duration(scene->scene); }  // [s]

  private:
    // A stored state that is read when it is asked for, at the latest when the run ends.
    struct LaterState {
        StoredState get();
        void read();
        std::mutex mutex;
        std::function<StoredState()> make;
        std::optional<StoredState> made;
    };

    bool takes(bool ready);
    void set_hands(const HandsOptions& options);
    void set_surface(int nodes);  // along its longest side
    Motion motion(double from, double to);
    Motion own_motion(double from, double to);
    Motion pushed(double from, double to);
    void record(const SessionEvent& event) const;
    void record_frame();
    void limit_tool_speed(Motion& motion) const;
    void after(const FrameResult& frame);
    void keep_splats(const FrameResult& frame);
    void clay_changed();
    void clay_replaced();
    void splats_changed();
    void adopt_plan(PagingReport& report);
    void begin_plan(int frame);
    void make_sources();
    void rehearse_frames(const Motion& away);
    void publish_gaussians(LiveState& state);
    void follow_gaussians();
    MotionStamp stamp_after(const MotionStamp& before) const;

    const std::shared_ptr<const LiveScene> scene;
    const LiveOptions& options;
    const std::function<double()> now;
    std::unique_ptr<Simulator> solver;
    EditableSimulator* const editable;  // `solver`; null: takes no edits
    SceneSplats splats;
    std::shared_ptr<const SplatCloud> drawn;  // snapshot of `splats`; null: there are none
    long splat_version = 0;
    std::unique_ptr<SessionLoop> loop;
    std::unique_ptr<SceneEditor> editor;
    History& past;
    IdSource& ids;
    const RunLog log;
    RunReplay* const replaying;
    std::unique_ptr<SceneHistory> history;  // destroyed before the simulator
    HandsOptions hands;
    HandTools tools;
    HandStream stream;
    std::unique_ptr<HandSource> source;  // null: nothing was recorded
    MotionSource replay;                 // of `source`
    bool recorded;
    double clock_offset;  // session time minus loop time [s]
    double replayed = 0;  // loop time at which the recording began, later by the time of cuts [s]
    double time = 0;      // of the session, at the last frame's end [s]
    double began = 0;     // of the current frame [s]
    Motion given;         // to the current frame; cut frames end before its end
    Motion last;          // of the last frame
    bool last_valid = false;  // `last` is valid
    std::size_t particles = 0;
    long cut = 0;                                 // frames
    double lost_time = 0;                         // simulated time of cut frames [s]
    Meshes meshes;                                // the last surface, on the host
    std::shared_ptr<const DeviceMesh> on_device;  // or on the device
    int meshed = -1;                              // frame of the surface
    GaussianKeeper gaussians;
    MotionStamp mesh_stamp, gaussian_stamp;
    struct {
        int frame = -1;
        long edits = -1, version = -1;
        std::shared_ptr<const std::vector<Gaussian<double>>> host, before;
        std::shared_ptr<const DeviceGaussians> device;
    } published;  // Gaussians of the last state
    long mesh_version = 0;
    double mesh_cost = 0, mesh_made = -1e30;  // [s]
    std::string failure;
    std::vector<bool> taken;                       // of the current frame
    std::optional<PreparedObject> prepared_again;  // of a replay
    // Planned by a thread: splats to split and to add. Destroyed before the solver.
    long edits = 0, planned_edits = 0;  // edits made so far, and when the plan began
    std::future<UpkeepPlan> plan;
    std::shared_future<std::vector<Gaussian<double>>> read;  // of an export; uses the solver
    mutable std::vector<std::weak_ptr<LaterState>> later_states;
};

}  // namespace knead
