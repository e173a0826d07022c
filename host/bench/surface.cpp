// Cost of a surface of a state, on the solver's device.
#include "host/surface/surface.h"

#include <algorithm>

#include "cuda/mpm/stencil.h"
#include "host/base/machine.h"
#include "host/bench/bench.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/surface/gpu_surface.h"

namespace knead {
namespace {

template <class Work>
double seconds(Work&& work)
{
    const double start = wall_seconds();
    work();
    return wall_seconds() - start;
}

// Sorted by lattice cell, as in a GPU solver.
std::vector<Particle<double>> by_cell(std::vector<Particle<double>> all,
                                      const Lattice<double>& lattice)
{
    std::vector<std::pair<int, std::size_t>> order;
    for (std::size_t i = 0; i < all.size(); ++i)
        order.push_back({lattice.index(base_node(all[i].x, lattice.dx)), i});
    std::sort(order.begin(), order.end());
    std::vector<Particle<double>> sorted;
    sorted.reserve(all.size());
    for (const auto& [cell, i] : order) sorted.push_back(all[i]);
    return sorted;
}

SurfaceTimes on_gpu(const std::vector<Particle<double>>& state, const Scene& scene, int device,
                    int count)
{
    const std::vector<Particle<double>> sorted = by_cell(state, scene.setup.lattice);
    GpuSurface surface(sorted, scene.setup.materials, scene.surface, {}, device);
    surface.surface(sorted);
    surface.replays(5);
    SurfaceTimes times;
    times.whole = surface.replays(20 * count);
    times.stages = surface.stage_times();
    times.bytes = surface.memory();
    times.note = "by a graph, from particles already on the device in the order of their cells";
    return times;
}

SurfaceTimes on_cpu(const std::vector<Particle<double>>& state, const Scene& scene, int count)
{
    std::vector<Deposit> deposits;
    for (const Particle<double>& q : state) {
        const Material<double>& m = scene.setup.materials[std::size_t(q.object)];
        deposits.push_back({cast<float>(q.x), float(m.volume)});
    }
    SurfaceTimes times;
    std::vector<double> parts[3];
    for (int k = 0; k < count; ++k) {
        times.whole.push_back(
            seconds([&] { surface(state, scene.setup.materials, scene.surface); }));
        Field field;
        Mesh mesh;
        parts[0].push_back(seconds([&] { field = density(deposits, scene.surface.lattice); }));
        parts[1].push_back(seconds([&] { mesh = isosurface(field, scene.surface.iso); }));
        parts[2].push_back(
            seconds([&] { smooth(mesh, scene.surface.smoothing, scene.surface.iterations); }));
    }
    times.stages = {{"density", spread(parts[0]).median},
                    {"march", spread(parts[1]).median},
                    {"smooth", spread(parts[2]).median}};
    times.note = "on the CPU";
    return times;
}

}  // namespace

SurfaceTimes surface_times(const std::vector<Particle<double>>& state, const Scene& scene,
                           Device device, int count)
{
    return device.kind == DeviceKind::cuda ? on_gpu(state, scene, device.index, count)
                                           : on_cpu(state, scene, count);
}

std::vector<StageWork> surface_counts(const std::vector<Particle<double>>& state,
                                      const Scene& scene, Device device)
{
    if (device.kind != DeviceKind::cuda) return {};
    const std::vector<Particle<double>> sorted = by_cell(state, scene.setup.lattice);
    GpuSurface surface(sorted, scene.setup.materials, scene.surface, {}, device.index);
    surface.surface(sorted);
    return surface.stage_counts();
}

KeptTimes kept_surface_times(const Scene& scene, Device device, int warm_up, int frames)
{
    const HandSource hands(hands_of(scene), scene.hands);
    const std::unique_ptr<Simulator> solver = make_solver(scene.setup, device);
    const auto made = [&] {
        return std::make_unique<GpuSurface>(scene.setup.particles, scene.setup.materials,
                                            scene.surface, SurfaceRoom{}, device.index);
    };
    const auto time = [](GpuSurface& of, std::vector<double>& to) {
        to.push_back(of.replays(1).at(0));
    };
    const auto kept = made(), whole = made();
    KeptTimes times;
    drive(scene, *solver, &hands, std::max(0, first_contact(scene, hands)),
          [&](const FrameResult& f) {
              const int timed = f.number - 1 - warm_up;
              if (timed == 0)
                  for (const auto& each : {&kept, &whole}) (*each)->surface(*solver->clay());
              if (timed <= 0) return true;
              whole->forget();
              // Alternating order: the first finds a cold cache.
              if (f.number % 2 == 0) time(*kept, times.kept);
              time(*whole, times.whole);
              if (f.number % 2) time(*kept, times.kept);
              const SurfaceWork work = kept->work();
              times.anew += double(work.smoothed) / double(work.blocks) / frames;
              return timed < frames;
          });
    times.bytes = kept->memory();
    return times;
}

}  // namespace knead
