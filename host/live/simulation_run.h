// One run of a live scene, from a load or reset to the next: solver, loop, hands. Not thread-safe:
// used by the thread of a LiveSession only.
#pragma once
#include <future>
#include <memory>
#include <string>

#include "host/hands/motion.h"
#include "host/live/live_session.h"
#include "host/paging/scene_splats.h"
#include "host/scene/seed.h"

namespace knead {

class SimulationRun {
  public:
    // `began`: the session's time [s]. `should_cut`: called between substeps; true cuts the frame.
    // Throws as LiveOptions::make_solver.
    SimulationRun(std::shared_ptr<const LiveScene> scene, const LiveOptions& options, double began,
                  std::function<double()> now, const std::function<bool()>& should_cut);
    SimulationRun(const SimulationRun&) = delete;

    void push(const HandFrame& frame) { stream.push(frame); }
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

    void set_hands(const HandsOptions& options);
    void play(bool recorded);
    // Makes the edit now; rethrows its exceptions. `reshapes`: recompute the surface.
    void edit(const Edit& edit, bool reshapes);

    void set_surface(int nodes);  // along its longest side
    // The volume of the object is kept, also that of local clay.
    void set_material(int object, const Material<double>& material);

    // Fills the members of a state that describe the simulation.
    void publish(LiveState& state);
    const Simulator& of() const { return *solver; }
    double lost() const { return lost_time; }
    double period() const { return 1 / scene->scene.frame_rate; }             // [s]
    double simulated_period() const { return frame_duration(scene->scene); }  // [s]

  private:
    Motion motion(double from, double to);
    Motion pushed(double from, double to);
    void limit_tool_speed(Motion& motion) const;
    void after(const FrameResult& frame);
    void keep_splats(const FrameResult& frame);
    void clay_changed();
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
    Motion last;          // of the last frame
    bool last_valid = false;  // `last` is valid
    std::size_t particles = 0;
    std::vector<Material<double>> materials;      // of the scene's objects, before softening
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
    // Planned by a thread: splats to split and to add. Destroyed before the solver.
    long edits = 0, planned_edits = 0;  // edits made so far, and when the plan began
    std::future<UpkeepPlan> plan;
};

}  // namespace knead
