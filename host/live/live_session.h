// A live session: a scene is simulated on a thread of its own, moved by hands as they come, changed
// by commands, and seen through states that never change once they are published. Windows and
// headsets draw these; none of them waits for the simulation.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/assets/splat_object.h"
#include "host/base/machine.h"
#include "host/hands/recording.h"
#include "host/session/hand_actions.h"
#include "host/session/loop.h"
#include "host/splats/cloud.h"
#include "host/splats/device_gaussians.h"
#include "render/painter.h"

namespace knead {

// A scene with all that was loaded for it.
struct LiveScene {
    Scene scene;                         // built
    std::vector<SplatObject> splats;     // of its objects
    std::optional<Recording> recording;  // of the hands that it names
    std::vector<std::string> settings;   // with which it was read
};
// As `knead run` loads it. `memory` [bytes], 0: what is free. Throws InputError, MemoryError.
std::shared_ptr<const LiveScene> load_live_scene(const std::string& path,
                                                 const std::vector<std::string>& settings = {},
                                                 std::size_t memory = 0);
// Those of `settings`, in their order, with which the scene at `path` can be read; the others go to
// `left_out`. Throws InputError where it cannot be read at all.
std::vector<std::string> fitting_settings(const std::string& path,
                                          const std::vector<std::string>& settings,
                                          std::vector<std::string>& left_out);
// Categories of clay in whose place splats are drawn.
std::vector<int> splat_categories(const Scene& scene);

struct LiveOptions {
    std::function<std::unique_ptr<Solver>(const Setup&)> make;  // the solver of a scene
    // Time passes as the caller says, by advance_to(): frames are whole, and the same hands give
    // the same bits. Otherwise it is real time.
    bool stepped = false;
    bool from_zero = false;  // then: the caller's time is 0 again at a reset, and where one loads
    // True: no other frame begins, and the one under way, if it takes a quarter of a second more,
    // ends between two substeps.
    std::function<bool()> stop;
    // What follows is of real time alone.
    std::function<double()> clock;  // [s], rising; null: since the session began
    double budget = 0;       // what a frame may take on the clock [s]; 0: the time to the next one
    double fastest = 3;      // a tool follows its hand at so many real metres a second of simulated
                             // time at most; 0: any
    bool recorded = true;    // begins with the scene's recorded hands
    bool paused = false;     // begins paused
    bool waits = false;      // no frame begins before start(), nor rehearses by itself
    bool on_device = false;  // surfaces and Gaussians stay where a device made them
    bool moving = false;     // it is told how surfaces move
    std::size_t memory = 0;  // [bytes] that a scene which is loaded may take; 0: what is free
    // Told of what is done beside hands, by whoever asks for it: set_hands(), set_gravity(),
    // set_material(), move_clay().
    std::function<void(const HandAction&)> acted;
    // Called on the simulation's thread after each state that is published.
    std::function<void()> published;
};

// One tool as the simulation had it at the end of a frame.
struct LiveTool {
    Side side;
    std::string held;  // "" the bare hand
    bool active;       // touches clay
    float size;        // the share of its radii that it has
    std::vector<DrawPrimitive> primitives;
};

// When what moves was where a state has it, by the time of the hands that moved it. A display shows
// it later.
struct MotionStamp {
    double time = 0;  // of the session [s]
    double step = 0;  // since the one before [s]; 0: nothing is known of how it moves
    // The share of its way since the one before by which it has gone on until `now`, if it goes on
    // as it came; 1 at most.
    float extrapolation(double now) const;
};

// What falls behind when the machine is too slow.
struct Backlog {
    long frames = 0;    // that were cut short between two substeps
    double behind = 0;  // of simulated time, that was not made up for [s]
};

// The simulation at the end of a frame, an edit or a command. Never changes.
struct LiveState {
    std::shared_ptr<const LiveScene> scene;  // null: none was loaded
    int history = 0;                         // rises when a scene is loaded, and with every reset
    long version = 0;                        // of this state: rises with every one
    double time = 0;                         // of the session, at the frame's end [s]
    Frame frame;  // the last: number, statistics, times, and the joints of all tools
    std::vector<StageTime> stages;  // of the last frame; empty where they cost more than it
    // The surface: null, or one of these. Both null: none was made.
    Meshes meshes;
    std::shared_ptr<const DeviceMesh> on_device;
    long mesh_version = 0;     // rises when it changes
    MotionStamp mesh_instant;  // where LiveOptions::moving
    SurfaceOptions surface;    // by which it is made
    // Where Gaussians are: null, or one of these. Both null: the scene has none.
    std::shared_ptr<const std::vector<Gaussian<double>>> gaussians;
    std::shared_ptr<const DeviceGaussians> gaussians_on_device;
    std::shared_ptr<const std::vector<Gaussian<double>>> gaussians_before;  // null: not known
    MotionStamp gaussian_instant;
    // In the order of the Gaussians, then those that stand still. Null: the scene has none.
    std::shared_ptr<const SplatCloud> splats;
    long splat_version = 0;  // rises when they change: were split, added, taken up, laid down
    std::vector<LiveTool> tools;
    HandsOptions hands;                       // which tools there are
    std::vector<Material<double>> materials;  // of the scene's objects, as they were given
    bool recorded = false, paused = false;
    double recording_time = 0;  // of the scene's recorded hands, at the frame's end [s]
    Backlog backlog;
    std::string solver;   // its name
    std::string trouble;  // why the simulation has ended; "": it has not
    int refused = 0;      // commands that could not be done
    std::string refusal;  // why not the last of them
};

// The surface on the host; fetched where it is on a device, which waits. Never null.
Meshes meshes_of(const LiveState& state);

// What of a session's clay is compared with a run's.
struct ClayDigest {
    std::string hash;  // of its state; "": there is no simulation
    long particles = 0;
};

class SimulationRun;

// A frame that is cut is of no recording: the same hands do not bring the clay there again. So one
// that is stopped has a quarter of a second to end.
class StopPatience {
  public:
    bool cuts(bool stopped)
    {
        constexpr double longest = 0.25;  // [s]
        if (!stopped) return false;
        if (since == 0) since = wall_seconds();
        return wall_seconds() - since > longest;
    }

  private:
    double since = 0;  // of the wall [s]; 0: it is not stopped
};

class LiveSession {
  public:
    // Simulates `scene`, which may be null, from now on. Nothing that goes wrong with it is thrown:
    // the state says it.
    LiveSession(std::shared_ptr<const LiveScene> scene, LiveOptions options);
    ~LiveSession();  // between two substeps
    LiveSession(const LiveSession&) = delete;

    // All that follows may be called by any thread.
    std::shared_ptr<const LiveState> state() const { return published.load(); }
    double now() const;  // [s] of the session: what hands are stamped with
    // Tracked hands, in the tracker's frame; times rise. The oldest of more than a thousand that
    // wait are dropped.
    void push(const HandFrame& hands);

    // Makes some frames that nobody sees, and puts the state back: what is made once is there when
    // the first begins. In real time alone; without LiveOptions::waits that is done with each
    // scene.
    void rehearse();
    // Frames are due from now on, where LiveOptions::waits.
    void start();

    // Commands are done in their order, between frames. A reset and a load end the frame under way.
    void pause(bool paused);
    void step(int frames = 1);  // while paused
    void reset();
    void load(std::shared_ptr<const LiveScene> scene);
    // `cells` along the longest axis of its domain; 0: the scene's. A setting that this scene does
    // not take is left out, and the state's refusal says so.
    void load(const std::string& path, const std::vector<std::string>& settings, int cells = 0);
    // Which tools the hands are or hold. The scene's clay stays as it is.
    void set_hands(const HandsOptions& hands);
    void play(bool recorded);  // the scene's recorded hands, from their start; or those pushed
    void set_gravity(Vec3<double> gravity);  // [m/s^2]
    // The object's volume stays, its mass is that times the density.
    void set_material(int object, const Material<double>& material);
    // So many nodes of the surface's lattice along its longest side, 8 to 1024.
    void set_surface(int nodes);
    void move_clay(int object, const RigidMotion<double>& motion);
    // What it throws is a refusal, and must leave the solver as it was.
    void edit(Edit edit) { edit_clay(std::move(edit), true); }

    // Waits until all commands so far are done.
    void settle();
    // The same after `look` has seen the solver; false where there is none.
    bool ask(const std::function<void(const Solver&)>& look);
    ClayDigest digest();
    // Of a stepped session: simulates all frames that end at `time` [s] or before, and waits for
    // them. Throws std::logic_error in real time.
    void advance_to(double time);

  private:
    using Command = std::function<void()>;
    void post(Command command, bool at_once = false);
    void tell(HandAction action, ActionType act) const;
    void edit_clay(Edit edit, bool reshapes);
    void live();
    bool wait_for_work(std::unique_lock<std::mutex>& lock);
    bool stopped() const { return options.stop && options.stop(); }
    void begin(std::shared_ptr<const LiveScene> scene);
    void begin_file(const std::string& path, const std::vector<std::string>& settings, int cells);
    void frame();
    void schedule(double took);
    void publish();
    void refuse(const std::string& why);

    const LiveOptions options;
    const double epoch;  // of the steady clock [s]
    std::atomic<std::shared_ptr<const LiveState>> published;

    std::mutex mutex;  // of what follows, up to the thread's own
    std::condition_variable wake, done;
    std::deque<Command> commands;
    long posted = 1, finished = 0;  // commands; the first is to begin
    std::deque<HandFrame> incoming;
    std::atomic<bool> quit = false;
    std::atomic<int> hurry = 0;  // commands for whose sake a frame is not worth its end

    // Of the simulation's thread.
    std::shared_ptr<const LiveScene> scene;
    std::unique_ptr<SimulationRun> run;
    int history = 0, refused = 0;
    long version = 0;
    std::string refusal, trouble;
    bool paused = false, waiting = false;
    int steps = 0;          // frames to do though paused
    double stepped_to = 0;  // of a stepped session [s]
    double next = 0;        // when the next frame is due [s]
    // Frames that were due too fast, as time [s of the clock]: those that are made up for when
    // there is time, and those that are not.
    double backlog = 0, dropped = 0;
    StopPatience stopping;
    std::thread thread;
};

}  // namespace knead
