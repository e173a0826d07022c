#include "host/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "host/hands/gesture.h"
#include "host/hands/recording.h"
#include "host/scene/seed.h"
#include "host/surface/gpu_surface.h"

namespace knead {
namespace {

using Wall = std::chrono::steady_clock;
double since(Wall::time_point start)
{
    return std::chrono::duration<double>(Wall::now() - start).count();
}

// Counts depths in bins of 10 micrometres, the last for all deeper ones: constant memory.
class DepthCount {
  public:
    void add(const std::vector<double>& depths)
    {
        for (double d : depths) {
            ++bins[std::min(std::size_t(d / bin), bins.size() - 1)];
            ++count, sum += d, max = std::max(max, d);
        }
    }
    Depths summary() const
    {
        Depths all{count, count ? sum / double(count) : 0, 0, max};
        long seen = 0;
        for (std::size_t i = 0; i < bins.size() && seen * 100 < count * 99; ++i)
            seen += bins[i], all.p99 = std::min(bin * double(i + 1), max);
        return all;
    }

  private:
    static constexpr double bin = 1e-5;  // [m]
    std::array<long, 20000> bins{};
    long count = 0;
    double sum = 0, max = 0;
};

// The hands' side of a frame: where the joints were and are.
class HandStep {
  public:
    HandStep(const Scene& scene, const HandSource* source) : hands(source), sides()
    {
        motion.from.resize(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}});
        motion.to = motion.from;
        if (!hands) return;
        sides = tool_sides(scene.hands);
        bool active[side_count];
        hands->sample(0, motion.to.data(), active);
    }
    // Moves on to `time` [s] of the recording; true if any tool is active.
    bool move(double time)
    {
        motion.from = motion.to;
        motion.active.assign(sides.size(), 0);
        if (!hands) return false;
        bool active[side_count];
        hands->sample(time, motion.to.data(), active);
        bool any = false;
        for (std::size_t t = 0; t < sides.size(); ++t) {
            motion.active[t] = active[sides[t]];
            any = any || active[sides[t]];
        }
        return any;
    }
    Motion motion;

  private:
    const HandSource* hands;
    std::vector<Side> sides;
};

class Run {
  public:
    Run(const Scene& scene_, Solver& solver_, const RunRule& rule_)
        : scene(scene_), solver(solver_), rule(rule_)
    {
    }

    // One frame of the solver; false if the device failed.
    bool advance(FrameRow& row, const Motion& motion)
    {
        const Wall::time_point at = Wall::now();
        try {
            row.stats = solver.advance(motion, record.duration);
        } catch (const std::runtime_error& e) {
            record.end = End::device;
            record.trouble = fmt::format("frame {}: {}", row.frame, e.what());
        }
        row.wall = since(at);
        moved += row.stats.moved;
        return record.end == End::complete;
    }

    // Looks at the state; false if it holds non-finite numbers.
    bool look(FrameRow& row)
    {
        std::vector<Particle<double>> now = solver.particles();
        row.audited = true;
        row.state = audit(now, scene.setup.materials, scene.setup.lattice.dx);
        row.stages = solver.stage_times();
        const std::vector<double> inside = solver.penetration();
        depths.add(inside);
        row.left = depths_of(inside);
        if (row.state.broken > 0) {
            record.trouble =
                fmt::format("frame {}: {} particles are not numbers", row.frame, row.state.broken);
            return false;
        }
        record.last_good = std::move(now);
        return true;
    }

    void mesh(FrameRow& row)
    {
        const Wall::time_point start = Wall::now();
        row.kept = made && moved == 0;
        if (row.kept) {
            // The last ones stand.
        } else if (const gpu::Clay* clay = solver.clay()) {
            if (!on_device)
                on_device = std::make_unique<GpuSurface>(record.last_good, scene.setup.materials,
                                                         scene.surface);
            record.meshes = on_device->surface(*clay);
        } else {
            const bool fresh = row.audited && row.state.broken == 0;
            record.meshes = surface(fresh ? record.last_good : solver.particles(),
                                    scene.setup.materials, scene.surface);
        }
        row.surface_wall = since(start);
        row.meshed = made = true;
        moved = 0;
        for (const Mesh& m : record.meshes) {
            row.mesh_volume += volume(m);
            row.triangles += long(m.triangles.size());
        }
    }

    const Scene& scene;
    Solver& solver;
    const RunRule& rule;
    RunRecord record;
    DepthCount depths;

  private:
    std::unique_ptr<GpuSurface> on_device;
    bool made = false;  // there are meshes
    long moved = 0;     // particle-substeps since
};

// More than a hundredth of the clay put back in one frame: the guards no longer repair, they hide.
bool overrun(const FrameStats& stats, std::size_t particles)
{
    return double(stats.repaired) > 0.01 * double(particles);
}

void start(Run& run)
{
    FrameRow before;
    run.record.last_good = run.solver.particles();
    run.record.particles = run.record.last_good.size();
    run.record.first =
        audit(run.record.last_good, run.scene.setup.materials, run.scene.setup.lattice.dx);
    if (run.rule.mesh_every == 0 && !run.rule.last_mesh) return;
    before.audited = true;
    run.mesh(before);
    run.record.first_mesh_volume = before.mesh_volume;
}

// What a record says of places, it says in the frame of the scene's file: one way out for all of
// it.
void move_out(const Scene& scene, RunRecord& record)
{
    const Vec3<double> by = scene.origin;
    if (dot(by, by) == 0) return;
    for (Particle<double>& q : record.last_good) q.x = q.x + by;
    for (Mesh& mesh : record.meshes)
        for (Vec3<float>& x : mesh.vertices) x = cast<float>(cast<double>(x) + by);
    const auto turn = [by](Audit& state) { state.spin = state.spin + cross(by, state.momentum); };
    turn(record.first);
    for (FrameRow& row : record.rows)
        if (row.audited) turn(row.state);
}

// However the loop ended: its last frame is looked at, and meshed where that is wanted.
void finish(Run& run)
{
    RunRecord& record = run.record;
    record.left = run.depths.summary();
    if (record.end == End::device) return;
    record.bytes = run.solver.memory();
    if (record.rows.empty() || record.end == End::numbers) return;
    FrameRow& last = record.rows.back();
    if (!last.audited && !run.look(last)) {
        record.end = End::numbers;
        return;
    }
    if (run.rule.last_mesh && !last.meshed) run.mesh(last);
}

}  // namespace

Depths depths_of(std::vector<double> found)
{
    Depths d;
    d.count = long(found.size());
    if (found.empty()) return d;
    std::sort(found.begin(), found.end());
    for (double x : found) d.mean += x / double(found.size());
    d.p99 = found[std::size_t(0.99 * double(found.size() - 1))];
    d.max = found.back();
    return d;
}

Recording hands_of(const Scene& scene)
{
    const HandsRule& hands = scene.hands;
    for (const Gesture& g : gestures()) {
        if (g.name != hands.recording) continue;
        GestureRule rule;
        rule.radius = scene.objects[0].size.x / 2 / hands.zoom;
        rule.topology = hands.topology;
        rule.seed = scene.seed;
        return generate(g.name, rule);
    }
    return read_recording(hands.recording);
}

int frames_wanted(const Scene& scene, const HandSource* hands, int asked)
{
    if (asked > 0) return asked;
    if (scene.frames > 0) return scene.frames;
    const double seconds = hands ? hands->duration() : 1.0;
    return int(std::clamp(std::ceil(seconds * scene.frame_rate - 1e-6), 1.0, 1e7));
}

RunRecord run_frames(const Scene& scene, Solver& solver, const HandSource* hands,
                     const RunRule& rule, const RunWatch& watch)
{
    Run run(scene, solver, rule);
    RunRecord& record = run.record;
    HandStep step(scene, hands);
    record.frames_wanted = frames_wanted(scene, hands, rule.frames);
    record.duration = frame_duration(scene);
    start(run);
    const Wall::time_point begin = Wall::now();
    for (int f = 1; f <= record.frames_wanted && record.end == End::complete; ++f) {
        if (rule.time_limit > 0 && since(begin) > rule.time_limit) record.end = End::time_limit;
        if (watch.stop && watch.stop()) record.end = End::interrupted;
        if (record.end != End::complete) break;
        FrameRow row;
        row.frame = f;
        row.simulated = f * record.duration;
        row.hand_time = f / scene.frame_rate;
        Wall::time_point at = Wall::now();
        row.hands = step.move(row.hand_time);
        row.hands_wall = since(at);
        if (!run.advance(row, step.motion)) break;
        const bool last = f == record.frames_wanted, bad = overrun(row.stats, record.particles);
        if (bad)
            record.trouble =
                fmt::format("frame {}: {} particles had to be put back", f, row.stats.repaired);
        const bool due = last || f == 1 || f % std::max(1, rule.audit_every) == 0;
        if (bad || (due && !run.look(row))) record.end = End::numbers;
        const bool shown = rule.mesh_every > 0 && f % rule.mesh_every == 0;
        if (record.end == End::complete && (shown || (last && rule.last_mesh))) run.mesh(row);
        record.rows.push_back(row);
        if (watch.frame) watch.frame(record.rows.back());
        if (shown && row.meshed && watch.picture)
            watch.picture({record.rows.back(), record.meshes,
                           hands ? step.motion.to : std::vector<Joint<double>>{},
                           step.motion.active});
    }
    finish(run);
    record.wall = since(begin);
    move_out(scene, record);
    return std::move(run.record);
}

double moved_share(const RunRecord& record)
{
    double moved = 0, all = 0;
    for (const FrameRow& row : record.rows) {
        moved += double(row.stats.moved);
        all += double(record.particles) * row.stats.substeps;
    }
    return all > 0 ? moved / all : 1;
}

std::vector<std::string> left_at_rest(const RunRecord& record)
{
    std::vector<std::string> out;
    const double still = 1 - moved_share(record);
    if (still > 0)
        out.push_back(fmt::format("clay at rest: {:.3g} % of all particle-substeps", 100 * still));
    const auto frames = [&](bool FrameRow::*which) {
        return std::count_if(record.rows.begin(), record.rows.end(),
                             [&](const FrameRow& row) { return row.*which; });
    };
    if (frames(&FrameRow::kept) > 0)
        out.push_back(fmt::format("surface: of {} meshed frames in {} nothing had moved",
                                  frames(&FrameRow::meshed), frames(&FrameRow::kept)));
    return out;
}

std::vector<std::string> left_out(const Scene& scene, const RunRule& rule)
{
    std::vector<std::string> out;
    if (!scene.has_hands)
        out.push_back("contact: the scene has no hands");
    else if (scene.setup.tools.empty())
        out.push_back("contact: neither hand is present");
    if (scene.has_hands && !scene.setup.grid_contact)
        out.push_back("grid contact: switched off by /contact/grid");
    if (scene.has_hands && scene.setup.passes == 0)
        out.push_back("particle projection: switched off by /contact/passes");
    const auto& tools = scene.setup.tools;
    if (std::none_of(tools.begin(), tools.end(), [](const Tool<double>& t) { return t.blade; }))
        out.push_back("cutting: no hand holds a blade");
    const auto yields = [](const Object& o) {
        return o.material.plasticity != Plasticity::none &&
               o.material.plasticity != Plasticity::fluid;
    };
    if (std::none_of(scene.objects.begin(), scene.objects.end(), yields))
        out.push_back("plasticity: no object yields");
    if (scene.setup.rest.mode == RestMode::none) out.push_back("sleep: not asked for (/rest/mode)");
    out.push_back("Gaussians: the scene has none");
    if (rule.mesh_every == 0 && !rule.last_mesh)
        out.push_back("surface: neither mesh nor pictures are asked for");
    else if (rule.mesh_every == 0)
        out.push_back("pictures: not asked for");
    if (rule.audit_every > 1)
        out.push_back(fmt::format("audits: of every frame; one in {}", rule.audit_every));
    return out;
}

}  // namespace knead
