#include "host/splats/upkeep.h"

#include <cmath>

namespace knead {
namespace {

// Of the particles of each object that has Gaussians [m]; 0 of the others.
std::vector<double> spacings(const Setup& rules, const std::vector<Gaussian<double>>& gaussians,
                             int below_object)
{
    std::vector<double> all(rules.materials.size(), 0);
    for (const Gaussian<double>& g : gaussians) {
        if (g.object >= below_object) continue;
        const auto object = std::size_t(g.object);
        all[object] = std::cbrt(rules.materials[object].volume);
    }
    return all;
}

}  // namespace

SplatUpkeep::SplatUpkeep(const UpkeepRule& by, SplatCloud cloud)
    : rule(by), splats(carried(std::move(cloud)))
{
    expect(0);
}

void SplatUpkeep::expect(std::size_t more)
{
    const std::size_t most = rule.capacity > 0 ? rule.capacity : 3 * (splats.count() + more);
    rule.split.capacity = rule.refill.capacity = most;
}

UpkeepReport SplatUpkeep::after(int frame, Solver& solver)
{
    UpkeepReport report;
    if (!any() || frame % rule.every != 0) return report;
    std::vector<Gaussian<double>> gaussians = solver.gaussians();
    const WallRule& walls = solver.rules().walls;
    if (rule.splits) {
        const SplitReport done = split(splats, gaussians, rule.split, walls);
        report.split = done.split, report.waiting += done.waiting;
    }
    if (rule.refills) {
        const std::vector<double> s = spacings(solver.rules(), gaussians, refilled);
        const RefillReport done =
            refill(splats, gaussians, solver.particles(), s, rule.refill, walls);
        report.added = done.added, report.waiting += done.waiting;
    }
    if (report.split + report.added > 0) solver.set_gaussians(gaussians);
    return report;
}

}  // namespace knead
