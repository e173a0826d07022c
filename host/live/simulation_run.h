// One history of a live scene, from its start or a reset to the next one: solver, loop, hands.
// Belongs to the thread of a LiveSession.
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
    // `began` is the session's time [s]. Throws what making the solver throws.
    // `stale` is asked between substeps: true ends the frame.
    SimulationRun(std::shared_ptr<const LiveScene> scene, const LiveOptions& options, double began,
                  std::function<double()> now, const std::function<bool()>& stale);
    SimulationRun(const SimulationRun&) = delete;

    void push(const HandFrame& frame) { stream.push(frame); }
    // One frame, and its surface where that is due, or `shown`. "", or why the simulation ended.
    std::string frame(bool shown);
    // In real time, before the first frame: see LiveSession.
    void rehearse();
    // The surface of the last frame, if it has none yet.
    void make_surface();
    double next_end() const;  // of the next frame, on the session's clock where that is stepped [s]
    // The session's time went on to `time` without this one.
    void skip_to(double time);

    void set_hands(const HandsOptions& options);
    void play(bool recorded);
    // Done now; throws what it throws. `reshapes`: there is another surface now.
    void edit(const Edit& edit, bool reshapes);

    // The object's volume stays; so does that of local clay.
    void set_surface(int nodes);  // along its longest side
    void set_material(int object, const Material<double>& material);

    // Fills what a state says of the simulation.
    void tell(LiveState& state);
    const Solver& of() const { return *solver; }
    double lost() const { return lost_time; }
    double period() const { return 1 / scene->scene.frame_rate; }             // [s]
    double simulated_period() const { return frame_duration(scene->scene); }  // [s]

  private:
    Motion motion(double from, double to);
    Motion pushed(double from, double to);
    void keep_up(Motion& motion) const;
    void after(const Frame& frame);
    void keep_splats(const Frame& frame);
    void clay_changed();
    void splats_changed();
    void adopt_plan(PagingReport& report);
    void begin_plan(int frame);
    void make_sources();
    void rehearse_frames(const Motion& away);
    void tell_gaussians(LiveState& state);
    void follow_gaussians();
    MotionStamp instant_after(const MotionStamp& before) const;

    const std::shared_ptr<const LiveScene> scene;
    const LiveOptions& options;
    const std::function<double()> now;
    std::unique_ptr<Solver> solver;
    SceneSplats splats;
    std::shared_ptr<const SplatCloud> drawn;  // of them; null: there are none
    long splat_version = 0;
    std::unique_ptr<SessionLoop> loop;
    HandsOptions hands;
    HandTools tools;
    HandStream stream;
    std::unique_ptr<HandSource> source;  // null: nothing was recorded
    MotionSource replay;                 // of it
    bool recorded;
    double skew;          // of the session's time over the loop's [s]
    double replayed = 0;  // when in the loop's time the recording began; later where it was held up
    double time = 0;      // of the session, at the last frame's end [s]
    double began = 0;     // the frame under way [s]
    Motion last;          // as it ended
    bool moved_on = false;  // there is a last motion
    std::size_t particles = 0;
    std::vector<Material<double>> materials;  // of the scene's objects, as they were given
    long cut = 0;
    double lost_time = 0;                         // of frames that were cut [s]
    Meshes meshes;                                // the last that were made
    std::shared_ptr<const DeviceMesh> on_device;  // or this
    int meshed = -1;                              // the frame that they are of
    GaussianKeeper gaussians;
    MotionStamp mesh_instant, gaussian_instant;
    struct {
        int frame = -1;
        long edits = -1, version = -1;
        std::shared_ptr<const std::vector<Gaussian<double>>> host, before;
        std::shared_ptr<const DeviceGaussians> device;
    } told;  // of Gaussians, by the last state
    long mesh_version = 0;
    double mesh_cost = 0, mesh_made = -1e30;  // [s]
    std::string trouble;
    // Of splats that are to be split and added, by a thread of its own; ends before the solver
    // does.
    long edits = 0, planned_edits = 0;  // made, and when the plan was begun
    std::future<UpkeepPlan> plan;
};

}  // namespace knead
