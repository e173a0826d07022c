#include "host/session/object_verbs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <unordered_map>

#include "cuda/contact/cut.h"
#include "cuda/mpm/material.h"
#include "host/solver/pieces.h"

namespace knead {
namespace {

// Sums about a point of particles of equal mass, per mass of one. The affine velocity turns with a
// second moment of dx^2 / 4 along each axis (1).
struct Motions {
    Vec3<double> centre{}, velocity{}, spin{};  // means, but for `spin`: a sum about the centre
};
Vec3<double> turning(const Mat3<double>& C)
{
    return {C.b.z - C.c.y, C.c.x - C.a.z, C.a.y - C.b.x};
}
Motions motions_of(const std::vector<Particle<double>>& particles, double dx)
{
    Motions m;
    const double share = 1 / double(particles.size());
    for (const Particle<double>& p : particles)
        m.centre = m.centre + share * p.x, m.velocity = m.velocity + share * p.v;
    for (const Particle<double>& p : particles)
        m.spin = m.spin + cross(p.x - m.centre, p.v) + (dx * dx / 4) * turning(p.C);
    return m;
}

// Gives resampled clay the centre of mass, momentum and angular momentum that it had: a shift and a
// rigid motion. `before`: of particles of which each weighed `share` of one now.
void restore_motions(std::vector<Particle<double>>& particles, const Motions& before, double share,
                     double dx)
{
    const Motions now = motions_of(particles, dx);
    const Vec3<double> shift = before.centre - now.centre, v = before.velocity - now.velocity;
    const Vec3<double> missing = share * before.spin - now.spin;
    Sym3<double> inertia = isotropic(double(particles.size()) * dx * dx / 2);
    for (Particle<double>& p : particles) {
        p.x = p.x + shift;
        const Vec3<double> r = p.x - before.centre;
        inertia = inertia + Sym3<double>{r.y * r.y + r.z * r.z,
                                         r.x * r.x + r.z * r.z,
                                         r.x * r.x + r.y * r.y,
                                         -r.x * r.y,
                                         -r.x * r.z,
                                         -r.y * r.z};
    }
    const Eigen<double> axes = eigen(inertia);
    const Vec3<double> along = transpose(axes.axes) * missing;
    const Vec3<double> w = axes.axes * Vec3<double>{along.x / axes.value.x, along.y / axes.value.y,
                                                    along.z / axes.value.z};
    const Mat3<double> W{{0, w.z, -w.y}, {-w.z, 0, w.x}, {w.y, -w.x, 0}};
    for (Particle<double>& p : particles)
        p.v = p.v + v + cross(w, p.x - before.centre), p.C = p.C + W;
}

double& component(Vec3<double>& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
double component(const Vec3<double>& v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
Vec3<double>& column(Mat3<double>& A, int axis) { return axis == 0 ? A.a : axis == 1 ? A.b : A.c; }

// Divides the particles order[from, to) at medians into `groups` groups of nearly equal size, and
// calls visit(group) for each.
template <class Visit>
void each_group(const std::vector<Particle<double>>& q, std::vector<int>& order, std::size_t from,
                std::size_t to, std::size_t groups, const Visit& visit)
{
    if (groups <= 1) {
        std::sort(order.begin() + std::ptrdiff_t(from), order.begin() + std::ptrdiff_t(to));
        return visit(std::span<const int>(order).subspan(from, to - from));
    }
    Box3<double> box = empty_box<double>();
    for (std::size_t i = from; i < to; ++i) {
        const Vec3<double> x = q[std::size_t(order[i])].x;
        box = {lesser(box.low, x), greater(box.high, x)};
    }
    const Vec3<double> size = box.high - box.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t first = groups / 2, middle = from + (to - from) * first / groups;
    std::nth_element(order.begin() + std::ptrdiff_t(from), order.begin() + std::ptrdiff_t(middle),
                     order.begin() + std::ptrdiff_t(to), [&](int a, int b) {
                         const double at = component(q[std::size_t(a)].x, axis),
                                      other = component(q[std::size_t(b)].x, axis);
                         return at < other || (at == other && a < b);
                     });
    each_group(q, order, from, middle, first, visit);
    each_group(q, order, middle, to, groups - first, visit);
}

// The mean of a group's particles, with the mean of their strains, and that of their stresses.
struct Merged {
    Particle<double> particle{};
    Sym3<double> stress{};  // [Pa]
};
Merged merged(const std::vector<Particle<double>>& q, std::span<const int> group,
              const Material<double>& m, double dx)
{
    const double share = 1 / double(group.size());
    Merged made;
    Particle<double>& one = made.particle;
    for (const int i : group) {
        const Particle<double>& p = q[std::size_t(i)];
        one.x = one.x + share * p.x, one.v = one.v + share * p.v;
        one.e = one.e + share * p.e, one.k += share * p.k;
        Particle<double> still = p;
        still.C = {};  // without the stress of a liquid's viscosity
        made.stress = made.stress + share * kirchhoff_stress(still, m);
    }
    Mat3<double> B{};
    for (const int i : group) {
        const Particle<double>& p = q[std::size_t(i)];
        B = B + share * (outer(p.v - one.v, p.x - one.x) + (dx * dx / 4) * p.C);
    }
    one.C = (4 / (dx * dx)) * B;
    one.object = q[std::size_t(group[0])].object;
    one.sides = q[std::size_t(group[0])].label();
    return made;
}

}  // namespace

Box3<double> box_of(const std::vector<PartClay>& parts)
{
    Box3<double> box = empty_box<double>();
    for (const PartClay& part : parts)
        for (const Particle<double>& p : part.particles)
            box = {lesser(box.low, p.x), greater(box.high, p.x)};
    return box;
}

Vec3<double> centre_of_mass(const std::vector<PartClay>& parts)
{
    Vec3<double> sum{};
    double mass = 0;
    for (const PartClay& part : parts)
        for (const Particle<double>& p : part.particles)
            sum = sum + part.material.mass * p.x, mass += part.material.mass;
    return mass > 0 ? (1 / mass) * sum : sum;
}

void displace(std::vector<PartClay>& parts, Vec3<double> by)
{
    for (PartClay& part : parts)
        for (Particle<double>& p : part.particles) p.x = p.x + by;
}

int doublings(double per_cell)
{
    if (per_cell >= fewest_per_cell && per_cell <= most_per_cell) return 0;
    return int(std::lround(std::log2(8 / per_cell)));
}

PartClay scaled(PartClay clay, Vec3<double> centre, double factor, double dx)
{
    for (Particle<double>& p : clay.particles) {
        p.x = centre + factor * (p.x - centre);
        p.C = (1 / factor) * p.C;
        p.hold(false);
    }
    Material<double>& m = clay.material;
    const int times = doublings(per_cell_of(m, factor, dx));
    m.volume *= factor * factor * factor, m.mass *= factor * factor * factor;
    if (times > 0) return refined(std::move(clay), times, dx);
    if (times < 0) return coarsened(std::move(clay), -times, dx);
    return clay;
}

PartClay refined(PartClay clay, int times, double dx)
{
    if (clay.particles.empty()) return clay;
    const Motions before = motions_of(clay.particles, dx);
    const double spacing = std::cbrt(clay.material.volume);
    for (int n = 0; n < times; ++n) {
        const int axis = n % 3;
        const double offset = spacing / double(4 << (n / 3));
        // Of the second moment of the particle, what its halves do not have as their distance.
        const double rest = std::max(0.0, 1 - 4 * offset * offset / (dx * dx));
        std::vector<Particle<double>> halves;
        halves.reserve(2 * clay.particles.size());
        for (const Particle<double>& p : clay.particles)
            for (const double way : {-offset, offset}) {
                Particle<double> half = p;
                component(half.x, axis) += way;
                half.v = half.v + way * column(half.C, axis);
                column(half.C, axis) = rest * column(half.C, axis);
                halves.push_back(half);
            }
        clay.particles = std::move(halves);
    }
    const double share = std::ldexp(1.0, times);
    clay.material.volume /= share, clay.material.mass /= share;
    restore_motions(clay.particles, before, share, dx);
    return clay;
}

PartClay coarsened(PartClay clay, int times, double dx)
{
    const std::size_t count = clay.particles.size(), group = std::size_t(1) << times;
    if (count == 0) return clay;
    const Motions before = motions_of(clay.particles, dx);
    std::vector<Merged> all;
    all.reserve(count / group + 4);
    Sym3<double> missing{};  // of the mean stress: groups of one particle more weigh no more
    for (const std::uint32_t label : {uncut, above, below}) {
        std::vector<int> order;
        for (std::size_t i = 0; i < count; ++i)
            if (clay.particles[i].label() == label) order.push_back(int(i));
        if (order.empty()) continue;
        const std::size_t groups = std::max<std::size_t>(1, (order.size() + group / 2) / group);
        each_group(clay.particles, order, 0, order.size(), groups, [&](std::span<const int> of) {
            all.push_back(merged(clay.particles, of, clay.material, dx));
            missing = missing + (double(of.size()) / double(count)) * all.back().stress;
        });
    }
    const double share = double(all.size()) / double(count);
    for (const Merged& one : all) missing = missing + (-1 / double(all.size())) * one.stress;
    clay.particles.clear();
    for (Merged& one : all) {
        Particle<double>& p = one.particle;
        p.e = strain_of(one.stress + missing, clay.material, p.k, p.e);
        clay.particles.push_back(p);
    }
    clay.material.volume /= share, clay.material.mass /= share;
    restore_motions(clay.particles, before, share, dx);
    return clay;
}

namespace {

// Trace of a neo-Hookean solid's strain e = d + I trace / 3 with the mean stress `mean`: a root of
// a rising concave function.
double neo_hookean_trace(Vec3<double> d, double mu, double lambda, double mean)
{
    // Positive definite at the start, and to the left of the root or one step from it.
    double t = 3 * (1e-3 - 1 - std::min({d.x, d.y, d.z}));
    t = std::max(t, std::min(0.0, mean / (mu / 3 + lambda / 2)));
    for (int n = 0; n < 60; ++n) {
        double f = mu * t / 3 - mean, slope = mu / 3;
        for (const double a : {d.x, d.y, d.z})
            f += 0.5 * lambda * std::log1p(a + t / 3), slope += lambda / 6 / (1 + a + t / 3);
        const double step = f / slope, least = 3 * (1e-6 - 1 - std::min({d.x, d.y, d.z}));
        const double next = std::max(t - step, 0.5 * (t + least));
        if (std::abs(next - t) < 1e-14 * (1 + std::abs(t))) return next;
        t = next;
    }
    return t;
}

// Principal stretch s above 1/2 of a fixed corotated solid: 2 mu s (s - 1) = stress.
double corotated_stretch(double stress, double mu)
{
    return 0.5 * (1 + std::sqrt(std::max(0.0, 1 + 2 * stress / mu)));
}
// Its pressure term p = lambda J (J - 1), where the stretches follow from the stress less p.
double corotated_pressure(Vec3<double> stress, double mu, double lambda)
{
    const auto excess = [&](double p) {
        const double J = corotated_stretch(stress.x - p, mu) * corotated_stretch(stress.y - p, mu) *
                         corotated_stretch(stress.z - p, mu);
        return p - lambda * J * (J - 1);
    };
    const double size =
        1e-3 * lambda + std::abs(stress.x) + std::abs(stress.y) + std::abs(stress.z);
    double low = -size, high = size;
    for (int n = 0; n < 60 && excess(low) > 0; ++n) low *= 2;
    for (int n = 0; n < 60 && excess(high) < 0; ++n) high *= 2;
    for (int n = 0; n < 100; ++n) {
        const double middle = 0.5 * (low + high);
        (excess(middle) > 0 ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

// Of a liquid: its strain is a change of volume.
Sym3<double> liquid_strain_of(double stress, const Material<double>& m, const Sym3<double>& guess)
{
    double log_J = log_volume(determinant_excess(guess));
    for (int n = 0; n < 30; ++n) {
        const LiquidStrain<double> s = liquid_strain(m, log_J);
        const double slope = liquid_slope(m, s.log_J),
                     tau = liquid_stress(m, s.log_J) + slope * min(s.beyond, 0.0);
        if (!(slope > 0)) break;
        const double step = clamp((tau - stress) / slope, -0.1, 0.1);
        log_J -= step;
        if (std::abs(step) < 1e-15) break;
    }
    return isotropic(std::expm1(2 * log_J / 3));
}

}  // namespace

Sym3<double> strain_of(const Sym3<double>& stress, const Material<double>& m, double k,
                       const Sym3<double>& guess)
{
    if (m.plasticity == Plasticity::fluid) return liquid_strain_of(trace(stress) / 3, m, guess);
    const double h = snow_hardening(m, k), mu = h * m.mu, lambda = h * m.lambda;
    if (!(mu > 0)) return guess;
    const Eigen<double> of = eigen(stress);
    const Vec3<double> t = of.value;
    const double mean = (t.x + t.y + t.z) / 3;
    Vec3<double> e;
    if (m.elasticity == Elasticity::neo_hookean) {
        const Vec3<double> d{(t.x - mean) / mu, (t.y - mean) / mu, (t.z - mean) / mu};
        const double third = neo_hookean_trace(d, mu, lambda, mean) / 3;
        e = {d.x + third, d.y + third, d.z + third};
    } else if (m.elasticity == Elasticity::hencky) {
        const double p = lambda * 3 * mean / (3 * lambda + 2 * mu);
        const auto each = [&](double tau) { return std::expm1((tau - p) / mu); };
        e = {each(t.x), each(t.y), each(t.z)};
    } else {
        const double p = corotated_pressure(t, mu, lambda);
        const auto each = [&](double tau) {
            const double s = corotated_stretch(tau - p, mu);
            return (s - 1) * (s + 1);
        };
        e = {each(t.x), each(t.y), each(t.z)};
    }
    if (!std::isfinite(e.x + e.y + e.z) || std::min({e.x, e.y, e.z}) <= -1) return guess;
    return composed(of.axes, e);
}

NearestPoint::NearestPoint(std::vector<Vec3<double>> of)
    : points(std::move(of)), order(points.size())
{
    std::iota(order.begin(), order.end(), 0);
    arrange(0, order.size(), 0);
}

void NearestPoint::arrange(std::size_t from, std::size_t to, int axis)
{
    if (to - from < 2) return;
    const std::size_t middle = from + (to - from) / 2;
    std::nth_element(order.begin() + std::ptrdiff_t(from), order.begin() + std::ptrdiff_t(middle),
                     order.begin() + std::ptrdiff_t(to), [&](int a, int b) {
                         const double at = component(points[std::size_t(a)], axis),
                                      other = component(points[std::size_t(b)], axis);
                         return at < other || (at == other && a < b);
                     });
    arrange(from, middle, (axis + 1) % 3);
    arrange(middle + 1, to, (axis + 1) % 3);
}

NearestPoint::Found NearestPoint::operator()(Vec3<double> x) const
{
    Found best{-1, std::numeric_limits<double>::infinity()};
    search(0, order.size(), 0, x, best);
    return best;
}

void NearestPoint::search(std::size_t from, std::size_t to, int axis, Vec3<double> x,
                          Found& best) const
{
    if (from == to) return;
    const std::size_t middle = from + (to - from) / 2;
    const int index = order[middle];
    const Vec3<double> at = points[std::size_t(index)];
    const double distance = length(x - at);
    if (distance < best.distance || (distance == best.distance && index < best.index))
        best = {index, distance};
    const double beyond = component(x, axis) - component(at, axis);
    const auto low = [&] { search(from, middle, (axis + 1) % 3, x, best); };
    const auto high = [&] { search(middle + 1, to, (axis + 1) % 3, x, best); };
    beyond < 0 ? low() : high();
    if (std::abs(beyond) <= best.distance) beyond < 0 ? high() : low();
}

namespace {

// Of each particle of all parts, whether more than a quarter of its cell is filled.
std::vector<char> in_filled_cells(const std::vector<PartClay>& parts,
                                  const Lattice<double>& lattice)
{
    std::unordered_map<std::int64_t, double> filled;
    const auto key = [&](Vec3<double> x) {
        const Int3 c = lattice.cell_of(x);
        return (std::int64_t(c.z) * lattice.size.y + c.y) * lattice.size.x + c.x;
    };
    const double cell = lattice.dx * lattice.dx * lattice.dx;
    for (const PartClay& part : parts)
        for (const Particle<double>& p : part.particles)
            filled[key(p.x)] += part.material.volume / cell;
    std::vector<char> dense;
    for (const PartClay& part : parts)
        for (const Particle<double>& p : part.particles)
            dense.push_back(filled.at(key(p.x)) > 0.25);
    return dense;
}

}  // namespace

Pieces connected_pieces(const std::vector<PartClay>& parts, const Lattice<double>& lattice)
{
    std::vector<Particle<double>> all;
    for (const PartClay& part : parts)
        all.insert(all.end(), part.particles.begin(), part.particles.end());
    for (Particle<double>& p : all) p.hold(false);  // only the label counts
    const std::vector<char> dense = in_filled_cells(parts, lattice);
    std::vector<Particle<double>> body;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (dense[i]) body.push_back(all[i]);
    std::vector<int> piece;
    const int found = pieces(body, lattice, piece);
    std::vector<std::size_t> size(std::size_t(found), 0);
    for (const int one : piece) ++size[std::size_t(one)];
    Pieces result;
    // They are in descending order of size.
    while (result.count < found && size[std::size_t(result.count)] >= fewest_particles_in_part)
        ++result.count;
    if (result.count < 2) {
        result.count = 1, result.of_particle.assign(all.size(), 0);
        return result;
    }
    std::vector<Vec3<double>> places;
    std::vector<int> of_place;
    for (std::size_t i = 0; i < body.size(); ++i)
        if (piece[i] < result.count) places.push_back(body[i].x), of_place.push_back(piece[i]);
    const NearestPoint nearest(std::move(places));
    struct Near {
        int piece = 0;
        double distance = std::numeric_limits<double>::infinity();
    };
    std::vector<Near> of_crumb(static_cast<std::size_t>(found));
    const auto nearest_piece = [&](Vec3<double> x) {
        const NearestPoint::Found at = nearest(x);
        return Near{of_place[std::size_t(at.index)], at.distance};
    };
    for (std::size_t i = 0; i < body.size(); ++i) {
        if (piece[i] < result.count) continue;
        Near& known = of_crumb[std::size_t(piece[i])];
        if (const Near here = nearest_piece(body[i].x); here.distance < known.distance)
            known = here;
    }
    std::size_t next = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!dense[i]) {
            result.of_particle.push_back(nearest_piece(all[i].x).piece);
            continue;
        }
        const int one = piece[next++];
        result.of_particle.push_back(one < result.count ? one : of_crumb[std::size_t(one)].piece);
    }
    return result;
}

}  // namespace knead
