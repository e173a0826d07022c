#include "host/session/estimate.h"

#include <chrono>

#include "host/scene/foresight.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

// A cube of clay, 8 particles a cell, in the middle of a lattice of 32 cells.
Setup lump(const Scene& scene, int edge)
{
    Setup setup{};
    const double dx = scene.setup.lattice.dx, h = dx / 2;
    setup.lattice = {{32, 32, 32}, dx};
    setup.walls = walls_inside(setup.lattice, 3, ContactMode::separate, 0);
    setup.threads = scene.setup.threads;
    setup.gravity = scene.setup.gravity;
    Material<double> material = scene.objects[0].material;
    material.volume = h * h * h, material.mass = material.density * material.volume;
    setup.materials = {material};
    const double low = dx * (16 - edge / 2.0);
    for (int k = 0; k < 2 * edge; ++k)
        for (int j = 0; j < 2 * edge; ++j)
            for (int i = 0; i < 2 * edge; ++i) {
                Particle<double> q{};
                q.x = {low + h * (i + 0.5), low + h * (j + 0.5), low + h * (k + 0.5)};
                setup.particles.push_back(q);
            }
    return setup;
}

}  // namespace

double frame_seconds(const Scene& scene, Device device)
{
    using Clock = std::chrono::steady_clock;
    const Foresight steps = foresee(scene);
    const bool slow = device.kind == DeviceKind::cpu_double;
    Setup setup = lump(scene, slow ? 6 : device.kind == DeviceKind::cuda ? 24 : 12);
    setup.step = scene.setup.step, setup.step.fixed = steps.dt;
    const double particles = double(setup.particles.size());
    const std::unique_ptr<Solver> solver = make_solver(setup, device);
    solver->advance({}, 2 * steps.dt);  // the first of all is slower
    constexpr double enough = 0.02;     // [s]
    double took = 0;
    long substeps = 0;
    for (int count = 2; took < enough && count < 4096; count *= 2) {
        const Clock::time_point begin = Clock::now();
        substeps += solver->advance({}, count * steps.dt).substeps;
        took += std::chrono::duration<double>(Clock::now() - begin).count();
    }
    if (substeps == 0) return 0;
    return took / (particles * double(substeps)) * expected_particles(scene) * steps.substeps;
}

}  // namespace knead
