// Live session: simulates a scene in real time on its own thread. Input is hand frames and
// commands; output is a sequence of immutable published states, which windows and headsets draw
// without waiting for the simulation.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/assets/splat_object.h"
#include "host/base/machine.h"
#include "host/document/command_table.h"
#include "host/document/reduce.h"
#include "host/hands/recording.h"
#include "host/live/session_log.h"
#include "host/session/loop.h"
#include "host/session/scene_editor.h"
#include "host/session/session_file.h"
#include "host/splats/cloud.h"
#include "host/splats/device_gaussians.h"
#include "render/painter.h"

namespace knead {

// A built scene with the files it refers to.
struct LiveScene {
    Scene scene;                         // built
    std::vector<SplatObject> splats;     // of its objects
    std::optional<Recording> recording;  // of its hands
    std::vector<std::string> settings;   // --set, as given
    std::string text;                    // of the scene's file
};
// Loads a scene as `knead run` does, or the empty table (host/scene/new_scene.h). `memory`: limit
// [bytes]; 0: what is free. Throws InputError, MemoryError.
std::shared_ptr<const LiveScene> load_live_scene(const std::string& path,
                                                 const std::vector<std::string>& settings = {},
                                                 std::size_t memory = 0);
// The same from the text of the file at `path`, and with the objects and settings of `document`, if
// not null. Recorded hands that cannot be read are left out: a session has its own.
std::shared_ptr<const LiveScene> live_scene_of(const SceneSource& source,
                                               const DocumentPtr& document = nullptr,
                                               std::size_t memory = 0);
// The scene of a session to go on with. Throws as session_to_continue(), too.
std::shared_ptr<const LiveScene> load_session_scene(const std::string& file,
                                                    std::size_t memory = 0);
// The `settings`, in order, that are valid for the scene at `path`; the others are appended to
// `left_out`. Throws InputError if the scene cannot be read even without settings.
std::vector<std::string> fitting_settings(const std::string& path,
                                          const std::vector<std::string>& settings,
                                          std::vector<std::string>& left_out);
// Categories of clay that is drawn as splats.
std::vector<int> splat_categories(const Scene& scene);
std::vector<int> splat_categories(const Document& document);

struct LiveOptions {
    std::function<std::unique_ptr<Simulator>(const Setup&)>
        make_solver;  // creates the solver of a scene
    // True: time is set by advance_to(); frames are never cut, and equal hands give equal bits.
    // False: real time.
    bool stepped = false;
    bool restarts_time = false;  // stepped: the caller's time restarts at 0 on reset and load
    // Polled; return true to stop. No further frame begins, and the current one is cut between two
    // substeps if it has not ended 0.25 s later.
    std::function<bool()> should_stop;
    // The options up to `max_tool_speed` apply to real time only.
    std::function<double()> clock;  // [s], ascending; null: time since the session began
    double budget = 0;              // limit of a frame on the clock [s]; 0: the frame period
    double max_tool_speed = 3;  // speed limit of a tool that follows its hand, in real metres per
                                // second of simulated time [m/s]; 0: no limit
    bool recorded = true;       // starts with the scene's recorded hands
    bool paused = false;        // starts paused
    bool manual_start = false;  // the first frame begins with start(), the warm-up with rehearse()
    bool on_device = false;     // surfaces and Gaussians stay on the device that computed them
    bool with_motion = false;   // states contain the motion of the surface
    std::size_t memory = 0;     // limit for loading a scene [bytes]; 0: what is free
    bool logs = false;          // keeps a SessionLog; memory grows with time
    std::size_t history = std::size_t(256) << 20;  // of steps in memory [bytes]
    Codec codec = Codec::automatic;                // of these steps
    // Writes a working log in log_folder(): the session can be saved, and recovered after a crash.
    bool protects = false;
    std::string
        session;  // file of a session to open at the beginning, in place of a scene; "": none
    // Asked in real time whether the result of a background task of the splats is taken now; the
    // argument says whether it is ready. If not, taking it waits. Null: the argument.
    std::function<bool(bool ready)> take_background;
    // Called on the simulation's thread after each state that is published.
    std::function<void()> published;
};

// State of a tool at the end of a frame.
struct LiveTool {
    Side side;
    std::string held;  // "" the bare hand
    bool active;       // touches clay
    float size;        // fraction of its full radii
    std::vector<DrawPrimitive> primitives;
};

// Time of the hand poses that the positions in a state result from; used to extrapolate the
// positions to the later time of display.
struct MotionStamp {
    double time = 0;  // of the session [s]
    double step = 0;  // since the previous positions [s]; 0: motion unknown
    // Factor by which to extend the last displacement for display at `now` [s], from 0 to 1.
    float extrapolation(double now) const;
};

// How far the simulation lags behind real time.
struct Backlog {
    long frames = 0;          // number of frames cut between two substeps
    double missing_time = 0;  // simulated time missing so far [s]
};

// State after a frame, an edit or a command. Immutable.
struct LiveState {
    std::shared_ptr<const LiveScene> scene;  // null: none was loaded
    int history = 0;                         // incremented by each load and reset
    long version = 0;                        // incremented with each published state
    double time = 0;                         // of the session, at the frame's end [s]
    FrameResult frame;  // the last: number, statistics, times, and the joints of all tools
    std::vector<StageTime> stages;  // of the last frame; empty on a GPU, where timing is expensive
    // The surface: at most one is set. Both null: none was computed.
    Meshes meshes;
    std::shared_ptr<const DeviceMesh> on_device;
    long mesh_version = 0;   // incremented when the surface changes
    MotionStamp mesh_stamp;  // for LiveOptions::with_motion
    SurfaceOptions surface;  // options it was computed with
    // The moved Gaussians: at most one is set. Both null: the scene has none.
    std::shared_ptr<const std::vector<Gaussian<double>>> gaussians;
    std::shared_ptr<const DeviceGaussians> gaussians_on_device;
    std::shared_ptr<const std::vector<Gaussian<double>>> gaussians_before;  // null: unknown
    MotionStamp gaussian_stamp;
    // In the order of the Gaussians, then the frozen ones. Null: the scene has none.
    std::shared_ptr<const SplatCloud> splats;
    long splat_version = 0;  // incremented when splats are split, added, activated or frozen
    std::vector<LiveTool> tools;
    HandsOptions hands;    // the current tools
    DocumentPtr document;  // null: no scene was loaded
    bool recorded = false, paused = false;
    double recording_time = 0;  // of the scene's recorded hands, at the frame's end [s]
    Backlog backlog;
    std::string solver;   // its name
    std::string failure;  // why the simulation has ended; "": it has not
    long answered = 0;    // serial number of the last command that was applied or refused
    int refused = 0;      // number of commands refused so far
    std::string refusal;  // reason for the last of them
    SourceReport source;  // of the last nozzle
    // The steps of the history, by id; null: none are kept.
    std::shared_ptr<const std::vector<StepInfo>> steps;
    std::size_t history_bytes = 0;  // of them in memory
    Situation situation;            // on which commands depend; its document is `document`
    JournalState log;               // the working log; its `file` is "" if there is none
    std::string saved_as;           // file of the last save; "": none
    bool unsaved = false;           // there are steps since, or one has begun
    std::string exported;           // file of the last export that was written; "": none
    int exports = 0;                // number of exports written so far
};

// A command as it was applied.
struct AppliedCommand {
    int history = 0;  // LiveState::history
    long frame = 0;   // after which it was applied, since the history began; 0: before the first
    double time = 0;  // of the session, at that frame's end [s]
    Issued issued;    // with ids in place of names
};

// The surface on the host; blocks to fetch it from a device. Never null.
Meshes meshes_of(const LiveState& state);

// Digest of the clay, for comparison with a run.
struct ClayDigest {
    std::string hash;  // of the state; "": there is no simulation
    long particles = 0;
};

class SimulationRun;
struct RunLog;

// Grace period of a stop: the current frame is cut only if it has not ended after 0.25 s, because a
// frame that was cut cannot be reproduced from a recording.
class StopGracePeriod {
  public:
    bool cuts(bool stopped)
    {
        constexpr double longest = 0.25;  // [s]
        if (!stopped) return false;
        if (since == 0) since = wall_seconds();
        return wall_seconds() - since > longest;
    }

  private:
    double since = 0;  // wall time of the stop [s]; 0: not stopped
};

class LiveSession {
  public:
    // Starts the thread and simulates `scene`, which may be null. Faults of the simulation are not
    // thrown but reported in LiveState::failure.
    LiveSession(std::shared_ptr<const LiveScene> scene, LiveOptions options);
    ~LiveSession();  // cuts the current frame between two substeps
    LiveSession(const LiveSession&) = delete;

    // All functions below are thread-safe.
    std::shared_ptr<const LiveState> state() const { return published.load(); }
    double now() const;  // session time, for stamping hand frames [s]
    // Queues tracked hands, in the tracker's frame, in ascending order of time. Of more than 1024
    // queued frames the oldest are dropped.
    void push(const HandFrame& hands);
    // Waits until LiveOptions::session is open. Throws what opening it threw.
    void wait_until_open();
    // Of the session's list: a PNG. No effect without a log.
    void set_picture(std::string png);

    // Warm-up: computes some frames and restores the state, so that graphs, memory and kernels
    // exist before the first frame. Real time only. Called automatically for each scene unless
    // LiveOptions::manual_start.
    void rehearse();
    // With LiveOptions::manual_start: begins the first frame.
    void start();

    // Commands are applied in order, between frames. Open, Reset and SetLattice cut the current
    // frame. Returns the command's serial number; 0 if 4096 commands wait: it is refused.
    long send(Command command, Origin origin = Origin::window, unsigned drag = 0);
    // The commands that were applied since the last call, in order; of more than 100 000 the last
    // are dropped.
    std::vector<AppliedCommand> take_applied();

    // Blocks until all commands so far are executed.
    void wait_for_commands();
    // Calls `inspect` with the solver on the session's thread and returns after the call; false if
    // there is no solver.
    bool inspect_solver(const std::function<void(const Simulator&)>& inspect);
    ClayDigest digest();
    // Where the objects' clay is: the session's thread reads all particles between two frames.
    // object_places() waits for it, and is never null; the others do not wait, and the latest are
    // null until some were found.
    std::shared_ptr<const ObjectPlaces> object_places();
    void request_object_places();
    std::shared_ptr<const ObjectPlaces> latest_object_places() const { return found_places.load(); }
    // Since the last load; empty without LiveOptions::logs.
    SessionLog session_log();
    // Stepped sessions: simulates all frames that end at or before `time` [s], then returns. Throws
    // std::logic_error in real time.
    void advance_to(double time);

  private:
    // A command, or work of this class between frames that changes no scene.
    using Task = std::variant<Issued, std::function<void()>>;
    void post(std::function<void()> work);
    void execute(const Task& task);
    void execute(const Issued& issued);
    CommandAnswer apply(const Issued& issued);
    std::optional<Refusal> save(const Save& command);
    std::optional<Refusal> start_export(const Export& command);
    void end_export(const std::string& file, const std::string& why);
    void open_session(const std::string& file);
    void begin_past();
    void begin_log();
    void end_log();
    void record(const SessionEvent& event);
    RunLog run_log(const std::string& step_label);
    void make_run(const std::string& step);
    void hash_state();
    void publish_steps(LiveState& state);
    bool superseded(const Task& task) const;
    bool may_execute();
    void run_thread();
    bool wait_for_work(std::unique_lock<std::mutex>& lock);
    bool stopped() const { return options.should_stop && options.should_stop(); }
    void begin(std::shared_ptr<const LiveScene> scene);
    void begin_file(const std::string& path, const std::vector<std::string>& settings, int cells);
    void frame();
    void schedule(double took);
    void publish();
    void refuse(const std::string& why);

    const LiveOptions options;
    const double epoch;  // of the steady clock [s]
    std::atomic<std::shared_ptr<const LiveState>> published;
    std::atomic<std::shared_ptr<const ObjectPlaces>> found_places;
    std::atomic<bool> finding_places = false;

    std::mutex mutex;  // guards the members up to `cut_requests`
    std::condition_variable wake, done;
    std::deque<Task> tasks;
    long serial = 0;                // of the last command sent
    long posted = 1, finished = 0;  // tasks; the first is begin()
    std::exception_ptr unopened;    // why LiveOptions::session was not opened
    std::vector<AppliedCommand> applied;
    std::deque<HandFrame> incoming;
    std::atomic<bool> quit = false;
    std::atomic<int> cut_requests = 0;  // queued commands that cut the current frame

    // Used by the simulation's thread only.
    std::shared_ptr<const LiveScene> scene;
    std::unique_ptr<SimulationRun> run;
    IdSource ids;
    History past;
    std::unique_ptr<SessionWriter> writer;  // null: no log
    SessionLog events;                      // with LiveOptions::logs
    long frames = 0;                        // events of frames so far
    std::future<HashEvent> hashing;         // destroyed before the run
    std::shared_ptr<const std::vector<StepInfo>> step_list;
    long steps_version = 0;  // of the past, of `step_list`
    std::string saved_as, exported;
    int exports = 0, exports_waiting = 0;
    std::future<void> exporting;  // the last; each waits for the one before it
    int history = 0, refused = 0;
    long version = 0, answered = 0;
    std::string refusal, failure;
    bool paused = false, waiting = false;
    int steps = 0;          // frames still to compute while paused
    double stepped_to = 0;  // of a stepped session [s]
    double next = 0;        // when the next frame is due [s]
    double stored = 0;      // when the last state went to the log [s]
    // Clock time of overdue frames [s]: the session catches up with `backlog`, not with `dropped`.
    double backlog = 0, dropped = 0;
    std::future<PreparedObject> preparing;  // for the command at the head of the queue
    StopGracePeriod stopping;
    std::thread thread;
};

}  // namespace knead
