// Time and accuracy of splat pictures, and the cost of Gaussians in a substep.
#include "host/bench/splats.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "host/bench/ball.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/solver/audit.h"
#include "host/splats/gpu_raster.h"

namespace knead {
namespace {

// FNV-1a over the bits of colours and depths.
std::uint64_t hash_of(const std::vector<Picture>& pictures)
{
    std::uint64_t h = 14695981039346656037ull;
    const auto mix = [&h](float x) {
        h = (h ^ std::bit_cast<std::uint32_t>(x)) * 1099511628211ull;
    };
    for (const Picture& p : pictures)
        for (std::size_t i = 0; i < p.pixels(); ++i)
            for (const float x : {p.colour[i].x, p.colour[i].y, p.colour[i].z, p.depth[i]}) mix(x);
    return h;
}

// PSNR of the worse eye [dB].
double psnr(const std::vector<Picture>& a, const std::vector<Picture>& b)
{
    double worst = 200;
    for (std::size_t e = 0; e < a.size(); ++e) worst = std::min(worst, psnr(a[e], b.at(e)));
    return worst;
}

// Minimum memory traffic [bytes]: splats and deformations read, visible splats written and read,
// instances through two passes of a sort, pictures written.
double floor_bytes(const SplatCloud& cloud, const DrawTimes& d)
{
    const double splat = 48, motion = 48, seen = 6.0 * harmonics(cloud.degree) + 2 * 48;
    return double(cloud.count()) * (splat + 3 * 16) + double(d.moved) * motion +
           double(d.visible) * seen + double(d.instances) * (6 + 2 * 12 + 2) +
           2.0 * d.width * d.height * 12;
}

void draw_on_gpu(const SplatCase& what, const SplatCloud& cloud, const SplatFrame& frame,
                 int device, BenchRow& row, std::vector<Picture>& pictures)
{
    GpuRaster raster(cloud, 0, device);
    pictures = raster.pictures(frame);
    const RasterStats stats = raster.stats();
    row.drawn.visible = stats.visible, row.drawn.instances = stats.instances;
    row.drawn.dropped = stats.dropped;
    raster.replays(10);
    row.frame = spread(raster.replays(what.frames));
    row.stages = raster.stage_times();
    row.bytes = raster.memory(), row.frames = what.frames;
    row.min_bytes = floor_bytes(cloud, row.drawn) / double(cloud.count());
}

void draw_on_cpu(const SplatCase& what, const SplatCloud& cloud, const SplatFrame& frame,
                 BenchRow& row, std::vector<Picture>& pictures)
{
    const double begin = wall_seconds();
    std::vector<double> seconds;
    while (seconds.size() < 2 ||
           (int(seconds.size()) < what.frames && wall_seconds() - begin < what.limit)) {
        const double start = wall_seconds();
        pictures = cpu_raster(cloud, frame);
        seconds.push_back(wall_seconds() - start);
    }
    row.frame = spread(seconds), row.frames = int(seconds.size());
}

BenchRow row_of(const SplatCase& what, const SplatCloud& cloud, const SplatFrame& frame)
{
    BenchRow row;
    row.suite = "splats", row.at = double(cloud.count());
    row.name = fmt::format("splats: {} {}{}{}", what.load.name, what.view,
                           what.moving ? "" : ", still", what.foveate > 0 ? ", foveated" : "");
    row.particles = cloud.count(), row.repeats = 1;
    row.drawn.width = what.width, row.drawn.height = what.height;
    row.drawn.moved = frame.moved_F.size();
    return row;
}

const SplatLoad& load_named(const std::string& name)
{
    const auto& all = splat_loads();
    return *std::find_if(all.begin(), all.end(),
                         [&](const SplatLoad& l) { return l.name == name; });
}

// A few splats, for --quick.
SplatLoad small_load() { return {"6k", 3000, 3000, 0.02, 20261120}; }

SplatCase case_of(const Bench& bench, const SplatLoad& load, const std::string& view)
{
    SplatCase what;
    what.load = load, what.view = view, what.limit = bench.options.case_limit;
    if (bench.options.quick) what.width = 258, what.height = 276, what.frames = 3;
    return what;
}

void load_rows(Bench& bench, const SplatLoad& load, const std::vector<std::string>& views,
               bool still)
{
    const double count = double(load.object) + load.background;
    if (bench.stopped() || !bench.fits("splats: " + load.name, count, 900, 600)) return;
    SplatCloud cloud = generated(load);
    sort_by_place(cloud);
    const auto add = [&](const SplatCase& what) {
        if (bench.stopped()) return;
        bench.say(fmt::format("splats: {} {}", what.load.name, what.view));
        bench.add(splat_row(what, cloud, bench.device, bench.facts.copy));
    };
    for (const std::string& view : views) add(case_of(bench, load, view));
    SplatCase first = case_of(bench, load, views.at(0));
    first.moving = false;
    if (!still) return;
    add(first);
    first.moving = true, first.foveate = 20;
    add(first);
}

std::vector<Picture> pictures_by(Device device, const SplatCloud& cloud, const SplatFrame& frame)
{
    if (device.kind != DeviceKind::cuda) return cpu_raster(cloud, frame);
    return GpuRaster(cloud, 0, device.index).pictures(frame);
}

// Compares with the exact reference in double, with exact depth orders, on few splats and pixels.
void exact_rows(Bench& bench)
{
    const bool quick = bench.options.quick;
    SplatCase what;
    what.load = quick ? small_load() : SplatLoad{"30k", 15000, 15000, 0.02, 20261120};
    what.width = quick ? 64 : 258, what.height = quick ? 68 : 276;
    SplatCloud cloud = generated(what.load);
    sort_by_place(cloud);
    const SplatFrame frame = frame_of(what, cloud);
    bench.say("splats: against the exact picture");
    const double start = wall_seconds();
    const std::vector<Picture> exact = exact_raster(cloud, frame);
    BenchRow row = row_of(what, cloud, frame);
    row.suite = "splats: picture", row.frame.median = wall_seconds() - start, row.frames = 1;
    row.name = fmt::format("splats: {}, against the exact picture", what.load.name);
    const std::vector<Picture> ours = pictures_by(bench.device, cloud, frame);
    row.hash = hexadecimal(hash_of(ours)), row.drawn.psnr = psnr(ours, exact);
    row.note = fmt::format(
        "every splat in every pixel, in double and by exact distances; by the depth in each pixel: "
        "{:.1f} dB; times are the exact picture's",
        psnr(ours, exact_raster(cloud, frame, DepthOrder::pixel)));
    bench.add(row);
    if (bench.stopped()) return;
    row.name = fmt::format("splats: {}, one order against one an eye", what.load.name);
    row.drawn.psnr = psnr(exact, exact_raster(cloud, frame, DepthOrder::eye));
    row.note = "both exact; times are those of the one with one order";
    bench.add(row);
}

// The ball between two closing tools, with and without Gaussians around it.
void substep_row(Bench& bench, int count)
{
    const bool quick = bench.options.quick;
    Setup setup = ball(quick ? 32 : 64);
    add_gaussians(setup, count);
    add_tools(setup);
    setup.threads = bench.options.threads;
    BenchRow row;
    row.suite = "splats: substep", row.at = count;
    row.name = fmt::format("splats: a substep with {} k Gaussians", count / 1000);
    bench.say(row.name);
    row.particles = setup.particles.size(), row.nodes = setup.lattice.size, row.repeats = 1;
    const std::unique_ptr<Simulator> solver = make_solver(setup, bench.device);
    const double frame = 1.0 / 90;
    std::vector<double> frames, substeps, counts;
    const double begin = wall_seconds();
    const auto more = [&] {
        const int done = int(frames.size());
        return !bench.stopped() && done < (quick ? 3 : 30) &&
               (done < 2 || wall_seconds() - begin < bench.options.case_limit);
    };
    while (more()) {
        const Motion motion = closing(double(frames.size()) * frame, frame);
        const double start = wall_seconds();
        const FrameStats stats = solver->advance(motion, frame);
        frames.push_back(wall_seconds() - start), counts.push_back(std::max(stats.substeps, 1));
        substeps.push_back(frames.back() / counts.back());
        row.in_contact += stats[Count::projected] > 0;
    }
    if (frames.empty()) return;
    row.frames = int(frames.size()), row.substeps = spread(counts).median;
    row.frame = spread(frames), row.substep = spread(substeps);
    row.stages = stage_times(*solver), row.bytes = solver->memory();
    row.hash = hexadecimal(audit(solver->particles(), setup.materials, setup.lattice.dx).hash);
    bench.add(row);
}

// Placement of the object's splats on the scene's ball: same centre and size.
struct Placed {
    Vec3<double> centre;
    double scale;
};

Placed put_object(Scene& scene, const SplatLoad& load, const SplatCloud& cloud)
{
    Vec3<double> sum{};
    for (const Particle<double>& q : scene.setup.particles) sum = sum + q.x;
    constexpr double radius = 0.21;  // of the object including its bumps [m]
    const Placed at{(1 / double(scene.setup.particles.size())) * sum,
                    scene.objects.at(0).size.x / 2 / radius};
    for (std::size_t i = 0; i < std::size_t(load.object); ++i)
        scene.setup.gaussians.push_back(
            gaussian_at(at.centre + at.scale * cast<double>(cloud.centre[i]), 0));
    return at;
}

// A frame of a splat scene with one clay object in the hands: substeps with Gaussians and surface,
// submitted one ahead; then the picture for both eyes.
void frame_row(Bench& bench, const std::string& name, const std::vector<std::string>& settings)
{
    const SplatLoad load = bench.options.quick ? small_load() : load_named("660k");
    const SplatCloud cloud = generated(load);
    Scene scene = bench.scene(settings);
    const Placed at = put_object(scene, load, cloud);
    bench.say(name);
    const HandSource hands(hands_of(scene), scene.hands);
    const QueuedFrames frames =
        queued(scene, bench.device, &hands, std::max(0, first_contact(scene, hands)),
               bench.options.quick ? 4 : 120, true);
    if (frames.frames < 1 || bench.stopped()) return;
    SplatCase what = case_of(bench, load, "far");
    what.moving = what.check = false;
    SplatFrame frame = frame_of(what, cloud);
    for (const Gaussian<double>& g : frames.gaussians) {
        frame.moved_centre.push_back(cast<float>((1 / at.scale) * (g.x - at.centre)));
        frame.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
    }
    BenchRow row = row_of(what, cloud, frame);
    std::vector<Picture> pictures;
    if (bench.device.kind == DeviceKind::cuda)
        draw_on_gpu(what, cloud, frame, bench.device.index, row, pictures);
    else
        draw_on_cpu(what, cloud, frame, row, pictures);
    row.suite = "splats: frame", row.name = name, row.hash = hexadecimal(hash_of(pictures));
    row.note = fmt::format(
        "{} particles, {} Gaussians; {:.3f} ms of {:.0f} substeps and a surface, {:.3f} ms of "
        "pictures, measured one after the other",
        scene.setup.particles.size(), frames.gaussians.size(), 1e3 * frames.frame, frames.substeps,
        1e3 * row.frame.median);
    row.stages = {{"substeps and surface", frames.frame}, {"both eyes", row.frame.median}};
    row.frames = frames.frames, row.substeps = frames.substeps, row.min_bytes = 0;
    for (double* const t : {&row.frame.median, &row.frame.p95, &row.frame.mean, &row.frame.max})
        *t += frames.frame;
    bench.add(row);
}

}  // namespace

SplatFrame frame_of(const SplatCase& what, const SplatCloud& cloud)
{
    SplatFrame frame;
    frame.eyes = load_eyes(what.view, what.width, what.height);
    if (what.foveate > 0) frame.fovea.assign(frame.eyes.size(), fovea_of(what.foveate));
    if (!what.moving) return frame;
    constexpr float turn = 0.2f;  // [rad/m]
    for (const Vec3<float> x : cloud.centre) {
        const float c = std::cos(turn * x.y), s = std::sin(turn * x.y);
        const Vec3<float> to{c * x.x - s * x.z, x.y, s * x.x + c * x.z};
        frame.moved_centre.push_back(to);
        frame.moved_F.push_back({{c, 0, s}, {-turn * to.z, 1, turn * to.x}, {-s, 0, c}});
    }
    return frame;
}

BenchRow splat_row(const SplatCase& what, const SplatCloud& cloud, Device device, double copy)
{
    const SplatFrame frame = frame_of(what, cloud);
    BenchRow row = row_of(what, cloud, frame);
    std::vector<Picture> pictures;
    if (device.kind == DeviceKind::cuda)
        draw_on_gpu(what, cloud, frame, device.index, row, pictures);
    else
        draw_on_cpu(what, cloud, frame, row, pictures);
    row.hash = hexadecimal(hash_of(pictures));
    if (copy > 0 && row.frame.median > 0)
        row.copy_share = row.min_bytes * double(cloud.count()) / row.frame.median / copy;
    if (what.check && device.kind == DeviceKind::cuda) {
        row.drawn.psnr = psnr(pictures, cpu_raster(cloud, frame));
        row.note = "PSNR against the CPU's picture";
    }
    if (what.foveate > 0)
        row.note +=
            fmt::format("; {:.1f} % of the pixels are blended", 100 * blended_share(frame, 0));
    return row;
}

void splats_suite(Bench& bench)
{
    if (bench.options.quick) {
        load_rows(bench, small_load(), {"far", "near"}, true);
    } else {
        load_rows(bench, load_named("660k"), {"far", "near45", "near"}, true);
        load_rows(bench, load_named("5m-fine"), {"far"}, false);
    }
    if (!bench.stopped()) exact_rows(bench);
    for (int count : {0, bench.options.quick ? 20000 : 300000})
        if (!bench.stopped()) substep_row(bench, count);
    const std::vector<std::string> paper{"clock=paper", "paper.substeps=5",
                                         "surface.smoothing=laplace"};
    if (!bench.stopped()) frame_row(bench, "splats: the paper's frame, 5 substeps", paper);
    if (!bench.stopped())
        frame_row(bench, "splats: a frame in real time", {"surface.smoothing=laplace"});
}

}  // namespace knead
