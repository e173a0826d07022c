// The suites of knead bench: scenes and varied quantities.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>

#include "host/base/machine.h"
#include "host/bench/bench.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/solver/audit.h"

namespace knead {

std::vector<std::string> walls_on_cells(double edge, int cells)
{
    const double low = edge * 3 / cells, high = edge * (cells - 4) / cells;
    return {fmt::format("walls.min=[{0},{0},{0}]", low),
            fmt::format("walls.max=[{0},{0},{0}]", high)};
}

constexpr double diameter = 0.5;  // of the scene's ball [m], in a box of 1 m

std::vector<std::string> squeeze_on(int cells)
{
    const double y = 3.0 / cells + diameter / 2;
    std::vector<std::string> s = walls_on_cells(1, cells);
    s.push_back(fmt::format("domain.cells={}", cells));
    s.push_back(fmt::format("objects.0.centre=[0.5,{:.9g},0.5]", y));
    s.push_back(fmt::format("hands.at=[0.5,{:.9g},0.5]", y));
    return s;
}

namespace {

constexpr double per_cell = 8;

double particles_on(int cells)
{
    return std::numbers::pi / 6 * std::pow(diameter * cells, 3) * per_cell;
}

Drive usual(const Bench& bench, int frames)
{
    Drive how;
    how.frames = bench.options.quick ? std::min(frames > 0 ? frames : 6, 6) : frames;
    how.repeats = bench.options.quick ? 1 : 3;
    how.limit = bench.options.case_limit;
    return how;
}

BenchRow named(BenchRow row, const char* suite, double at)
{
    row.suite = suite, row.at = at;
    return row;
}

std::vector<std::string> paper_settings(int cells, int substeps, int each)
{
    std::vector<std::string> s = squeeze_on(cells);
    s.push_back("clock=paper");
    s.push_back(fmt::format("paper.substeps={}", substeps));
    s.push_back(fmt::format("objects.0.per_cell={}", each));
    return s;
}

void paper_case(Bench& bench, const char* suite, double at, int cells, int substeps, int each)
{
    const std::string name =
        fmt::format("paper: {}^3 nodes, {} substeps, {} per cell", cells, substeps, each);
    Drive how = usual(bench, 30);
    how.surfaces = bench.options.quick ? 1 : 3;
    bench.add(named(bench.measured(name, bench.scene(paper_settings(cells, substeps, each)), how),
                    suite, at));
}

// Stages of the surface on the state after a few frames of the squeeze.
void surface_case(Bench& bench, int cells, int nodes)
{
    std::vector<std::string> settings = squeeze_on(cells);
    settings.push_back(fmt::format("surface.nodes={}", nodes));
    const Scene scene = bench.scene(settings);
    const HandSource hands(hands_of(scene), scene.hands);
    BenchRow row;
    row.suite = "surface", row.at = nodes;
    row.name = fmt::format("surface: {:.3g} particles, {}^3 nodes",
                           double(scene.setup.particles.size()), nodes);
    bench.say(row.name);
    const std::unique_ptr<Simulator> solver = make_solver(scene.setup, bench.device);
    drive(scene, *solver, &hands, std::max(0, first_contact(scene, hands)),
          [](const FrameResult& f) { return f.number < 4; });
    if (bench.stopped()) return;
    const std::vector<Particle<double>> state = solver->particles();
    const SurfaceTimes times =
        surface_times(state, scene, bench.device, bench.options.quick ? 2 : 5);
    row.particles = scene.setup.particles.size(), row.nodes = scene.surface.lattice.size;
    row.repeats = int(times.whole.size());
    row.frame = spread(times.whole), row.surface = row.frame.median;
    row.stages = times.stages, row.bytes = times.bytes;
    row.hash = hexadecimal(audit(state, scene.setup.materials, scene.setup.lattice.dx).hash);
    row.note = times.note;
    row.counted =
        counted_each(bench.counted([&] { return surface_counts(state, scene, bench.device); }),
                     double(row.particles), row, bench.facts);
    bench.add(row);
}

// A ball in both hands and, with `rest`, a slab of the same clay beneath it; the ball is 5 % of
// both. Nothing falls, so the slab stays at rest.
Scene held_ball(const Bench& bench, int cells, bool rest)
{
    const double dx = 1.0 / cells, share = 0.05;
    const double slab_edge = 0.86, slab_height = 0.161, floor = 3 * dx;  // on the wall
    const double slab = slab_edge * slab_edge * slab_height;
    const double radius = std::cbrt(slab * share / (1 - share) * 3 / (4 * std::numbers::pi));
    const double y = floor + slab_height + radius;
    const std::string at = fmt::format("[0.5,{:.9g},0.5]", y);
    std::vector<std::string> settings = walls_on_cells(1, cells);
    for (const std::string& s :
         {fmt::format("domain.cells={}", cells), std::string("gravity=[0,0,0]"),
          "objects.0.centre=" + at, "hands.at=" + at,
          fmt::format("objects.0.diameter={:.9g}", 2 * radius),
          fmt::format("hands.zoom={:.9g}", radius / 0.1)})
        settings.push_back(s);
    Scene scene = read_scene(bench.options.scene, settings);
    need_objects(scene);
    scene.setup.threads = bench.options.threads;
    if (rest) {
        Object box = scene.objects[0];
        box.name = "slab", box.shape = ShapeKind::box;
        box.centre = {0.5, floor + slab_height / 2, 0.5};
        box.size = {slab_edge, slab_height, slab_edge};
        scene.objects.push_back(box);
    }
    build(scene, available_memory());
    return scene;
}

// Surfaces that are mostly reused: the ball in the hands moves, the slab sleeps.
void kept_surface_case(Bench& bench, int cells)
{
    Scene scene = held_ball(bench, cells, true);
    scene.setup.rest.mode = RestMode::sleep;
    BenchRow row;
    row.suite = "surface", row.at = 0.05;
    row.name =
        fmt::format("surface: 5 % of the clay moving, {}^3 nodes", scene.surface.lattice.size.x);
    bench.say(row.name);
    const KeptTimes times = kept_surface_times(scene, bench.device, scene.setup.rest.frames + 5,
                                               bench.options.quick ? 4 : 20);
    if (times.kept.empty()) return;
    row.particles = scene.setup.particles.size(), row.nodes = scene.surface.lattice.size;
    row.repeats = int(times.kept.size());
    row.frame = spread(times.kept), row.surface = row.frame.median;
    row.bytes = times.bytes;
    const double whole = spread(times.whole).median;
    row.note = fmt::format("{:.1f} % of the blocks made anew; all anew: {:.3f} ms",
                           100 * times.anew, 1e3 * whole);
    bench.add(row);
}

}  // namespace

const BenchRow& Bench::squeeze(int cells)
{
    Drive how = usual(*this, cells <= 64 ? 0 : cells <= 128 ? 40 : 8);
    how.stages = true;
    if (cells > 128) how.repeats = 1;
    return measured(fmt::format("squeeze: {}^3 nodes", cells), scene(squeeze_on(cells)), how);
}

void stages_suite(Bench& bench)
{
    for (int cells : bench.options.quick ? std::vector<int>{64} : std::vector<int>{64, 128})
        bench.add(named(bench.squeeze(cells), "stages", cells));
}

// The paper's figure 9: a ball squeezed by two hands, one quantity varied at a time.
void paper_suite(Bench& bench)
{
    const bool quick = bench.options.quick;
    using Values = std::vector<int>;
    for (int cells : quick ? Values{16, 32, 64} : Values{16, 32, 48, 64, 80, 96, 112, 128})
        if (!bench.stopped()) paper_case(bench, "paper: grid", cells, cells, 5, 8);
    for (int substeps : quick ? Values{3, 5, 10} : Values{3, 5, 8, 10, 15, 20, 25, 30})
        if (!bench.stopped()) paper_case(bench, "paper: substeps", substeps, 64, substeps, 8);
    for (int each : quick ? Values{4, 8, 12} : Values{4, 5, 6, 7, 8, 9, 10, 11, 12})
        if (!bench.stopped()) paper_case(bench, "paper: particles per cell", each, 64, 5, each);
}

void scale_suite(Bench& bench)
{
    // Initial estimate of bytes per particle, generous; replaced by the measured value.
    double device_bytes = 400;
    const double host_bytes = 2.5 * sizeof(Particle<double>) + sizeof(Particle<float>);
    const double max = bench.options.quick ? std::min(1e6, bench.options.max_particles)
                                           : bench.options.max_particles;
    for (double wanted : {1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7, 3e7, 5e7}) {
        const int cells = 4 * int(std::lround(std::cbrt(wanted / particles_on(1)) / 4));
        const double count = particles_on(cells);
        if (bench.stopped() || wanted > max) break;
        if (!bench.fits(fmt::format("scale: {}^3 nodes", cells), count, host_bytes, device_bytes))
            break;
        Drive how = usual(bench, count < 2e6 ? 30 : 5);
        if (count > 2e6) how.repeats = 1;
        const BenchRow& row = bench.measured(fmt::format("scale: {}^3 nodes", cells),
                                             bench.scene(squeeze_on(cells)), how);
        bench.add(named(row, "scale", double(row.particles)));
        if (row.particles > 50000) device_bytes = 1.1 * double(row.bytes) / double(row.particles);
    }
}

void surface_suite(Bench& bench)
{
    for (int nodes :
         bench.options.quick ? std::vector<int>{64, 128} : std::vector<int>{64, 128, 192, 256})
        if (!bench.stopped()) surface_case(bench, 64, nodes);
    if (!bench.options.quick && !bench.stopped()) surface_case(bench, 128, 256);
    if (bench.device.kind == DeviceKind::cuda && !bench.stopped())
        kept_surface_case(bench, bench.options.quick ? 64 : 128);
}

// Cost of clay at rest: held still outside boxes around the hands, or sleeping.
void localized_suite(Bench& bench)
{
    const int cells = bench.options.quick ? 64 : 128;
    const auto one = [&](RestMode mode, bool rest, const char* what) {
        const std::string name = fmt::format("localized: {}, {}^3 nodes", what, cells);
        Scene scene = held_ball(bench, cells, rest);
        scene.setup.rest.mode = mode;
        Drive how = usual(bench, 20);
        how.warm_up = scene.setup.rest.frames + 5;  // until clay at rest sleeps
        BenchRow row = bench.measured(name, scene, how);
        if (rest && !bench.result.rows.empty()) {
            const BenchRow& near = *std::find_if(
                bench.result.rows.rbegin(), bench.result.rows.rend(),
                [](const BenchRow& r) { return r.suite == "localized" && r.at == 0; });
            row.note += fmt::format(
                "{}{:.2f} % near the hands, {:.2f} % moved; {:.2f} times the cost of these alone",
                row.note.empty() ? "" : "; ", 100 * double(near.particles) / double(row.particles),
                100 * row.moved, row.frame.median / near.frame.median);
        }
        bench.add(named(row, "localized", rest ? 1 + int(mode) : 0));
    };
    one(RestMode::none, false, "the clay near the hands alone");
    if (!bench.stopped()) one(RestMode::sleep, true, "the rest asleep beside it");
    if (!bench.stopped()) one(RestMode::localized, true, "the rest held still");
    if (!bench.stopped()) one(RestMode::none, true, "the rest moving, too");
}

// Ten runs of the same frames must be bitwise identical; cost against the default mode.
void deterministic_suite(Bench& bench)
{
    Scene scene = bench.scene(squeeze_on(64));
    Drive how = usual(bench, bench.options.quick ? 2 : 10);
    how.repeats = 1, how.limit = 1e9;
    const BenchRow usual_row = bench.measured("deterministic: not asked for", scene, how);
    scene.setup.deterministic = true;
    std::set<std::string> hashes;
    BenchRow row;
    for (int run = 0; run < 10 && !bench.stopped(); ++run) {
        how.counts = run == 9;
        row = bench.measured(fmt::format("deterministic: run {}", run + 1), scene, how);
        hashes.insert(row.hash);
    }
    row.name = "deterministic: ten runs";
    row.note =
        fmt::format("{} in ten runs; {:.2f} times the usual mode's time",
                    hashes.size() == 1 ? "one hash" : fmt::format("{} HASHES", hashes.size()),
                    row.frame.median / usual_row.frame.median);
    bench.add(named(usual_row, "deterministic", 0));
    bench.add(named(row, "deterministic", 1));
}

const std::vector<std::pair<std::string, Suite>>& suites()
{
    static const std::vector<std::pair<std::string, Suite>> all{
        {"stages", stages_suite},   {"localized", localized_suite},
        {"surface", surface_suite}, {"deterministic", deterministic_suite},
        {"splats", splats_suite},   {"undo", undo_suite},
        {"targets", targets_suite}, {"paper", paper_suite},
        {"scale", scale_suite}};
    return all;
}

}  // namespace knead
