#include "host/splats/upkeep.h"

#include <atomic>
#include <cmath>

namespace knead {
namespace {

// Particle spacing of each object with Gaussians [m]; 0 for the others.
std::vector<double> spacings(const SimulationConfig& rules,
                             const std::vector<Gaussian<double>>& gaussians, int below_object)
{
    std::vector<double> all(rules.materials.size(), 0);
    for (const Gaussian<double>& g : gaussians) {
        if (g.object >= below_object) continue;
        const auto object = std::size_t(g.object);
        all[object] = std::cbrt(rules.materials[object].volume);
    }
    return all;
}

std::size_t capacity_of(const CarriedSplats& splats) { return splats.cloud.centre.capacity(); }

}  // namespace

SplatUpkeep::SplatUpkeep(const UpkeepOptions& by, SplatCloud cloud)
    : options(by), splats(std::make_shared<CarriedSplats>(carried(std::move(cloud))))
{
    raise_capacity(0);
}

void SplatUpkeep::raise_capacity(std::size_t more)
{
    const std::size_t most = options.capacity > 0 ? options.capacity : 3 * (splats->count() + more);
    options.split.capacity = options.refill.capacity = most;
}

// Released memory is reused: first-touching new memory takes longer than writing it.
void SplatUpkeep::set_state(CarriedSplats state)
{
    if (!spare || spare.use_count() > 1 || capacity_of(*splats) > capacity_of(*spare))
        spare = splats;
    splats = std::make_shared<CarriedSplats>(std::move(state));
}

CarriedSplats& SplatUpkeep::change(std::size_t more)
{
    const std::size_t wanted = splats->count() + more;
    if (splats.use_count() > 1 || capacity_of(*splats) < wanted) {
        if (!spare || spare.use_count() > 1) spare = std::make_shared<CarriedSplats>();
        std::atomic_thread_fence(std::memory_order_acquire);  // all readers have released it
        spare->cloud.degree = splats->cloud.degree;
        if (capacity_of(*spare) < wanted) {
            reserve(spare->cloud, wanted + wanted / 4);
            spare->extent.reserve(wanted + wanted / 4);
        }
        *spare = *splats;
        std::swap(splats, spare);
    }
    std::atomic_thread_fence(std::memory_order_acquire);
    return *splats;
}

UpkeepPlan UpkeepTask::plan(const SnapshotData& held, const SimulationConfig& rules) const
{
    UpkeepPlan plan{std::make_shared<CarriedSplats>(*splats), {}, 0};
    std::vector<Gaussian<double>> gaussians = held.gaussians;
    if (options.splits) {
        SplitReport done = split(*plan.splats, gaussians, options.split, rules.walls);
        plan.edits.splits = std::move(done.splits), plan.waiting += done.waiting;
    }
    if (options.refills) {
        const std::vector<double> s = spacings(rules, gaussians, refilled);
        RefillReport done =
            refill(*plan.splats, gaussians, held.particles, s, options.refill, rules.walls);
        plan.edits.added = std::move(done.added), plan.waiting += done.waiting;
    }
    return plan;
}

UpkeepReport SplatUpkeep::adopt(UpkeepPlan plan, EditableSimulator& solver)
{
    const UpkeepReport report{plan.edits.splits.size(), plan.edits.added.size(), plan.waiting};
    if (!plan.edits.any()) return report;
    solver.edit_gaussians(plan.edits);
    splats = std::move(plan.splats);
    return report;
}

UpkeepReport SplatUpkeep::after(int frame, EditableSimulator& solver)
{
    if (!due(frame)) return {};
    SnapshotData held;
    held.gaussians = solver.gaussians();
    if (options.refills) held.particles = solver.particles();
    return adopt(task().plan(held, solver.config()), solver);
}

}  // namespace knead
