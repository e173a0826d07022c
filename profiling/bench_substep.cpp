// Time per substep of a ball of clay between two closing tools, or in the hands of
// scenes/squeeze.json from their first contact on, with what was computed: a hash of the particles,
// to see whether a change of speed was a change of result.
// usage: bench_substep [nodes=64] [frames=30] [gpu|cpu|deterministic] [tools=1] [plastic=1]
//                      [Gaussians=0] [dt=0] [--overlaps MASK]
//        bench_substep hands [frames=30] [gpu|cpu|deterministic] [--overlaps MASK]
// dt: of every substep [us], so that two versions take the same; 0: as stability asks.
// MASK: which kernels of a substep may overlap, bits of cuda/mpm/overlap.h, in decimal or in hex
// with 0x; 0: plain stream order.
#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "host/base/machine.h"
#include "host/bench/ball.h"
#include "host/bench/bench.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/gpu/overlaps.h"

namespace {

using namespace knead;

// FNV-1a over the particles' bits in the scene's order.
std::uint64_t hash_of(const std::vector<Particle<double>>& particles)
{
    std::uint64_t h = 14695981039346656037ull;
    const auto mix = [&h](double x) {
        auto bits = std::bit_cast<std::uint64_t>(x);
        for (int k = 0; k < 8; ++k, bits >>= 8) h = (h ^ (bits & 255)) * 1099511628211ull;
    };
    for (const Particle<double>& q : particles)
        for (double x : {q.x.x, q.x.y, q.x.z, q.v.x, q.v.y, q.v.z, q.e.xx, q.e.yy, q.e.zz, q.k})
            mix(x);
    return h;
}

double seconds()
{
    using namespace std::chrono;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}

void report(const Simulator& solver, std::vector<double>& per_substep, const FrameStats& total,
            double count)
{
    std::sort(per_substep.begin(), per_substep.end());
    const double median = per_substep[per_substep.size() / 2], best = per_substep.front();
    std::printf("median %.2f us, best %.2f us per substep: %.3f G particle-substeps/s\n",
                1e6 * median, 1e6 * best, 1e-9 * count / median);
    std::printf("%d substeps, dt %.3g to %.3g s, %ld blocks, %.1f MiB\n", total.substeps,
                total.dt_min, total.dt_max, total.active_blocks, double(solver.memory()) / 1048576);
    each_statistic([&](const auto& row) {
        if constexpr (is_count<std::remove_cvref_t<decltype(row.member)>>)
            if (total[row.member] > 0)
                std::printf("%s %ld %s, ", row.name, total[row.member], row.unit);
    });
    std::printf("deepest %.3g m\n", total.found_depth);
    for (const StageTime& t : stage_times(solver))
        std::printf("  %-10s %9.2f us in the last frame\n", t.name.c_str(), 1e6 * t.seconds);
    std::printf("hash %016llx\n", static_cast<unsigned long long>(hash_of(solver.particles())));
}

int run(int nodes, int frames, const std::string& on, bool tools, bool plastic, int gaussians,
        int dt)
{
    Setup setup = ball(nodes);
    setup.step.fixed = 1e-6 * dt;
    add_gaussians(setup, gaussians);
    if (tools) add_tools(setup);
    if (!plastic) setup.materials[0].plasticity = Plasticity::none;
    setup.deterministic = on == "deterministic";
    const double count = double(setup.particles.size());
    const auto solver = on == "cpu" ? cpu_solver(setup) : gpu_solver(setup, 0);
    std::printf("%s: %.0f particles, %d^3 nodes, %s, %s\n", solver->name().c_str(), count, nodes,
                tools ? "two tools" : "no tool", plastic ? "von Mises" : "elastic");
    const double frame = 1.0 / 90;
    std::vector<double> per_substep;
    FrameStats total;
    for (int f = 0; f < frames; ++f) {
        const Motion motion = closing(f * frame, frame);
        const double start = seconds();
        const FrameStats t = solver->advance(motion, frame);
        per_substep.push_back((seconds() - start) / std::max(t.substeps, 1));
        add_to(total, t);
    }
    report(*solver, per_substep, total, count);
    return 0;
}

int run_hands(int frames, const std::string& on)
{
    Scene scene = read_scene("scenes/squeeze.json");
    build(scene, available_memory());
    scene.setup.deterministic = on == "deterministic";
    const HandSource hands(hands_of(scene), scene.hands);
    const double count = double(scene.setup.particles.size());
    const auto solver = on == "cpu" ? cpu_solver(scene.setup) : gpu_solver(scene.setup, 0);
    std::printf("%s: %.0f particles, %s\n", solver->name().c_str(), count, scene.name.c_str());
    constexpr int warm_up = 5;  // frames before contact, not timed
    std::vector<double> per_substep;
    FrameStats total;
    drive(scene, *solver, &hands, std::max(0, first_contact(scene, hands) - warm_up),
          [&](const FrameResult& f) {
              if (f.number <= warm_up) return true;
              per_substep.push_back(f.times.solver / std::max(f.stats.substeps, 1));
              add_to(total, f.stats);
              return int(per_substep.size()) < frames;
          });
    report(*solver, per_substep, total, count);
    return 0;
}

}  // namespace

int main(int count, char** words)
{
    unsigned overlaps = overlap::all;
    const bool masked = count > 2 && std::strcmp(words[count - 2], "--overlaps") == 0;
    if (masked) overlaps = unsigned(std::strtoul(words[count - 1], nullptr, 0)), count -= 2;
    const auto number = [&](int at, int otherwise) {
        return count > at ? std::atoi(words[at]) : otherwise;
    };
    const bool with_hands = count > 1 && std::strcmp(words[1], "hands") == 0;
    const int nodes = with_hands ? 64 : number(1, 64), frames = number(2, 30);
    const std::string on = count > 3 ? words[3] : "gpu";
    if (nodes < 16 || nodes > 512 || nodes % 4 || frames < 1 ||
        (on != "gpu" && on != "cpu" && on != "deterministic")) {
        std::fprintf(stderr,
                     "usage: bench_substep [nodes: 16 to 512, by 4] [frames] "
                     "[gpu|cpu|deterministic] [tools 0|1] [plastic 0|1] [Gaussians] [dt in us] "
                     "[--overlaps MASK]\n"
                     "       bench_substep hands [frames] [gpu|cpu|deterministic] "
                     "[--overlaps MASK]\n");
        return 2;
    }
    try {
        const gpu::WithOverlaps only(overlaps);
        if (with_hands) return run_hands(frames, on);
        return run(nodes, frames, on, number(4, 1) != 0, number(5, 1) != 0, number(6, 0),
                   number(7, 0));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 4;
    }
}
