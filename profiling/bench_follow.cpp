// How often Gaussians must hear of the clay's motion: every substep; every k-th, with the velocity
// held until the next, or with that of the last for all that they are behind, as the solvers do; in
// k groups that take turns, each so and all of them in a frame's last substep; out of tools each
// time, or every so many times and in a frame's last substep, or only then; or once a frame by
// the composed motion of the nodes, each of which is carried along through all substeps of the
// frame. The paper's ball, soft enough to flow, turns and is pressed by two cones; errors are from
// every substep, after the last frame.
//
//   bench_follow [nodes] [frames] [Gaussians] [substeps a frame] [turns: rad/s]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "host/bench/ball.h"
#include "host/solver/reference.h"
#include "host/solver/substep.h"

namespace {

using namespace knead;
using Gaussians = std::vector<Gaussian<double>>;
constexpr double frame = 1.0 / 90;

// What follows the clay in one way.
enum class Mode { held, behind, in_turns, composed };
struct Way {
    std::string name;
    Mode mode;
    int every = 1;  // substeps
    int out = 1;    // every so many times they follow, and in a frame's last, out of tools
    Gaussians gaussians{};
    double seconds = 0;
};

struct Clay {
    const Setup& setup;
    const Reference& solver;
    double per_mass;

    NodeShare<double> node(Int3 n) const
    {
        return node_share(solver.nodes()[std::size_t(setup.lattice.index(n))], per_mass);
    }
};

double seconds_of(const std::function<void()>& work)
{
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double squared(const Mat3<double>& A) { return dot(A.a, A.a) + dot(A.b, A.b) + dot(A.c, A.c); }

// Those that `go`, by their index, through so many substeps of dt [s].
template <class Go, class NodeAt>
void carry_those(Gaussians& all, const Clay& clay, double dt, int substeps, bool out, Go&& go,
                 NodeAt&& node)
{
    const Lattice<double>& l = clay.setup.lattice;
    const Colliders<double> tools = clay.solver.colliders();
    const Walls<double> walls = walls_on<double>(l, clay.setup.walls);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!go(i)) continue;
        Gaussian<double>& g = all[i];
        const Gaussian<double> start = g;
        const Int3 base = base_node(g.x, l.spacing);
        deform(g, l.spacing, dt, substeps, [&](Int3 step) { return node(base + step); });
        const int passes = out ? clay.setup.passes : 0;
        keep_out(g, tools, clay.solver.acting(), passes, false, walls, l.dx);
        repair(g, start);
    }
}

// The nodes' own way through a frame.
struct Composed {
    std::vector<std::size_t> moved;  // that held clay when the frame began
    std::vector<Vec3<double>> way;   // of each node [m]
    std::vector<double> share;

    void begin(const Clay& clay)
    {
        const auto count = clay.solver.nodes().size();
        moved.clear(), way.assign(count, {0, 0, 0}), share.assign(count, 0);
        for (std::size_t n = 0; n < count; ++n)
            if (clay.solver.nodes()[n].m > 0) {
                moved.push_back(n);
                share[n] = knead::share(clay.solver.nodes()[n].m, clay.per_mass);
            }
    }
    void go_on(const Clay& clay, double dt)
    {
        const Lattice<double>& l = clay.setup.lattice;
        for (const std::size_t n : moved) {
            const Vec3<double> at = l.position(l.node_at(int(n))) + way[n];
            const Int3 base = base_node(at, l.spacing);
            if (base.x < 0 || base.y < 0 || base.z < 0 || base.x + 3 > l.size.x ||
                base.y + 3 > l.size.y || base.z + 3 > l.size.z)
                continue;
            bool held = false;
            const LinearField<double> f =
                field_at(at, l.spacing, held, [&](Int3 step) { return clay.node(base + step); });
            if (held) way[n] = way[n] + dt * f.v;
        }
    }
};

// Substep s of a frame.
void follow(Way& w, const Clay& clay, double dt, int s, int substeps)
{
    const auto node = [&](Int3 n) { return clay.node(n); };
    const auto any = [](std::size_t) { return true; };
    const int every = w.every;
    const bool last = s + 1 == substeps;
    if (w.mode == Mode::held) {
        if (s % every) return;
        carry_those(w.gaussians, clay, std::min(every, substeps - s) * dt, 1, true, any, node);
    } else if (w.mode == Mode::behind) {
        if ((s + 1) % every && !last) return;
        const bool out = last || (s + 1) / every % w.out == 0;
        carry_those(w.gaussians, clay, dt, s % every + 1, out, any, node);
    } else {
        for (int g = 0; g < every; ++g) {
            const int since = s >= g ? (s - g) % every : s + 1;  // its last turn: 0 is now
            const int behind = since == 0 ? std::min(every, s + 1) : since;
            if (since == 0 || last)
                carry_those(
                    w.gaussians, clay, dt, behind, true,
                    [&](std::size_t i) { return int(i / 128) % every == g; }, node);
        }
    }
}

std::vector<Way> ways_of(int substeps)
{
    std::vector<Way> ways{{"every substep", Mode::held, 1}};
    for (const int k : {2, 4, 8}) ways.push_back({fmt::format("held, {}", k), Mode::held, k});
    ways.push_back({"held, a frame", Mode::held, substeps});
    for (const int k : {2, 3, 4}) ways.push_back({fmt::format("behind, {}", k), Mode::behind, k});
    ways.push_back({"behind, 2, out each 4th", Mode::behind, 2, 4});
    ways.push_back({"behind, 2, out at the end", Mode::behind, 2, substeps});
    for (const int k : {2, 3, 4})
        ways.push_back({fmt::format("in turns, {}", k), Mode::in_turns, k});
    ways.push_back({"composed, a frame", Mode::composed});
    return ways;
}

void report(const std::vector<Way>& ways, double dx, int frames)
{
    fmt::print("{:26} {:>10} {:>12} {:>12} {:>12} {:>12}\n", "way", "ms/frame", "x rms [dx]",
               "x max [dx]", "F rms", "det F rms");
    for (const Way& w : ways) {
        double x = 0, most = 0, F = 0, volume = 0;
        const auto n = double(w.gaussians.size());
        for (std::size_t i = 0; i < w.gaussians.size(); ++i) {
            const Gaussian<double>&a = w.gaussians[i], &b = ways[0].gaussians[i];
            const double off = length(a.x - b.x) / dx, f = std::sqrt(squared(a.F - b.F));
            const double v = determinant(a.F) - determinant(b.F);
            x += off * off / n, most = std::max(most, off), F += f * f / n, volume += v * v / n;
        }
        fmt::print("{:26} {:10.2f} {:12.5f} {:12.4f} {:12.5f} {:12.5f}\n", w.name,
                   1e3 * w.seconds / frames, std::sqrt(x), most, std::sqrt(F), std::sqrt(volume));
    }
}

}  // namespace

int main(int argc, char** argv)
{
    const auto number = [&](int k, int otherwise) {
        return argc > k ? std::max(std::atoi(argv[k]), 1) : otherwise;
    };
    const int nodes = number(1, 32), frames = number(2, 15), count = number(3, 60000),
              substeps = number(4, 24);
    Setup scene = ball(nodes);
    scene.materials[0].yield = 1e4;
    add_tools(scene);
    const double rate = argc > 5 ? std::atof(argv[5]) : 0;
    for (Particle<double>& p : scene.particles) {
        p.v = cross(Vec3<double>{0, 0, rate}, p.x - Vec3<double>{0.5, 0.5, 0.5});
        p.C = {{0, rate, 0}, {-rate, 0, 0}, {0, 0, 0}};
    }
    Reference solver(scene);
    const Clay clay{scene, solver, 1 / lightest_particle(scene)};
    std::vector<Way> ways = ways_of(substeps);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> within(-0.25, 0.25);
    while (ways[0].gaussians.size() < std::size_t(count)) {
        const Vec3<double> d{within(random), within(random), within(random)};
        if (length(d) < 0.25)
            ways[0].gaussians.push_back(gaussian_at(Vec3<double>{0.5, 0.5, 0.5} + d, 0));
    }
    for (Way& w : ways) w.gaussians = ways[0].gaussians;
    Composed composed;
    const double dt = frame / substeps;
    for (int f = 0; f < frames; ++f) {
        const Motion motion = closing(f * frame, frame);
        for (int s = 0; s < substeps; ++s) {
            solver.pose(motion, double(s) / substeps, double(s + 1) / substeps, dt);
            solver.p2g(dt), solver.grid(dt);
            for (Way& w : ways)
                w.seconds += seconds_of([&] {
                    if (w.mode != Mode::composed) return follow(w, clay, dt, s, substeps);
                    if (s == 0) composed.begin(clay);
                    composed.go_on(clay, dt);
                });
            solver.g2p(dt), solver.project(dt), solver.plasticity(dt), solver.repair();
        }
        Way& last = ways.back();
        last.seconds += seconds_of([&] {
            carry_those(
                last.gaussians, clay, 1, 1, true, [](std::size_t) { return true; },
                [&](Int3 n) {
                    const auto i = std::size_t(scene.lattice.index(n));
                    return NodeShare<double>{composed.way[i], composed.share[i]};
                });
        });
    }
    fmt::print("{} particles, {} Gaussians, {} frames of {} substeps\n", scene.particles.size(),
               count, frames, substeps);
    report(ways, scene.lattice.dx, frames);
}
