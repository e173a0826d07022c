#include "host/solver/audit.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cmath>

#include "cuda/mpm/material.h"
#include "cuda/mpm/stencil.h"

namespace knead {

static_assert(sizeof(Particle<double>) == 22 * sizeof(double) + 8, "hashed as bytes: no padding");

// k of sand is the log volume gained at the cone's tip; k of snow is the log volume of its packing.
static double plastic_log_volume(const Particle<double>& q, const Material<double>& m)
{
    const bool kept =
        m.plasticity == Plasticity::drucker_prager || m.plasticity == Plasticity::clamp;
    return kept ? q.k : 0;
}

double log_volume_ratio(const Particle<double>& q, const Material<double>& m)
{
    return log_volume(determinant_excess(q.e)) + plastic_log_volume(q, m);
}

double stored_energy(const Particle<double>& q, const Material<double>& m)
{
    const double log_J = log_volume(determinant_excess(q.e));
    if (m.plasticity == Plasticity::fluid) {
        const auto [l, beyond] = liquid_strain(m, log_J);
        const double g = m.exponent;  // minus the integral of p = bulk / g (J^-g - 1) from 1 to J
        const double part = g == 1 ? -l : std::expm1((1 - g) * l) / (g - 1);
        return m.bulk / g * (part + std::expm1(l)) +
               (liquid_stress(m, l) + liquid_slope(m, l) / 2 * beyond) * beyond;
    }
    const double h = snow_hardening(m, q.k), mu = h * m.mu, lambda = h * m.lambda;
    if (m.elasticity == Elasticity::neo_hookean)
        return mu / 2 * (trace(q.e) - 2 * log_J) + lambda / 2 * log_J * log_J;
    const Vec3<double> eps = hencky(eigen(q.e).value);
    if (m.elasticity == Elasticity::hencky) return mu * dot(eps, eps) + lambda / 2 * log_J * log_J;
    const Vec3<double> stretch{std::expm1(eps.x), std::expm1(eps.y), std::expm1(eps.z)};
    const double grown = std::expm1(log_J);
    return mu * dot(stretch, stretch) + lambda / 2 * grown * grown;
}

double affine_energy(const Mat3<double>& C, double mass, double dx)
{
    return mass * dx * dx / 8 * (dot(C.a, C.a) + dot(C.b, C.b) + dot(C.c, C.c));
}

Audit audit(const std::vector<Particle<double>>& particles,
            const std::vector<Material<double>>& materials, double dx,
            const std::vector<Vec3<double>>& velocities)
{
    Audit a;
    std::vector<long> counts(materials.size());
    const double D = dx * dx / 4;  // second moment of the quadratic B-spline [Jiang 2015]
    for (std::size_t i = 0; i < particles.size(); ++i) {
        const Particle<double>& q = particles[i];
        const Vec3<double> v = velocities.empty() ? q.v : velocities[i];
        const Material<double>& m = materials[std::size_t(q.object)];
        ++counts[std::size_t(q.object)];
        const double J = std::exp(log_volume_ratio(q, m)), energy = stored_energy(q, m);
        const double sum =
            dot(q.x, q.x) + dot(q.v, q.v) + dot(v, v) + J + energy + determinant(q.C);
        if (!std::isfinite(sum)) {
            ++a.broken;
            continue;
        }
        a.volume += J * m.volume;
        a.unloaded += std::exp(plastic_log_volume(q, m)) * m.volume;
        a.elastic += energy * m.volume;
        a.kinetic += 0.5 * m.mass * dot(v, v) + affine_energy(q.C, m.mass, dx);
        a.momentum = a.momentum + m.mass * v;
        const Vec3<double> turning{q.C.b.z - q.C.c.y, q.C.c.x - q.C.a.z, q.C.a.y - q.C.b.x};
        a.spin = a.spin + m.mass * (cross(q.x, v) + D * turning);
        a.fastest = std::max(a.fastest, length(v));
    }
    for (std::size_t i = 0; i < counts.size(); ++i) a.mass += double(counts[i]) * materials[i].mass;
    a.hash = XXH64(particles.data(), particles.size() * sizeof(Particle<double>), 0);
    return a;
}

// Scatters the claimed volume of each particle to its nodes (1) and gathers the total at each
// particle.
Crowding crowding(const std::vector<Particle<double>>& particles,
                  const std::vector<Material<double>>& materials, double dx)
{
    const auto known = [](const Particle<double>& q) {
        return std::isfinite(q.x.x + q.x.y + q.x.z + trace(q.e) + q.k);
    };
    const Int3 none{1 << 30, 1 << 30, 1 << 30};
    Int3 low = none, high = {-none.x, -none.y, -none.z};
    for (const Particle<double>& q : particles) {
        if (!known(q)) continue;
        const Int3 base = base_node(q.x, Spacing<double>(dx));
        low = {std::min(low.x, base.x), std::min(low.y, base.y), std::min(low.z, base.z)};
        high = {std::max(high.x, base.x), std::max(high.y, base.y), std::max(high.z, base.z)};
    }
    if (high.x < low.x) return {};
    const Int3 size = high - low + Int3{3, 3, 3};
    std::vector<double> claimed(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    const auto at_nodes = [&](const Particle<double>& q, auto&& visit) {
        const Stencil<double> s = stencil(q.x, Spacing<double>(dx));
        for_each_node(s, dx, [&](Int3 step, double w, Vec3<double>) {
            const Int3 i = s.base - low + step;
            visit(w, claimed[(std::size_t(i.z) * std::size_t(size.y) + std::size_t(i.y)) *
                                 std::size_t(size.x) +
                             std::size_t(i.x)]);
        });
    };
    for (const Particle<double>& q : particles) {
        if (!known(q)) continue;
        const Material<double>& m = materials[std::size_t(q.object)];
        const double share = std::exp(log_volume_ratio(q, m)) * m.volume / (dx * dx * dx);
        at_nodes(q, [&](double w, double& node) { node += w * share; });
    }
    Crowding found;
    for (const Particle<double>& q : particles) {
        if (!known(q)) continue;
        double here = 0;
        at_nodes(q, [&](double w, double node) { here += w * node; });
        found.particles += here > crowded;
        found.most = std::max(found.most, here);
    }
    return found;
}

std::string hexadecimal(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

}  // namespace knead
