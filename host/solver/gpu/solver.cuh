// The GPU implementation of EditableSimulator: submission and results in solver.cu, the stages of a
// frame in frame.cu, growth of the stored box in region.cu, stage times in measure.cu, edits in
// solver_edits.cu, snapshots in snapshots.cu, the watchdog in watch.cu.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "cuda/device/graph.cuh"
#include "cuda/mpm/particle.h"
#include "cuda/surface/surface.cuh"
#include "host/solver/editable_simulator.h"
#include "host/solver/gpu/overlaps.h"
#include "host/solver/gpu/splats.cuh"
#include "host/solver/gpu/store.cuh"

namespace knead::gpu {

class GpuSolver : public EditableSimulator, private StageProfile {
  public:
    GpuSolver(const Setup& given, int device, RegionPadding room);
    FrameStats advance(const Motion& motion, double duration) override
    {
        submit(motion, duration);
        return collect();
    }
    void submit(const Motion& motion, double duration) override;
    FrameStats collect() override;
    std::vector<int> add_each(const Material<double>& material, Clays clays) override;
    void remove_each(std::span<const int> objects) override;
    void set_material(int object, const Material<double>& material) override;
    void move(int object, const RigidMotion<double>& motion) override;
    void attach(int object, const std::vector<Vec3<double>>& places) override;
    void set_gaussians(const std::vector<Gaussian<double>>& all) override;
    void edit_gaussians(const GaussianEdits& edits) override;
    void set_gravity(Vec3<double> gravity) override;
    void set_walls(const WallOptions& walls) override;
    void set_contact(const BodyContact& contact) override;
    void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools) override;
    const SimulationConfig& config() const override { return book->config(); }
    std::vector<int> piece_counts(std::span<const int> group, int groups) const override;
    std::shared_ptr<const Snapshot> snapshot() const override;
    void restore(const Snapshot& from) override;
    SnapshotData held(const Snapshot& snapshot) const override;
    SomeGaussians gaussians_of(const Snapshot& snapshot,
                               std::span<const int> objects) const override;
    ClayRows rows(const Snapshot& snapshot) const override;
    void replace(const SimulationConfig& config, const ClayRows& clay) override;
    void replace(const SimulationConfig& config, const InitialState& contents) override;
    SavedState saved(const Snapshot& snapshot) const override;
    void reserve_snapshots(int count) override;
    SavedState save() const override;
    void load(const SavedState& from) override;
    long version() const override { return changes; }
    std::size_t particle_count() const override { return std::size_t(store.count()); }
    std::vector<Particle<double>> particles() const override;
    std::vector<Gaussian<double>> gaussians() const override;
    std::vector<Vec3<double>> places(const Box3<double>& box) const override;
    std::vector<double> penetration() const override;
    std::vector<Vec3<double>> velocities() const override;
    const StageProfile* profile() const override { return this; }
    const Clay* clay() const override { return &shown; }
    const MovedGaussians* moved_gaussians() const override { return &splats.moved(); }
    std::size_t memory() const override
    {
        return store.bytes() + splats.bytes() + piece_space.bytes();
    }
    std::string name() const override { return title; }

  private:
    // No tool active, or the speed class of the tools as defined by clears_each_time().
    enum class ToolPace { none, slow, fast };
    struct Frame {
        Motion motion;
        double duration = 0;
        ToolPace tools = ToolPace::none;
        int welded_bodies = 0;
        Pinned<Clock> status;
        Event done{cudaEventDisableTiming};
    };
    const std::vector<StageTime>& times() const override;
    std::vector<StageWork> counts() const override;
    void capture();
    Graph& graph(ToolPace tools) { return graphs[int(tools)]; }
    void capture(ToolPace tools);
    void start(const Views& views, const Features& features);
    void follow(const Views& views, const Features& features, bool at_end,
                cudaStream_t stream) const;
    void substep(const Views& views, const Features& features, int place, bool begins,
                 cudaStream_t stream);
    Views views_for(const Features& features, ToolPace tools) const;
    ToolPace tool_speed_class(bool tools, const Motion& motion, double duration) const;
    Features features_for(bool tools) const;
    void show();
    void sort(const Views& views, const Features& features, cudaStream_t stream, int side) const;
    void sort_if_due(const Views& views, const Features& features);
    void step_through(ToolPace tools);
    void fit_graphs();
    void launch(int slot);
    void wait_for(int slot);
    void watch(int slot);
    void end_halt();
    void go_on(int slot);
    void walk(const StageObserver& watch) const;
    void pose_end(const Views& views) const;
    void finish_cuts(const Frame& frame);
    void check_idle() const;
    void adopt(const SceneState& rules);
    void wake(int object);
    void edited();
    void set_clock(Peak most, double apart);
    const GpuSnapshot& known(const Snapshot& snapshot) const;
    const GpuSnapshot& complete(const Snapshot& snapshot) const;
    template <class R>
    void replace_by(SceneState&& next, const std::vector<Gaussian<R>>& gaussians,
                    const std::function<void()>& put);

    // Identifies this solver in its snapshots, by address.
    std::shared_ptr<const char> identity = std::make_shared<const char>();
    std::shared_ptr<const SceneState> book;  // shared with snapshots
    int device, processors;
    Store store;
    Splats splats;
    Stream main, body, asking, reading;  // reading: copies from snapshots, by any thread
    Clay shown{};
    int side = 0;       // of Clock: which particle buffer is current
    Peak peak;          // of Clock
    double drift;       // of Clock [m]
    long changes = 0;   // version(): frames and edits
    bool stale = true;  // the graphs were captured with outdated views
    std::string title;
    Graph graphs[3];  // by ToolPace
    Frame frames[2];  // in flight or free
    int submitted = 0, collected = 0;
    bool halted = false;   // Clock::halt is set
    bool was_cut = false;  // the last collected frame
    Pinned<Clock> seen;    // progress, polled during a frame
    Pinned<int> halt;
    bool posed = false;                          // the masks are those of the end of the last frame
    const unsigned overlaps = allowed_overlaps;  // see overlap.h
    bool stepwise = false;     // no graph: KNEAD_GRAPH=0, for profilers and memory checkers
    bool was_covered = false;  // a blade was in the clay at the end of the last frame
    int last_substeps = 0;
    int usual_substeps = 0, misfits = 0;  // substeps of the graphs; consecutive frames that deviate
    struct PieceSpace {                   // of piece_counts(); allocated when it is first called
        DeviceArray<unsigned long long> keys, sums;
        DeviceArray<int> parents, sizes, counts, group;
        std::size_t bytes() const
        {
            return keys.bytes() + sums.bytes() + parents.bytes() + sizes.bytes() + counts.bytes() +
                   group.bytes();
        }
    };
    mutable PieceSpace piece_space;
    mutable std::vector<StageTime> stage_times;  // empty: not measured for the last frame
};

}  // namespace knead::gpu
