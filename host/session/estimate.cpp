#include "host/session/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "cuda/splats/deform.h"
#include "host/base/machine.h"
#include "host/scene/foresight.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

// A cube of an object's clay, 8 particles a cell, in the middle of a lattice of 32 cells.
Setup lump(const Scene& scene, const Object& object, int edge)
{
    Setup setup{};
    const double dx = scene.setup.lattice.dx, h = dx / 2;
    setup.lattice = {{32, 32, 32}, dx};
    setup.walls = walls_inside(setup.lattice, 3, ContactMode::separate, 0);
    setup.threads = scene.setup.threads;
    setup.gravity = scene.setup.gravity;
    Material<double> material = object.material;
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

// What a substep takes [s].
double substep_seconds(const Setup& setup, Device device)
{
    const double dt = setup.step.fixed;
    const std::unique_ptr<Solver> solver = make_solver(setup, device);
    solver->advance({}, 2 * dt);     // the first of all is slower
    constexpr double enough = 0.02;  // [s]
    double took = 0;
    long substeps = 0;
    for (int count = 2; took < enough && count < 4096; count *= 2) {
        const double begin = wall_seconds();
        substeps += solver->advance({}, count * dt).substeps;
        took += wall_seconds() - begin;
    }
    return substeps == 0 ? 0 : took / double(substeps);
}

}  // namespace

FrameCost frame_cost(const Scene& scene, Device device, std::size_t gaussians)
{
    const Foresight steps = foresee(scene);
    const bool slow = device.kind == DeviceKind::cpu_double, gpu = device.kind == DeviceKind::cuda;
    const auto sample = [&](const Object& object) {
        Setup setup = lump(scene, object, slow ? 6 : gpu ? 24 : 12);
        setup.step = scene.setup.step, setup.step.fixed = steps.dt;
        return setup;
    };
    // Of each kind of material once; on a GPU they cost alike, and a solver takes long to make.
    std::map<std::pair<Elasticity, Plasticity>, double> known;  // [s] a particle and substep
    double particles = 0, cost = 0, local = 0;
    for (const Object& object : scene.objects) {
        const Material<double>& m = gpu ? scene.objects[0].material : object.material;
        const auto [at, fresh] = known.try_emplace({m.elasticity, m.plasticity}, 0);
        if (fresh) {
            const Setup setup = sample(object);
            at->second = substep_seconds(setup, device) / double(setup.particles.size());
        }
        const double count = shape_volume(object) * object.per_cell;
        particles += count, cost += count * at->second;
        if (object.local()) local = at->second;
    }
    double substep = particles > 0 ? cost / particles * expected_particles(scene) : 0;
    if (gaussians > 0) {
        const Material<double>& m = scene.objects[0].material;
        Setup setup = sample(scene.objects[0]);
        const double without =
            known.at({m.elasticity, m.plasticity}) * double(setup.particles.size());
        const std::size_t side = std::size_t(std::lround(std::cbrt(setup.particles.size())));
        for (std::size_t i = 0; i < side * side; ++i)  // on a face
            for (int k = 0; k < 8; ++k)
                setup.gaussians.push_back(gaussian_at(setup.particles[i].x, 0));
        const double more = substep_seconds(setup, device) - without;
        substep += std::max(0.0, more) / double(setup.gaussians.size()) * double(gaussians);
    }
    return {particles == 0, substep * steps.substeps, 1000 * local * steps.substeps};
}

std::string cost_text(const FrameCost& cost)
{
    const std::string local =
        fmt::format("about {:.2g} s{} for each 1000 particles of clay that comes with the hands",
                    cost.per_thousand, cost.still ? " on this machine" : " more");
    if (cost.still) return "what a frame takes depends on the hands: " + local;
    return fmt::format("about {:.2g} s a frame on this machine, without hands and surface",
                       cost.seconds) +
           (cost.per_thousand > 0 ? "; " + local : "");
}

std::string cost_text(const Scene& built, Device device)
{
    const Setup& setup = built.setup;
    return cost_text(frame_cost(built, device, setup.gaussians.size()));
}

}  // namespace knead
