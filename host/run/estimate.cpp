#include "host/run/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "cuda/splats/deform.h"
#include "host/base/machine.h"
#include "host/scene/foresight.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

constexpr int largest_lump = 24;  // cells along its edge

// A cube of an object's clay, 8 particles a cell, in the middle of a lattice of 32^3 cells.
Setup lump(const Scene& scene, const Object& object, int edge)
{
    Setup setup{};
    const double dx = scene.setup.lattice.dx, h = dx / 2;
    setup.lattice = {{32, 32, 32}, dx};
    setup.walls = walls_inside(setup.lattice, 3, ContactMode::separate, 0);
    setup.threads = scene.setup.threads;
    setup.gravity = scene.setup.gravity, setup.deterministic = scene.setup.deterministic;
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

// Wall time of a substep; not known on a machine that is busy with other work.
struct Timing {
    double seconds = 0;
    bool known = true;
};

// Median over batches of substeps. Not known if batches differ by more than a factor of
// `FrameCost::within` (without the best and the worst), or if this thread had a processor for less
// than half of the time.
Timing substep_time(const Setup& setup, Device device)
{
    constexpr double batch = 4e-3, enough = 0.3;  // [s]
    constexpr std::size_t fewest = 3, most = 7;   // batches
    const double dt = setup.step.fixed;
    const std::unique_ptr<Simulator> solver = make_solver(setup, device);
    const auto seconds_of = [&](int count) {
        const double start = wall_seconds();
        const int done = solver->advance({}, count * dt).substeps;
        return (wall_seconds() - start) / std::max(1, done);
    };
    int count = 2;
    seconds_of(count);  // warm-up
    while (count < 4096 && count * seconds_of(count) < batch) count *= 2;
    std::vector<double> took;
    const double start = wall_seconds(), used = thread_seconds();
    const auto gone = [start] { return wall_seconds() - start; };
    while (took.size() < fewest || (took.size() < most && gone() < enough))
        took.push_back(seconds_of(count));
    const bool held_up = device.kind != DeviceKind::cuda && thread_seconds() - used < 0.5 * gone();
    std::sort(took.begin(), took.end());
    const std::size_t left_out = took.size() > fewest ? 1 : 0;
    const double best = took[left_out], worst = took[took.size() - 1 - left_out];
    return {took[took.size() / 2], !held_up && worst <= FrameCost::within * best};
}

// Cost of a substep for clay of one kind: a fixed part and a part per particle.
struct KindCost {
    double fixed = 0, each = 0;  // [s]
    double whole_each = 0;       // per particle of the larger lump, fixed part included [s]
    double largest = 0;          // particles of the larger lump
    bool known = true;

    // Bounds. Up to the larger lump both are the linear interpolation; beyond it the upper bound
    // assumes no fixed part.
    double least(double particles) const { return fixed + each * particles; }
    double most(double particles) const
    {
        return particles > largest ? std::max(least(particles), whole_each * particles)
                                   : least(particles);
    }
};

using LumpOf = std::function<Setup(int edge)>;

KindCost kind_cost(const LumpOf& lump_of, Device device, double expected)
{
    const bool slow = device.kind == DeviceKind::cpu_double, gpu = device.kind == DeviceKind::cuda;
    int edge = slow ? 3 : gpu ? 12 : 6;
    const auto timed = [&](int of_edge, double& particles) {
        const Setup setup = lump_of(of_edge);
        particles = double(setup.particles.size());
        return substep_time(setup, device);
    };
    double few = 0, many = 0;
    Timing of_few = timed(edge, few);
    for (;;) {
        const Timing of_many = timed(2 * edge, many);
        KindCost cost;
        cost.each = std::max(0.0, (of_many.seconds - of_few.seconds) / (many - few));
        cost.fixed = std::max(0.0, of_many.seconds - cost.each * many);
        cost.whole_each = of_many.seconds / many, cost.largest = many;
        cost.known = of_few.known && of_many.known;
        const bool wide = cost.most(expected) > FrameCost::within * cost.least(expected);
        if (!cost.known || !wide || 4 * edge > largest_lump) return cost;
        edge *= 2, few = many, of_few = of_many;
    }
}

}  // namespace

FrameCost frame_cost(const Scene& scene, Device device, std::size_t gaussians)
{
    const Foresight steps = foresee(scene);
    const bool gpu = device.kind == DeviceKind::cuda;
    const double expected = expected_particles(scene);
    const auto sample = [&](const Object& object, int edge) {
        Setup setup = lump(scene, object, edge);
        setup.step = scene.setup.step, setup.step.fixed = steps.dt;
        return setup;
    };
    // Once per kind of material; on a GPU all kinds cost the same, and creating a solver is slow.
    std::map<std::pair<Elasticity, Plasticity>, KindCost> kinds;
    double particles = 0, least = 0, most = 0, local = 0;
    bool known = true;
    for (const Object& object : scene.objects) {
        const Object& of = gpu ? scene.objects[0] : object;
        const auto [at, fresh] =
            kinds.try_emplace({of.material.elasticity, of.material.plasticity}, KindCost{});
        if (fresh)
            at->second = kind_cost([&](int edge) { return sample(of, edge); }, device, expected);
        const KindCost& cost = at->second;
        known = known && cost.known;
        const double count = shape_volume(object) * object.per_cell;
        particles += count;
        least += count * cost.least(expected), most += count * cost.most(expected);
        if (object.local()) local = cost.whole_each;
    }
    // Mean over the objects, weighted by particles, each as if all clay were of its kind.
    double substep = particles > 0 ? least / particles : 0;
    if (particles > 0) known = known && most <= FrameCost::within * least;
    if (gaussians > 0) {
        const Material<double>& m = scene.objects[0].material;
        const KindCost& without = kinds.at({m.elasticity, m.plasticity});
        Setup setup = sample(scene.objects[0], gpu ? 24 : 6);
        const std::size_t side = std::size_t(std::lround(std::cbrt(setup.particles.size())));
        for (std::size_t i = 0; i < side * side; ++i)  // on a face
            for (int k = 0; k < 8; ++k)
                setup.gaussians.push_back(gaussian_at(setup.particles[i].x, 0));
        const Timing with = substep_time(setup, device);
        const double more = with.seconds - without.least(double(setup.particles.size()));
        substep += std::max(0.0, more) / double(setup.gaussians.size()) * double(gaussians);
        known = known && with.known;
    }
    return {particles == 0, substep * steps.substeps, 1000 * local * steps.substeps, known};
}

std::string cost_text(const FrameCost& cost)
{
    if (cost.known && cost.still && cost.per_thousand == 0)
        return "what a frame takes depends on the clay that is added";
    if (!cost.known && cost.still) return "what a frame takes depends on the hands";
    if (!cost.known)
        return "the time of a frame on this machine is unknown: its speed changed during the "
               "measurement";
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
