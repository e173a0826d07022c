#include "host/run/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/hands/recording.h"
#include "host/solver/between.h"

namespace knead {
namespace {

// From simulation coordinates to those of the scene's file.
std::vector<Particle<double>> moved_out(const Scene& scene, std::vector<Particle<double>> clay)
{
    for (Particle<double>& q : clay) q.x = q.x + scene.origin;
    return clay;
}
std::vector<Mesh> moved_out(const Scene& scene, std::vector<Mesh> meshes)
{
    move_by(meshes, scene.origin);
    return meshes;
}

// The watchers of the loop; each fills its part of the frame's row.
class Run {
  public:
    Run(const Scene& scene_, Simulator& solver_, SessionLoop& loop_,
        const BatchRunOptions& options_)
        : scene(scene_), solver(solver_), loop(loop_), options(options_)
    {
    }

    // Before the first frame.
    void start()
    {
        record.last_good = loop.particles();
        record.particles = record.last_good->size();
        if (!record.rows.empty()) return;  // resumed
        record.first = audit(*record.last_good, scene.setup.materials, scene.setup.lattice.dx);
        if (options.mesh_every == 0 && options.meshes_every == 0 && !options.last_mesh) return;
        FrameRow before;
        mesh(before);
        record.first_mesh_volume = before.mesh_volume;
    }

    void add_row(const FrameResult& f)
    {
        FrameRow row;
        row.frame = f.number;
        row.simulated = f.simulated, row.hand_time = f.hand_time;
        row.hands = any_active(f.motion);
        row.wall = f.times.solver, row.hands_wall = f.times.motion;
        row.stats = f.stats;
        record.rows.push_back(row);
    }

    // Stops the loop if the state is no longer sound.
    void check(const FrameResult& f)
    {
        const bool bad = state_invalid(f.stats, record.particles);
        if (bad)
            record.failure = fmt::format("frame {}: {} particles had to be reset", f.number,
                                         f.stats[Count::repaired]);
        const bool due =
            is_last(f) || f.number == 1 || f.number % std::max(1, options.audit_every) == 0;
        if (bad || (due && !audit_row(record.rows.back()))) loop.stop(End::numerical_failure);
    }

    void make_surface(const FrameResult& f)
    {
        const bool wanted =
            shown(f) || due(f, options.meshes_every) || (is_last(f) && options.last_mesh);
        if (wanted && loop.end() != End::numerical_failure) mesh(record.rows.back());
    }
    static bool due(const FrameResult& f, int every) { return every > 0 && f.number % every == 0; }
    bool shown(const FrameResult& f) const { return due(f, options.mesh_every); }

    // Calls the consumers of meshes and particles in frames where they are due.
    void hand_out(const FrameResult& f, const RunObserver& watch)
    {
        if (loop.end() == End::numerical_failure || f.stats.cut) return;
        if (watch.meshes && due(f, options.meshes_every) && record.rows.back().meshed)
            watch.meshes(f.number, moved_out(scene, *loop.meshes()));
        if (watch.particles && due(f, options.particles_every))
            watch.particles(f.number, moved_out(scene, *loop.particles()));
    }

    // Whether a later run can resume from this state.
    bool may_go_on(const FrameResult& f) const
    {
        const End end = loop.end();
        return f.number > 0 && !is_last(f) && !f.stats.cut && end != End::numerical_failure &&
               end != End::device;
    }

    // Audits the last frame, however the loop ended, and meshes it if requested.
    void finish()
    {
        record.end = loop.end();
        record.left = record.depths.summary();
        if (record.end == End::device) return;
        record.bytes = solver.memory();
        if (record.rows.empty() || record.end == End::numerical_failure) return;
        FrameRow& last = record.rows.back();
        if (!last.audited && !audit_row(last)) {
            record.end = End::numerical_failure;
            return;
        }
        if (options.last_mesh && !last.meshed) mesh(last);
    }

    // A picture that fails is counted; the run continues.
    void show(const FrameResult& f, const std::vector<Mesh>& meshes, const RunObserver& watch)
    {
        try {
            watch.picture(f, meshes);
        } catch (const PictureError& e) {
            if (record.pictures_missing++ > 0) return;
            record.no_picture = fmt::format("of frame {}: {}", f.number, e.what());
            std::fprintf(stderr, "knead: no picture %s\n", record.no_picture.c_str());
        }
    }

    RunRecord record;

  private:
    bool is_last(const FrameResult& f) const { return f.number == record.frames_wanted; }

    // Audits the state; false if it holds non-finite numbers.
    bool audit_row(FrameRow& row)
    {
        const SharedParticles now = loop.particles();
        row.audited = true;
        row.state = audit(*now, loop.materials(), scene.setup.lattice.dx, solver.velocities());
        row.crowding = crowding(*now, loop.materials(), scene.setup.lattice.dx);
        record.particles = std::max(record.particles, now->size());
        row.stages = stage_times(solver);
        const std::vector<double> inside = solver.penetration();
        record.depths.add(inside);
        row.left = depths_of(inside);
        if (!inside.empty())
            row.between = depths_of(depths_between(scene.setup, loop.last().motion, *now));
        if (row.state.broken > 0) {
            record.failure =
                fmt::format("frame {}: {} particles are not numbers", row.frame, row.state.broken);
            return false;
        }
        record.last_good = now;
        return true;
    }

    void mesh(FrameRow& row)
    {
        row.kept = loop.meshes_current();
        record.meshes = loop.meshes();
        row.surface_wall = loop.last().times.surface;
        row.meshed = true;
        for (const Mesh& m : *record.meshes) {
            row.mesh_volume += volume(m);
            row.triangles += long(m.triangles.size());
        }
    }

    const Scene& scene;
    Simulator& solver;
    SessionLoop& loop;
    const BatchRunOptions& options;
};

// Writes checkpoints: the solver's state between two frames, and the record at that time.
class Keeper {
  public:
    Keeper(EditableSimulator* solver_, Run& run_, const BatchRunOptions& options_,
           const RunObserver& watch_)
        : solver(solver_), run(run_), options(options_), watch(watch_), before(run.record.wall)
    {
    }

    double wall() const
    {
        return before + wall_seconds() - begin;
    }  // including an earlier run's [s]

    void after(const FrameResult& f)
    {
        if (!run.may_go_on(f)) return;
        // Begins early by the duration of the last write, so that it is complete when due.
        if (wall_seconds() - saved + took >= options.checkpoint) keep(run.record);
        // Frames are cut short on the CPU only, where snapshots are cheap.
        if (!solver->clay()) whole = solver->snapshot(), depths = run.record.depths;
    }

    // At the end of a stopped run. A frame that was cut short is recomputed by the later run.
    void end(const FrameResult& last)
    {
        const End why = run.record.end;
        if (why != End::interrupted && why != End::time_limit) return;
        if (run.may_go_on(last)) return keep(run.record);
        if (!last.stats.cut || !whole) return;
        RunRecord until = run.record;
        until.rows.pop_back(), until.depths = depths;
        solver->restore(*whole);
        keep(until);
    }

  private:
    void keep(RunRecord& record)
    {
        record.wall = wall();
        saved = wall_seconds();
        watch.checkpoint(record);
        took = wall_seconds() - saved;
    }

    EditableSimulator* const solver;  // null: keeps none
    Run& run;
    const BatchRunOptions& options;
    const RunObserver& watch;
    const double before;
    const double begin = wall_seconds();
    double saved = begin, took = 0;         // last checkpoint: when, and how long it took [s]
    std::shared_ptr<const Snapshot> whole;  // after the last complete frame
    DepthCount depths;                      // at that time
};

// Transforms all positions of a record to the coordinates of the scene's file.
void move_out(const Scene& scene, RunRecord& record)
{
    const Vec3<double> by = scene.origin;
    if (dot(by, by) == 0) return;
    if (record.last_good)
        record.last_good = std::make_shared<const std::vector<Particle<double>>>(
            moved_out(scene, *record.last_good));
    if (record.meshes)
        record.meshes = std::make_shared<const std::vector<Mesh>>(moved_out(scene, *record.meshes));
    const auto turn = [by](Audit& state) { state.spin = state.spin + cross(by, state.momentum); };
    turn(record.first);
    for (FrameRow& row : record.rows)
        if (row.audited) turn(row.state);
}

// Message of the device error that ended the loop; rethrows other exceptions.
std::string failure_text(const SessionLoop& loop)
{
    try {
        std::rethrow_exception(loop.failure());
    } catch (const std::runtime_error& e) {
        return fmt::format("frame {}: {}", loop.last().number + 1, e.what());
    }
}

}  // namespace

int frames_wanted(const Scene& scene, const HandSource* hands, int requested)
{
    if (requested > 0) return requested;
    if (scene.frames > 0) return scene.frames;
    const double seconds = hands ? hands->duration() : 1.0;
    return int(std::clamp(std::ceil(seconds * scene.frame_rate - 1e-6), 1.0, 1e7));
}

RunRecord run_frames(const Scene& scene, Simulator& solver, const HandSource* hands,
                     const BatchRunOptions& options, const RunObserver& watch,
                     const RunRecord* earlier)
{
    SessionLoopOptions by = loop_options(scene);
    by.frames = frames_wanted(scene, hands, options.frames);
    by.time_limit = options.time_limit;
    by.whole_frames = options.whole_frames;
    by.most_substeps = scene.most_substeps;
    by.on_progress = watch.on_progress;
    if (earlier) by.frames_before = int(earlier->rows.size());
    by.interrupted = [&] { return interrupted() || (watch.stop && watch.stop()); };
    SessionLoop loop(solver, watch.motion ? watch.motion : recorded_motion(hands, scene.hands), by);
    Run run(scene, solver, loop, options);
    if (earlier) run.record = *earlier;
    run.record.frames_wanted = by.frames;
    run.record.duration = by.duration;
    loop.observe([&](const FrameResult& f) { run.add_row(f); });
    loop.observe([&](const FrameResult& f) { run.check(f); });
    loop.observe([&](const FrameResult& f) {
        if (!watch.upkeep || f.stats.cut || loop.end() == End::numerical_failure) return;
        PagingReport& report = run.record.rows.back();
        report = watch.upkeep(f);
        if (report.clay_changed()) loop.clay_edited();
    });
    loop.observe([&](const FrameResult& f) { run.make_surface(f); });
    if (watch.frame) loop.observe([&](const FrameResult&) { watch.frame(run.record.rows.back()); });
    if (watch.picture)
        loop.observe([&](const FrameResult& f) {
            if (run.shown(f) && run.record.rows.back().meshed) run.show(f, *loop.meshes(), watch);
        });
    loop.observe([&](const FrameResult& f) { run.hand_out(f, watch); });
    Keeper keeper(solver.editable(), run, options, watch);
    if (watch.checkpoint) loop.observe([&](const FrameResult& f) { keeper.after(f); });
    if (watch.edits) loop.observe([&](const FrameResult& f) { watch.edits(f.number, loop); });
    run.start();
    if (watch.edits) watch.edits(by.frames_before, loop);
    loop.run();
    if (loop.failure()) run.record.failure = failure_text(loop);
    if (loop.end() == End::refused) run.record.failure = loop.refusal();
    if (loop.end() == End::substeps)
        run.record.failure =
            fmt::format("frame {}: not done after {} substeps (step.most_substeps)",
                        loop.last().number, loop.last().stats.substeps);
    run.finish();
    run.record.wall = keeper.wall();
    if (watch.checkpoint) keeper.end(loop.last());
    move_out(scene, run.record);
    return std::move(run.record);
}

}  // namespace knead
