// workprecision: error of a ball's surface against the exact sphere and time per surface, over
// density nodes and smoothing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cuda/surface/density.h"
#include "host/base/interrupt.h"
#include "host/base/machine.h"
#include "host/base/print.h"
#include "host/surface/gpu_surface.h"
#include "host/verify/front.h"

namespace knead {
namespace {

constexpr double radius = 0.25;  // [m]

struct Variant {
    double nodes;  // density nodes per cell, along an axis
    Smoothing smoothing;
    int iterations;
    bool usual;
};

// The defaults of a scene, and variants with one of them changed.
std::vector<Variant> variants(bool quick)
{
    const SurfaceOptions d{};
    std::vector<Variant> all;
    for (const double nodes :
         quick ? std::vector{1.0, 2.0, 3.0} : std::vector{0.5, 1.0, 1.5, 2.0, 3.0, 4.0})
        all.push_back({nodes, d.smoothing, d.iterations, nodes == 2});
    all.push_back({2, Smoothing::none, 0, false});
    if (quick) return all;
    for (const int iterations : {2, 10, 20}) all.push_back({2, d.smoothing, iterations, false});
    all.push_back({2, Smoothing::laplace, d.iterations, false});
    return all;
}

const char* smoothing_name(Smoothing s)
{
    return s == Smoothing::none ? "none" : s == Smoothing::laplace ? "laplace" : "taubin";
}

struct Skin {
    Mesh mesh;
    double seconds;
};

// Time on a GPU: graph replays, without copies to and from the device; on a CPU: the fastest of
// three.
Skin skin(const Verification& v, const Setup& s, const SurfaceOptions& options)
{
    if (v.device.kind == DeviceKind::cuda) {
        GpuSurface surface(s.particles, s.materials, options, {}, v.device.index);
        std::vector<Mesh> meshes = surface.surface(s.particles);
        const std::vector<double> times = surface.replays(v.quick() ? 5 : 50);
        return {std::move(meshes.at(0)), *std::min_element(times.begin(), times.end())};
    }
    Skin best{{}, INFINITY};
    for (int i = 0; i < (v.quick() ? 1 : 3); ++i) {
        const double begun = wall_seconds();
        best.mesh = surface(s.particles, s.materials, options).at(0);
        best.seconds = std::fmin(best.seconds, wall_seconds() - begun);
    }
    return best;
}

// Distances of the vertices from the sphere [m]: rms, and rms about their mean (roughness), which
// excludes the uniform shrinkage of a round body by smoothing.
struct Off {
    double rms, rough;
};
Off off_sphere(const Mesh& mesh, Place middle)
{
    double sum = 0, squares = 0;
    const double n = double(mesh.vertices.size());
    for (const Vec3<float> x : mesh.vertices) {
        const double d = length(cast<double>(x) - middle) - radius;
        sum += d / n, squares += d * d / n;
    }
    return {std::sqrt(squares), std::sqrt(std::fmax(squares - sum * sum, 0))};
}

struct Line {
    Variant by;
    Off off;
    double seconds, volume;  // [s], over the ball's
    std::string name() const
    {
        return fmt::format("{} nodes a cell, {} {}", by.nodes, smoothing_name(by.smoothing),
                           by.iterations);
    }
    bool beats(const Line& other) const
    {
        return off.rough <= other.off.rough && seconds <= other.seconds &&
               (off.rough < other.off.rough || seconds < other.seconds);
    }
};

Line measured(const Verification& v, const Setup& s, Place middle, const Variant& by)
{
    SurfaceOptions made;
    const auto nodes = [&](int n) { return int(std::ceil(n * by.nodes / 8)) * 8; };
    const Int3 n = s.lattice.size;
    made.lattice = {{nodes(n.x), nodes(n.y), nodes(n.z)}, float(s.lattice.dx / by.nodes)};
    made.smoothing = by.smoothing, made.iterations = by.iterations;
    const Skin skinned = skin(v, s, made);
    const double whole = 4 * std::numbers::pi / 3 * radius * radius * radius;
    return {by, off_sphere(skinned.mesh, middle), skinned.seconds, volume(skinned.mesh) / whole};
}

void add_line(Verification& v, int cells, const Line& a, const std::vector<Line>& all)
{
    const auto by = std::find_if(all.begin(), all.end(), [&](const Line& b) { return b.beats(a); });
    const bool beaten = by != all.end();
    v.add(VerifyRow{fmt::format("surface of a ball of {} m on {} cells/m", 2 * radius, cells),
                    a.name(),
                    beaten ? "beaten by " + by->name() : "front",
                    {{"error_mm", 1e3 * a.off.rms},
                     {"rough_mm", 1e3 * a.off.rough},
                     {"volume_percent", 100 * (a.volume - 1)},
                     {"seconds", a.seconds},
                     {"nodes_per_cell", a.by.nodes},
                     {"iterations", double(a.by.iterations)},
                     {"default", double(a.by.usual)}}});
    if (v.options.json || v.options.quiet) return;
    print(fmt::format(
        "    surface: {:<30} {:>7.4f} mm off, {:.4f} rough, {:+.3f} % volume  {:>9.6f} s{}{}\n",
        a.name(), 1e3 * a.off.rms, 1e3 * a.off.rough, 100 * (a.volume - 1), a.seconds,
        beaten ? "" : "  front", a.by.usual ? "  default" : ""));
}

// Variants better than the default by 10 % in one measure and no worse in the other.
std::string standing(const Line& usual, const std::vector<Line>& all)
{
    std::string text;
    for (const Line& a : all)
        if ((a.off.rough <= usual.off.rough && a.seconds < 0.9 * usual.seconds) ||
            (a.off.rough < 0.9 * usual.off.rough && a.seconds <= usual.seconds))
            text += (text.empty() ? "beaten by " : ", ") + a.name();
    return text.empty() ? "on the front" : text;
}

void check_default(Verification& v, const Setup& s, int cells, const Line& a,
                   const std::vector<Line>& all)
{
    const std::string what = fmt::format("surface of a ball, {} cells per m, defaults: ", cells);
    Check rough = at_most(what + "from its mean sphere, rms, over a cell",
                          a.off.rough / s.lattice.dx, 0.01, "", "raise surface.nodes");
    rough.note = fmt::format("{}: {}", a.name(), standing(a, all));
    v.add(rough);
    const double spacing = std::cbrt(s.materials[0].volume);
    const double taken = kernel_variance<double> * spacing * spacing / radius;
    v.add(near(what + "under the sphere, over variance / radius", a.off.rms / taken, 1, 0.1, "",
               "refine: a surface is softened over a particle's width"));
}

}  // namespace

void surface_front(Verification& v)
{
    v.lap();
    const int cells = FrontSizes{{16}, {32}, {64}}.of(v).front();
    const SceneOptions options = default_options(cells);
    Setup s = between_walls({cells, cells, cells}, 1.0 / cells, ContactMode::separate, 0);
    const Place middle = s.walls.min + Place{0.5 + 0.003, 0.5 - 0.007, 0.5 + 0.011};
    fill_by(s, options, plastic(1e6, 0.3, 1000, 1e5), s.walls.min, s.walls.max,
            [&](Place x) { return radius - length(x - middle); });
    std::vector<Line> all;
    for (const Variant& by : variants(v.quick())) {
        if (interrupted()) return;
        all.push_back(measured(v, s, middle, by));
    }
    for (const Line& a : all) add_line(v, cells, a, all);
    for (const Line& a : all)
        if (a.by.usual) check_default(v, s, cells, a, all);
}

}  // namespace knead
