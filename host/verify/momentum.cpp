// accuracy: linear and angular momentum of a free ball that translates, rotates and vibrates.
#include <fmt/format.h>

#include "host/solver/audit.h"
#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

Setup flying_ball()
{
    constexpr double dx = 0.01;
    Setup s = between_walls({24, 24, 24}, dx, ContactMode::separate, 0.3);
    const Place low = s.walls.min, middle = low + Place{12 * dx, 12 * dx, 12 * dx};
    fill(s, elastic(1e5, 0.3, 1000), low, s.walls.max, 2,
         [&](Place x) { return length(x - middle) < 5 * dx; });
    const Vec3<double> w{20, 35, -15};  // [1/s]
    for (Particle<double>& q : s.particles) {
        const Place r = q.x - middle;
        q.v = Vec3<double>{0.3, -0.2, 0.25} + cross(w, r) + Vec3<double>{8 * r.x, -3 * r.y, 0};
        q.C = {{8, w.z, -w.y}, {-w.z, -3, w.x}, {w.y, -w.x, 0}};
    }
    s.step.fixed = 1e-4;
    return s;
}

void conserved(Verification& v, const Setup& s, Simulator& solver, const char* scalar, double bound)
{
    const Audit before = audit(solver.particles(), s.materials, s.lattice.dx);
    solver.advance({}, 0.1);  // 1000 substeps
    const Audit after = audit(solver.particles(), s.materials, s.lattice.dx);
    const auto relative_error = [](Vec3<double> a, Vec3<double> b) {
        return length(a - b) / length(b);
    };
    const std::string advice = "keep the scene near the lattice's first node";
    v.add(at_most(fmt::format("momentum after 1000 substeps, {}: relative change", scalar),
                  relative_error(after.momentum, before.momentum), bound, "", advice));
    v.add(at_most(fmt::format("spin after 1000 substeps, {}: relative change", scalar),
                  relative_error(after.spin, before.spin), bound, "", advice));
}

}  // namespace

void momentum_part(Verification& v)
{
    const Setup s = flying_ball();
    conserved(v, s, *v.solver(s), v.device.kind == DeviceKind::cpu_double ? "double" : "float",
              v.device.kind == DeviceKind::cpu_double ? 1e-13 : 2e-6);
    if (v.device.kind != DeviceKind::cpu_double) conserved(v, s, *v.reference(s), "double", 1e-13);
}

}  // namespace knead
