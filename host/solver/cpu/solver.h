// The CPU solver. Its loops are in solver.cpp, those for walls and cuts in cut.cpp, Gaussians in
// splats.cpp, edits in edit.cpp.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "cuda/math/node4.h"
#include "cuda/mpm/lag.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/project.h"
#include "cuda/mpm/walls.h"
#include "host/base/machine.h"
#include "host/base/parallel.h"
#include "host/solver/bodies.h"
#include "host/solver/cpu/bins.h"
#include "host/solver/cpu/rows.h"
#include "host/solver/cpu/sleep.h"
#include "host/solver/cpu/tools.h"
#include "host/solver/edits.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

enum StageName {
    stage_pose,
    stage_bin,
    stage_p2g,
    stage_grid,
    stage_g2p,
    stage_project,
    stage_plasticity,
    stage_deform,  // only with Gaussians
    stage_count
};

// What one thread counts and measures during a frame.
struct ThreadStats {
    Counts<long> counts{};
    std::uint32_t touched = 0;
    bool splats_moved = false;
    double depth = 0, speed_squared = 0, stiffness = 0;
    double seconds[stage_count] = {};

    long& operator[](Count c) { return counts[c]; }
    void add(const ThreadStats& t)
    {
        counts += t.counts, touched |= t.touched;
        depth = std::max(depth, t.depth), speed_squared = std::max(speed_squared, t.speed_squared);
        stiffness = std::max(stiffness, t.stiffness);
        for (int s = 0; s < stage_count; ++s) seconds[s] += t.seconds[s];
    }
    // `skin`: offset of the projection (19), subtracted from the depth [m].
    void put_into(FrameStats& stats, double skin) const
    {
        stats.counts += counts, stats.touched = touched;
        stats.found_depth = std::max(0.0, depth - skin);
    }
};

// Particles by id; Gaussians in the order of attachment.
template <class R>
std::vector<Particle<double>> in_double(const std::vector<Particle<R>>& q,
                                        const std::vector<int>& ids)
{
    std::vector<Particle<double>> all(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) {
        Particle<double>& one = all[std::size_t(ids[i])] = cast<double>(q[i]);
        one.hold(false);
    }
    return all;
}
template <class R>
std::vector<Gaussian<double>> in_double(const std::vector<Gaussian<R>>& splats)
{
    std::vector<Gaussian<double>> all;
    for (Gaussian<R> g : splats) {
        g.hold(false);
        all.push_back(cast<double>(g));
    }
    return all;
}

template <class R>
struct CpuSnapshot;

template <class R>
class CpuSolver : public EditableSimulator, private StageProfile {
  public:
    explicit CpuSolver(const Setup& given);
    FrameStats advance(const Motion& motion, double duration) override;
    std::vector<int> add_each(const Material<double>& material, Clays clays) override;
    void remove_each(std::span<const int> objects) override;
    void set_material(int object, const Material<double>& material) override;
    void move(int object, const RigidMotion<double>& motion) override;
    void attach(int object, const std::vector<Vec3<double>>& places) override;
    void set_gaussians(const std::vector<Gaussian<double>>& all) override;
    void edit_gaussians(const GaussianEdits& edits) override;
    void set_gravity(Vec3<double> to) override;
    void set_walls(const WallOptions& to) override;
    void set_contact(const BodyContact& to) override;
    void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools) override;
    const SimulationConfig& config() const override { return book.config(); }
    std::vector<int> piece_counts(std::span<const int> group, int groups) const override;
    std::shared_ptr<const Snapshot> snapshot() const override;
    SnapshotData held(const Snapshot& snapshot) const override;
    void restore(const Snapshot& from) override;
    ClayRows rows(const Snapshot& snapshot) const override;
    void replace(const SimulationConfig& config, const ClayRows& clay) override;
    void replace(const SimulationConfig& config, const InitialState& contents) override;
    SavedState saved(const Snapshot& snapshot) const override;
    SavedState save() const override { return saved(*snapshot()); }
    void load(const SavedState& state) override;
    long version() const override { return changes; }
    std::size_t particle_count() const override { return q.size(); }
    std::vector<Particle<double>> particles() const override;
    std::vector<Gaussian<double>> gaussians() const override;
    std::vector<double> penetration() const override;
    std::vector<Vec3<double>> velocities() const override;
    const StageProfile* profile() const override { return this; }
    std::size_t memory() const override;
    std::string name() const override
    {
        return std::string("cpu ") + (sizeof(R) == 4 ? "float" : "double") + ", " +
               std::to_string(Lanes<R>::count) + " lanes, " + std::to_string(threads) + " threads";
    }

  private:
    const std::vector<StageTime>& times() const override { return stage_times; }
    void edited();
    Extremes extremes() const;
    // State of a particle before its substep, needed by repair().
    struct Start {
        Vec3<R> x;
        std::uint32_t sides;
    };
    using Sums = std::vector<Tile<R>>;
    void p2g(R dt);
    void grid_update(R dt);
    bool beside_wall(Int3 corner) const;
    MirrorSet updated(Int3 node, R mass) const;
    void update_mirror_set(int b, Int3 node, Int3 across, R dt, ThreadStats& stats);
    void split_update(int b, R dt, ThreadStats& stats);
    SlidingInArray<R> slides(int field) { return {sliding[field].data(), lattice.dx, substeps}; }
    void g2p(R dt);
    void share_pressure(int slot, Bins::Members members);
    const CpuSnapshot<R>& known(const Snapshot& snapshot) const;
    void arrange_splats();
    void time_deform(bool on);
    // Calls visit(g) for each Gaussian that was in block b at the beginning of the frame.
    template <class Visit>
    void for_each_splat(int b, Visit&& visit)
    {
        if (splats.empty()) return;
        const auto from = splats_before.begin() + b;
        for (int i = from[0]; i < from[1]; ++i)
            visit(splats[std::size_t(splat_order[std::size_t(i)])]);
    }
    void deform(const Lag& lag, bool clear);
    void take_extremes()  // after a substep, for the dt of a later one
    {
        most = {};
        for (ThreadStats& t : thread_stats) {
            most.speed = std::max(most.speed, std::sqrt(t.speed_squared));
            most.stiffness = std::max(most.stiffness, t.stiffness);
            t.speed_squared = t.stiffness = 0;
        }
    }
    void update_activity(const Motion& motion);
    Bins::Members movers_among(Bins::Members members, std::vector<int>& movers) const;
    bool pushes(int slot, R dt, const Tile<R>* tiles) const;
    void wake_roused(FrameStats& stats);
    Node<R> summed(const Sums& sums, Int3 node) const;
    void scatter_cut(int slot, R dt);
    void load_tile(const std::vector<Node<R>>& from, Int3 block, Tile<R>& tile) const;
    void sum_block(Int3 block, Node<R>* sum) const;
    void step_particles(int slot, Bins::Members members, R dt, const Tile<R>* tiles,
                        ThreadStats& stats);
    bool keep_out(const Group<R>& group, const Each<R>& per_cell, int block, R dt, Each<R>& depth,
                  ThreadStats& stats);
    void note_blocks(const Group<R>& group, const Vec3<Lanes<R>>& place);
    template <class Visit>
    void for_each_group(Bins::Members members, Visit&& visit);
    // Number of velocity fields in split blocks.
    int field_count() const { return bodies.colours > 0 ? bodies.fields() : posed.blades ? 3 : 1; }
    // The field of clay of an object with this label.
    std::uint32_t field_of(int object, std::uint32_t label) const
    {
        return bodies.colours > 0 ? std::uint32_t(bodies.field_of(object, label)) : label;
    }
    void separate(Int3 n, Node<R>* fields, R dt) const;
    bool find_splits();
    bool recolour();
    void finish_bodies(FrameStats& stats);
    std::uint32_t sliced_side(const Node<R> (&v)[most_fields][8], int field) const;
    void finish_cuts(bool covered);
    template <class Body>
    void for_each(int count, StageName stage, Body&& body);
    void apply_config();
    struct Backup;
    template <class Change>
    void all_or_nothing(std::vector<Particle<R>> clay, std::vector<int> order, Change&& change);
    template <class Change>
    void edit_by_id(Change&& change);
    void replace_by(SceneState&& next, std::vector<Particle<R>>&& clay,
                    std::vector<Gaussian<R>>&& gaussians);
    std::vector<SlidingNode> sliding_now() const;
    void slide_on(const std::vector<SlidingNode>& nodes);
    void renumber();
    void wake(const Particle<R>& particle);
    template <class Edit>
    void edit(int object, Edit&& edit);

    // Identifies this solver in its snapshots, by address.
    std::shared_ptr<const char> identity = std::make_shared<const char>();
    SceneState book;
    const SimulationConfig& scene = book.config();
    Lattice<R> lattice;
    Walls<R> walls;
    Vec3<R> gravity;
    int threads;
    std::vector<Material<R>> materials;
    bool shared_pressure = false;  // some material has it
    Bodies bodies;
    BodyFields<R> body_constants{};
    PosedTools<R> posed;
    PushoutLimits<R> pushout{};
    Stillness<R> stillness;
    std::vector<Particle<R>> q;  // in the order of the last sort by block
    std::vector<int> ids;        // original index of q[i]
    Bins bins;
    bool arranged = false;            // no particle has moved since the last sort
    std::vector<Gaussian<R>> splats;  // in the order of attachment
    // Indices into splats, sorted by block at the beginning of the frame; splats_before[b] of them
    // are in blocks before b.
    std::vector<int> splat_order, splats_before, splat_blocks;
    bool splats_arranged = false;  // no Gaussian has moved since
    // Velocity fields: all clay; near a blade (25) one per label, of uncut clay and clay with this
    // label; where bodies are close (25a) one per colour, and with blades three.
    Sums sums[most_fields];                        // one tile per occupied block
    std::vector<Node<R>> grid[most_fields];        // node_count velocities
    std::vector<Sliding<R>> sliding[most_fields];  // at walls, see sliding.h
    int substeps = 1;                              // number of substeps so far, plus one
    std::vector<char> split;   // per block: nodes have all fields; empty if there is one
    bool was_covered = false;  // a blade was in the clay at the end of the last frame
    Extremes most{};           // of the clay after the last substep
    long changes = 0;          // version(): frames and edits
    std::vector<ThreadStats> thread_stats;
    std::vector<StageTime> stage_times;
};

// Sum at node n over the tiles of up to eight blocks whose particles reach it.
template <class R>
Node<R> CpuSolver<R>::summed(const Sums& tiles, Int3 n) const
{
    const Int3 b = {n.x >> 2, n.y >> 2, n.z >> 2}, l = {n.x & 3, n.y & 3, n.z & 3};
    Node<R> sum{};
    for (int z = 0; z <= (l.z < 2); ++z)
        for (int y = 0; y <= (l.y < 2); ++y)
            for (int x = 0; x <= (l.x < 2); ++x) {
                const Int3 from = b - Int3{x, y, z};
                if (from.x < 0 || from.y < 0 || from.z < 0) continue;
                const int slot = bins.slot[std::size_t(lattice.block_of(4 * from))];
                if (slot < 0) continue;
                const Node<R>& share =
                    tiles[std::size_t(slot)].node[tile_index(l + 4 * Int3{x, y, z})];
                sum = node(four(sum) + four(share));
            }
    return sum;
}

// True if a block has nodes at or behind a wall, or particles that may get behind one in a substep,
// in which they move by less than a cell.
template <class R>
bool CpuSolver<R>::beside_wall(Int3 corner) const
{
    const auto near = [](int from, int first, int free) {
        return from <= first || from + 6 >= first + free;
    };
    return near(corner.x, walls.first.x, walls.free.x) ||
           near(corner.y, walls.first.y, walls.free.y) ||
           near(corner.z, walls.first.z, walls.free.z);
}

// Runs body(i, statistics of the thread) for i in [0, count) on all threads; adds the wall time to
// the stage.
template <class R>
template <class Body>
void CpuSolver<R>::for_each(int count, StageName stage, Body&& body)
{
    const double start = wall_seconds();
    parallel_for(count, LoopOptions{.threads = threads, .chunk = 4},
                 [&](int i, int thread) { body(i, thread_stats[std::size_t(thread)]); });
    stage_times[stage].seconds += wall_seconds() - start;
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
