// Runs one case: recorded hands, frame by frame, from their first contact with the clay.
#include <algorithm>
#include <map>

#include "host/bench/bench.h"
#include "host/hands/motion.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/solver/audit.h"
#include "host/solver/cpu/tools.h"
#include "host/solver/frame_stats.h"

namespace knead {
namespace {

// Measurements of all repeats of a case. Frames without contact are excluded, unless there are no
// others.
struct Gathered {
    struct Times {
        std::vector<double> frames, substeps, counts;
        void add(const FrameResult& f)
        {
            const int n = std::max(f.stats.substeps, 1);
            const double wall = f.times.solver;
            frames.push_back(wall), substeps.push_back(wall / n), counts.push_back(n);
        }
    };
    Times in_contact, apart;
    std::vector<double> surfaces, medians;
    int timed = 0;
    FrameStats sum;
    std::vector<int> contact_frames;  // numbers of frames, in the first repeat
    int last = 1;

    // Number of the middle frame in contact, else of the last frame.
    int middle() const
    {
        return contact_frames.empty() ? last : contact_frames[contact_frames.size() / 2];
    }
    void add(const FrameResult& f)
    {
        (f.stats[Count::projected] > 0 ? in_contact : apart).add(f);
        ++timed;
        add_to(sum, f.stats);
        last = f.number;
        if (medians.empty() && f.stats[Count::projected] > 0) contact_frames.push_back(f.number);
    }
    const Times& times() const { return in_contact.frames.empty() ? apart : in_contact; }
};

void once(const Scene& scene, Simulator& solver, const HandSource* hands, const Drive& how,
          int first, Device device, Gathered& all)
{
    const double begin = wall_seconds();
    const int every =
        how.surfaces > 0 && how.frames > 0 ? std::max(1, how.frames / how.surfaces) : 0;
    Gathered mine;
    drive(scene, solver, hands, first, [&](const FrameResult& f) {
        const int timed = f.number - how.warm_up;
        if (timed > 0) {
            all.add(f);
            mine.add(f);
            if (every && timed % every == 0) {
                const SurfaceTimes made = surface_times(solver.particles(), scene, device, 1);
                all.surfaces.push_back(spread(made.whole).median);
            }
        }
        if (how.frames > 0 && timed >= how.frames) return false;
        return timed < 2 || wall_seconds() - begin < how.limit / how.repeats;
    });
    if (mine.timed > 0) all.medians.push_back(spread(mine.times().substeps).median);
}

double relative_range(const std::vector<double>& medians)
{
    const auto [low, high] = std::minmax_element(medians.begin(), medians.end());
    const double middle = spread(medians).median;
    return medians.size() > 1 && middle > 0 ? (*high - *low) / middle : 0;
}

void fill(BenchRow& row, const Scene& scene, const Gathered& all)
{
    row.particles = scene.setup.particles.size();
    row.nodes = scene.setup.lattice.size;
    row.frames = all.timed, row.repeats = int(all.medians.size());
    row.in_contact = int(all.in_contact.frames.size());
    row.substeps = spread(all.times().counts).median;
    row.frame = spread(all.times().frames), row.substep = spread(all.times().substeps);
    row.between = relative_range(all.medians);
    row.surface = spread(all.surfaces).median;
    row.min_bytes = min_bytes(row.particles, all.sum.active_blocks);
    row.acted = all.sum;
    const double all_of_them = double(row.particles) * all.sum.substeps;
    if (all_of_them > 0) row.moved = double(all.sum[Count::moved]) / all_of_them;
}

// Positions of about 2000 particles of each object, whatever its size.
std::vector<Vec3<double>> samples(const std::vector<Particle<double>>& particles)
{
    std::map<int, std::size_t> counts, seen;
    for (const Particle<double>& q : particles) ++counts[q.object];
    std::vector<Vec3<double>> places;
    for (const Particle<double>& q : particles)
        if (seen[q.object]++ % std::max<std::size_t>(1, counts[q.object] / 2000) == 0)
            places.push_back(q.x);
    return places;
}

}  // namespace

double min_bytes(std::size_t particles, long active_blocks)
{
    const double nodes = double(active_blocks) * block_nodes * sizeof(Node<float>);
    return 2 * sizeof(Particle<float>) + 2 * nodes / double(std::max<std::size_t>(particles, 1));
}

Counted counted_each(const std::vector<StageWork>& stages, double items, const BenchRow& row,
                     const DeviceInfo& facts)
{
    Counted all;
    if (!(items > 0)) return all;
    for (const StageWork& stage : stages) {
        all.stages.push_back({stage.name, 1 / items * stage.work});
        all.sum += all.stages.back().work;
    }
    const double rate = row.substep.median > 0 ? row.rate()
                        : row.frame.median > 0 ? double(row.particles) / row.frame.median
                                               : 0;
    // Four schedulers per multiprocessor, one instruction per cycle each.
    const double issued = 4.0 * facts.multiprocessors * all.sum.clock();
    if (issued > 0) all.issue_share = all.sum.instructions * rate / issued;
    if (facts.copy > 0) all.copy_share = all.sum.memory_bytes * rate / facts.copy;
    return all;
}

void drive(const Scene& scene, Simulator& solver, const HandSource* hands, int first,
           const std::function<bool(const FrameResult&)>& after)
{
    SessionLoopOptions options = loop_options(scene);
    options.first_frame = first;
    options.frames = std::max(0, frames_wanted(scene, hands, 0) - first);
    SessionLoop loop(solver, recorded_motion(hands, scene.hands), options);
    loop.observe([&](const FrameResult& f) {
        if (!after(f)) loop.stop();
    });
    loop.run();
    if (loop.failure()) std::rethrow_exception(loop.failure());
}

int first_contact(const Scene& scene, const HandSource& hands)
{
    const Setup& setup = scene.setup;
    const std::vector<Side> sides = tool_sides(scene.hands);
    const MotionSource moving = recorded_motion(&hands, scene.hands);
    PosedTools<double> tools(setup, setup.lattice);
    const std::vector<Vec3<double>> clay = samples(setup.particles);
    const int end = frames_wanted(scene, &hands, 0);
    const auto reached = [&](int tool) {
        for (std::size_t s = 0; s < tools.shapes.size(); ++s) {
            if (tools.primitives[s].tool != tool) continue;
            const Shape<double>& shape = tools.shapes[s];
            for (const Vec3<double> x : clay) {
                const bool near = contains({shape.low, shape.high}, x);
                if (near && closest_point(shape, x).phi < 0) return true;
            }
        }
        return false;
    };
    for (int f = 0; f < end; ++f) {
        const Motion motion = moving(f / scene.frame_rate, (f + 1) / scene.frame_rate);
        tools.activate(motion);
        tools.pose(motion, 0, 1, 1 / scene.frame_rate);
        bool all = !sides.empty();
        for (std::size_t t = 0; t < sides.size() && all; ++t)
            all = tools.tools[t].active && reached(int(t));
        if (all) return f;
    }
    return -1;
}

// Measures the stages of one frame on a separate solver, so that the timed runs are not disturbed.
void Bench::examine(const Scene& scene, const HandSource* hands, int first, int frame,
                    const Drive& how, BenchRow& row)
{
    const std::unique_ptr<Simulator> solver = make_solver(scene.setup, device);
    drive(scene, *solver, hands, first, [&](const FrameResult& f) {
        if (stopped() || f.number < frame) return true;
        if (how.stages) row.stages = stage_times(*solver);
        if (how.counts)
            row.counted = counted_each(counted([&] { return solver->profile()->counts(); }),
                                       double(f.stats[Count::moved]), row, facts);
        return false;
    });
}

const BenchRow& Bench::measured(const std::string& name, const Scene& scene, const Drive& how)
{
    if (const auto found = known.find(name); found != known.end()) return found->second;
    say(name);
    BenchRow row;
    row.name = name;
    std::unique_ptr<HandSource> hands;
    int first = 0;
    if (scene.has_hands) {
        hands = std::make_unique<HandSource>(hands_of(scene), scene.hands);
        const int contact = how.from_contact ? first_contact(scene, *hands) : 0;
        if (contact < 0) row.note = "the hands never touch";
        first = std::max(0, contact - how.warm_up);
    }
    Gathered all;
    const double begin = wall_seconds();
    for (int k = 0; k < how.repeats && (k == 0 || wall_seconds() - begin < how.limit); ++k) {
        const std::unique_ptr<Simulator> solver = make_solver(scene.setup, device);
        once(scene, *solver, hands.get(), how, first, device, all);
        row.bytes = solver->memory();
        if (k > 0) continue;
        row.hashed_after = all.timed + how.warm_up;
        if (how.stages && device.kind == DeviceKind::cpu) row.stages = stage_times(*solver);
        const auto last = solver->particles();
        const Audit state = audit(last, scene.setup.materials, scene.setup.lattice.dx);
        row.crowded = crowding(last, scene.setup.materials, scene.setup.lattice.dx).particles;
        row.hash = hexadecimal(state.hash);
        if (state.broken > 0) row.note = "NOT SOUND: non-finite numbers";
    }
    fill(row, scene, all);
    row.copy_share = row.min_bytes * row.rate() / facts.copy;
    if (device.kind == DeviceKind::cuda && (how.stages || (how.counts && options.count)) &&
        !stopped())
        examine(scene, hands.get(), first, all.middle(), how, row);
    return known[name] = row;
}

}  // namespace knead
