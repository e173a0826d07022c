// The session loop: whoever lets clay live through frames is a caller of it. One frame is
//
//     edits -> motion of the tools -> solver: submit, collect -> watchers
//
// The solver, and what the watchers and edits refer to, is the caller's and outlives the loop.
#pragma once
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "host/base/interrupt.h"
#include "host/hands/motion.h"
#include "host/scene/scene.h"
#include "host/surface/gpu_surface.h"

namespace knead {

enum class End { complete, interrupted, time_limit, substeps, numbers, device };

struct SessionLoopOptions {
    double duration = 0;  // simulated per frame [s]
    double rate = 0;      // frames per second of the hands' clock
    int first = 0;        // frame of the hands' clock at which the loop begins
    int done = 0;         // frames that an earlier loop did: numbers and times go on from there
    int frames = -1;      // negative: until it is stopped

    // What ends it is looked at before every frame and, on the CPU, between its substeps.
    double time_limit = 0;   // wall time [s]; 0: none
    long most_substeps = 0;  // of a frame; one that would need more is cut short there; 0: any
    std::function<bool()> interrupted = [] { return knead::interrupted() != 0; };
    // Asked between substeps on the CPU: true ends the frame there. The loop goes on with the next
    // one; what was left of the frame's time is lost to the simulation.
    std::function<bool(const FramePart&)> should_cut;
    // Told between substeps where the frame of that number stands.
    std::function<void(int number, const FramePart&)> part;

    std::vector<Material<double>> materials;  // for the surface
    SurfaceOptions surface{};
};
// The scene's clock, materials and surface.
SessionLoopOptions loop_options(const Scene& scene);

// Wall time of the parts of a frame, as the host sees it [s]. With frames handed over ahead, the
// solver's is what the host spends on it: handing over, and waiting for the end.
struct FrameTimes {
    double motion = 0, solver = 0, surface = 0;
    double watchers = 0;  // without the surfaces they ask for; complete after step()
};

struct Frame {
    int number = 0;        // from 1
    double simulated = 0;  // since the loop began, at the frame's end; shed time left out [s]
    double hand_time = 0;  // of the hands' clock, at the frame's end [s]
    Motion motion;
    FrameStats stats;
    FrameTimes times;
    long waits = 0;  // of the host for a device, while the frame was handed over
};

// Shared with whoever keeps them.
using State = std::shared_ptr<const std::vector<Particle<double>>>;
using Meshes = std::shared_ptr<const std::vector<Mesh>>;

using Watcher = std::function<void(const Frame&)>;
using Edit = std::function<void(Solver&)>;

// Whether the guards hide a fault instead of repairing it: more than a hundredth of the clay was
// put back in one frame.
bool overrun(const FrameStats& stats, std::size_t particles);

class SessionLoop {
  public:
    SessionLoop(Solver& solver, MotionSource motion, SessionLoopOptions options);
    SessionLoop(const SessionLoop&) = delete;
    ~SessionLoop() { solver.watch_frames({}); }

    // Called after every frame, in the order in which they were added. Not to be called by one.
    void watch(Watcher watcher) { watchers.push_back(std::move(watcher)); }

    // Done once, before the next frame's motion is asked for, with no frame under way: the frame
    // after the next where one has been handed over. It may change whatever the solver lets change.
    void edit(Edit edit) { edits.push_back(std::move(edit)); }

    // The edits that wait are made now. Throws std::logic_error while a frame is under way.
    void make_edits();

    // From now on every frame is handed over while the one before it is computed. Watchers then see
    // what a frame did, but cannot fetch the state: it is of no frame in particular.
    void hand_over_ahead() { ahead = true; }
    // From now on the surface of every frame is launched behind it; where the device makes it, the
    // host does not wait for it. `kept`: for device_mesh(), which then waits once.
    void launch_surfaces(bool kept = false);

    // Makes frames of `duration` [s] with these motions as step() would, and their surfaces, and
    // puts the solver's state back: graphs, memory and kernels are there when the first frame
    // begins. `meanwhile` is called after each. Nothing is watched, and nothing counts. Throws
    // std::logic_error while a frame is under way, and of a solver that keeps no snapshots.
    void rehearse(const std::vector<Motion>& frames, double duration,
                  const std::function<void()>& meanwhile);

    // Said by a watcher that has brought clay or taken some away, with no frame under way.
    void clay_edited();
    const std::vector<Material<double>>& materials() const { return options.materials; }
    // Surfaces are made by this rule from now on. Throws as clay_edited().
    void set_surface(const SurfaceOptions& surface);
    const SurfaceOptions& surface_options() const { return options.surface; }

    // No frame begins any more. Those under way end, and are watched. The first reason stands.
    void stop(End why = End::complete);

    // One frame; false where none is left to begin, or the solver failed.
    bool step();
    void run()
    {
        while (step()) {
        }
    }

    const Frame& last() const { return newest; }  // that was watched; number 0: none was
    End end() const { return ended.value_or(End::complete); }
    // What the solver threw, where that was the end. All frames before were watched.
    std::exception_ptr failure() const { return failed; }

    // The state at the end of the last frame, fetched when first asked for. Throws std::logic_error
    // while a frame is under way.
    State particles();
    // Its surface, made when first asked for; the same one stands while no clay moves.
    Meshes meshes();
    // The same, left on the device where the solver's clay is there; else, and without clay, null.
    std::shared_ptr<const DeviceMesh> device_mesh();
    bool meshes_stand() const { return last_meshes && moved == 0; }
    const GpuSurface* device_surface() const { return on_device.get(); }  // null: none was made

  private:
    void watch_frames();
    void look_for_end();
    bool may_begin();
    bool cuts(const FramePart& part);
    bool begin();
    bool collect();
    void shorten(Frame& f);
    void tell();
    void make_device_surface();
    void launch_surface(int frame);
    void renew_surfaces();

    Solver& solver;
    MotionSource motion;
    SessionLoopOptions options;
    std::vector<Watcher> watchers;
    std::vector<Edit> edits;

    Frame under_way[2];       // by turns
    Frame newest;             // of those that ended
    int begun = 0, done = 0;  // frames
    double lost = 0;          // simulated time that was shed [s]
    bool ahead = false, launching = false, keeping = false;
    int launched = -1;            // the frame whose kept surface was
    std::optional<double> began;  // at the first frame [s of the wall's clock]
    std::optional<End> ended;
    std::exception_ptr failed;

    State state;         // null: not fetched
    Meshes last_meshes;  // null: none
    SurfacePast past;    // of surfaces that are made on the host
    std::shared_ptr<const DeviceMesh> last_on_device;
    long moved = 0, moved_on_device = 0;  // particle-substeps since they were made
    std::unique_ptr<GpuSurface> on_device;
};

}  // namespace knead
