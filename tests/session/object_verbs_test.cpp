// Copy, rescale and partition of clay as functions of particles: what is kept exactly, and what a
// simulation does with the result.
#include "host/session/object_verbs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "cuda/contact/cut.h"
#include "cuda/math/rotation.h"
#include "cuda/mpm/material.h"
#include "host/scene/names.h"
#include "host/scene/scene.h"
#include "host/solver/audit.h"
#include "tests/document/random.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

constexpr double cell_edge = 0.02;

// E = 1 MPa, nu = 0.3
Material<double> law(Elasticity elasticity, Plasticity plasticity)
{
    Material<double> m{};
    m.elasticity = elasticity, m.plasticity = plasticity;
    m.density = 1000, m.mu = 1e6 / 2.6, m.lambda = 0.3e6 / (1.3 * 0.4), m.bulk = 1e6;
    m.yield = 5e4, m.friction = 0.6, m.compress = 0.025, m.stretch = 0.0075, m.snow = 10;
    m.viscosity = 100, m.exponent = 7;
    return m;
}

Vec3<double> any(Random& r, double size)
{
    return {r.in(-size, size), r.in(-size, size), r.in(-size, size)};
}

// A box of moving, strained clay with three labels, `side` particles along each edge.
PartClay random_clay(Random& r, const Material<double>& law, int side = 16, double per_cell = 8)
{
    PartClay clay{law, {}};
    const double spacing = cell_edge / std::cbrt(per_cell);
    clay.material.volume = spacing * spacing * spacing;
    clay.material.mass = clay.material.density * clay.material.volume;
    for (int k = 0; k < side; ++k)
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                Particle<double> p{};
                p.x = Vec3<double>{0.3, 0.5, 0.7} +
                      spacing * (Vec3<double>{double(i), double(j), double(k)} + any(r, 0.2));
                p.v = Vec3<double>{1, -2, 0.5} + any(r, 0.3);
                p.C = {any(r, 5), any(r, 5), any(r, 5)};
                p.e = {r.in(-0.1, 0.1),   r.in(-0.1, 0.1),   r.in(-0.1, 0.1),
                       r.in(-0.03, 0.03), r.in(-0.03, 0.03), r.in(-0.03, 0.03)};
                if (law.plasticity == Plasticity::fluid) p.e = isotropic(p.e.xx);
                p.k = r.in(0, 0.02);
                p.sides = i < side / 2 ? uncut : j < side / 2 ? above : below;
                clay.particles.push_back(p);
            }
    return clay;
}

Audit audit_of(const PartClay& clay) { return audit(clay.particles, {clay.material}, cell_edge); }

Sym3<double> stress_sum(const PartClay& clay)
{
    Sym3<double> sum{};
    for (Particle<double> p : clay.particles) {
        p.C = {};
        sum = sum + clay.material.volume * kirchhoff_stress(p, clay.material);
    }
    return sum;
}
double size_of(const Sym3<double>& a) { return std::sqrt(norm_squared(a)); }

// As scaled(), without resampling.
PartClay only_scaled(PartClay clay, Vec3<double> centre, double factor)
{
    for (Particle<double>& p : clay.particles)
        p.x = centre + factor * (p.x - centre), p.C = (1 / factor) * p.C;
    const double cube = factor * factor * factor;
    clay.material.mass *= cube, clay.material.volume *= cube;
    return clay;
}

constexpr double factors[] = {0.1, 0.3, 0.5, 0.7, 0.79, 1.25, 1.6, 2, 3, 5};

TEST(ObjectVerbs, ScaledClayKeepsMassMomentumAndStress)
{
    Random r(61);
    for (const auto& [elasticity_name, elasticity] : elasticities)
        for (const auto& [plasticity_name, plasticity] : plasticities) {
            if (!go_together(elasticity, plasticity)) continue;
            const PartClay clay = random_clay(r, law(elasticity, plasticity), 12);
            const Vec3<double> centre = centre_of_mass({clay});
            for (const double factor : factors) {
                SCOPED_TRACE(testing::Message()
                             << factor << " " << elasticity_name << " " << plasticity_name);
                const PartClay before = only_scaled(clay, centre, factor);
                const PartClay after = scaled(clay, centre, factor, cell_edge);
                const Audit was = audit_of(before), is = audit_of(after);
                EXPECT_NEAR(is.mass / was.mass, 1, 1e-12);
                EXPECT_NEAR(is.mass / (factor * factor * factor * audit_of(clay).mass), 1, 1e-12);
                EXPECT_NEAR(after.material.volume * double(after.particles.size()) /
                                (before.material.volume * double(before.particles.size())),
                            1, 1e-12);
                EXPECT_NEAR(after.material.mass, after.material.density * after.material.volume,
                            1e-12 * after.material.mass);
                const double per_cell = cell_edge * cell_edge * cell_edge / after.material.volume;
                EXPECT_GE(per_cell, fewest_per_cell * 0.95);
                EXPECT_LE(per_cell, most_per_cell * 1.05);
                EXPECT_LT(length(is.momentum - was.momentum), 1e-9 * length(was.momentum));
                EXPECT_LT(length(is.spin - was.spin), 1e-9 * length(was.spin));
                EXPECT_LT(length(centre_of_mass({after}) - centre), 1e-10);
                const Sym3<double> stress = stress_sum(before);
                EXPECT_LT(size_of(stress_sum(after) + -1.0 * stress), 1e-5 * size_of(stress));
            }
        }
}

// Where all groups are of the same size the sum of V tau is kept.
TEST(ObjectVerbs, EqualGroupsKeepTheSumOfStress)
{
    Random r(62);
    for (const auto& [elasticity_name, elasticity] : elasticities)
        for (const auto& [plasticity_name, plasticity] : plasticities) {
            if (!go_together(elasticity, plasticity)) continue;
            PartClay clay = random_clay(r, law(elasticity, plasticity), 16);
            for (int times = 1; times <= 6; ++times) {
                const PartClay after = coarsened(clay, times, cell_edge);
                ASSERT_EQ(after.particles.size() << times, clay.particles.size());
                const Sym3<double> stress = stress_sum(clay);
                EXPECT_LT(size_of(stress_sum(after) + -1.0 * stress), 1e-5 * size_of(stress))
                    << times << " " << elasticity_name << " " << plasticity_name;
            }
        }
}

TEST(ObjectVerbs, ClayAtRestStaysAtRestAndLabelsStayApart)
{
    Random r(63);
    PartClay clay = random_clay(r, law(Elasticity::neo_hookean, Plasticity::von_mises));
    for (Particle<double>& p : clay.particles) p.v = {}, p.C = {};
    for (const double factor : factors) {
        const PartClay after = scaled(clay, {0.5, 0.5, 0.5}, factor, cell_edge);
        std::map<std::uint32_t, double> share;
        for (const Particle<double>& p : after.particles) {
            ASSERT_TRUE(p.v.x == 0 && p.v.y == 0 && p.v.z == 0);
            ASSERT_EQ(length(p.C.a) + length(p.C.b) + length(p.C.c), 0);
            share[p.label()] += 1 / double(after.particles.size());
        }
        EXPECT_NEAR(share[uncut], 0.5, 0.01);
        EXPECT_NEAR(share[above], 0.25, 0.01);
        EXPECT_NEAR(share[below], 0.25, 0.01);
    }
}

TEST(ObjectVerbs, FactorOneWithinTheRangeChangesNothing)
{
    Random r(64);
    const PartClay clay = random_clay(r, law(Elasticity::hencky, Plasticity::none), 4);
    const PartClay after = scaled(clay, {0.1, 0.2, 0.3}, 1, cell_edge);
    EXPECT_EQ(after.particles.size(), clay.particles.size());
    EXPECT_EQ(after.material, clay.material);
    for (const double per_cell : {0.001, 0.5, 1.0, 2.0, 3.9, 4.0, 8.0, 16.0, 17.0, 64.0, 5000.0}) {
        const double is = std::ldexp(per_cell, doublings(per_cell));
        EXPECT_TRUE(is >= 4 && is <= 16) << per_cell;
        EXPECT_EQ(doublings(per_cell) == 0, per_cell >= 4 && per_cell <= 16) << per_cell;
    }
}

TEST(ObjectVerbs, AStrainIsFoundFromItsStress)
{
    Random r(65);
    for (const auto& [elasticity_name, elasticity] : elasticities)
        for (const auto& [plasticity_name, plasticity] : plasticities) {
            if (!go_together(elasticity, plasticity)) continue;
            const Material<double> m = law(elasticity, plasticity);
            for (int i = 0; i < 200; ++i) {
                Particle<double> p{};
                const Mat3<double> axes = rotation(random_rotation(r));
                // Fixed corotated stress falls below half a length, others do not.
                const double size = elasticity == Elasticity::fixed_corotated ? 0.15 : 0.6;
                const Vec3<double> eps = any(r, size);
                p.e = composed(
                    axes, {std::expm1(2 * eps.x), std::expm1(2 * eps.y), std::expm1(2 * eps.z)});
                if (plasticity == Plasticity::fluid) p.e = isotropic(r.in(-0.3, 0.3));
                p.k = r.in(-0.05, 0.05);
                const Sym3<double> e = strain_of(kirchhoff_stress(p, m), m, p.k, {});
                ASSERT_LT(size_of(e + -1.0 * p.e), 1e-8)
                    << elasticity_name << " " << plasticity_name << " " << i;
            }
        }
}

TEST(ObjectVerbs, TheNearestPointIsTheNearest)
{
    Random r(66);
    std::vector<Vec3<double>> points;
    for (int i = 0; i < 500; ++i)
        points.push_back({double(r.below(12)), double(r.below(12)), r.in(0, 12)});
    const NearestPoint nearest(points);
    for (int i = 0; i < 500; ++i) {
        const Vec3<double> x{r.in(-3, 15), double(r.below(15)), r.in(-3, 15)};
        double least = 1e30;
        for (const Vec3<double>& p : points) least = std::min(least, length(p - x));
        EXPECT_EQ(nearest(x).distance, least);
        EXPECT_EQ(length(points[std::size_t(nearest(x).index)] - x), least);
    }
}

Scene scene_with(const std::string& objects, const std::string& rest = "")
{
    Scene scene = parse_scene(R"({"schema": "knead.scene/1", "frame_rate": 60,
        "domain": {"edge": 0.8, "cells": 40}, "gravity": [0, 0, 0], )" +
                                  rest + R"("objects": [)" + objects + "]}",
                              "scenes/verbs.json");
    build(scene, std::size_t(1) << 30);
    scene.setup.threads = 1;
    return scene;
}
PartClay clay_in(const Scene& scene) { return {scene.setup.materials[0], scene.setup.particles}; }
double farthest(const PartClay& of, const PartClay& from)
{
    std::vector<Vec3<double>> there;
    for (const Particle<double>& p : from.particles) there.push_back(p.x);
    const NearestPoint nearest(std::move(there));
    double most = 0;
    for (const Particle<double>& p : of.particles) most = std::max(most, nearest(p.x).distance);
    return most;
}

TEST(ObjectVerbs, TwiceAndHalfTheSizeGiveTheShapeAgain)
{
    const Scene scene = scene_with(R"({"centre": [0.4, 0.4, 0.4], "diameter": 0.2})");
    const PartClay clay = clay_in(scene);
    const Vec3<double> centre = centre_of_mass({clay});
    for (const double factor : {2.0, 0.5, 1.5}) {
        const PartClay other = scaled(clay, centre, factor, cell_edge);
        const PartClay back = scaled(other, centre, 1 / factor, cell_edge);
        // Half a cell at the smaller size.
        const double resolved = 0.5 * cell_edge / std::min(factor, 1.0);
        EXPECT_LT(farthest(back, clay), resolved) << factor;
        EXPECT_LT(farthest(clay, back), resolved) << factor;
        EXPECT_NEAR(audit_of(back).mass / audit_of(clay).mass, 1, 1e-12);
    }
}

// Clay with the stresses of an impact, scaled when it has come to rest, moves by no more than a
// twentieth of a cell in a second.
TEST(ObjectVerbs, ScaledClayIsAtRest)
{
    Scene scene = scene_with(
        R"({"centre": [0.4, 0.12, 0.4], "diameter": 0.16, "velocity": [0, -1.5, 0],
            "material": "clay"})");
    const auto solver = cpu_solver(scene.setup);
    const auto run = [&](double seconds) {
        const Motion none;
        for (int i = 0; i < int(60 * seconds); ++i) solver->advance(none, 1.0 / 60);
    };
    const auto clay = [&](int number) {
        PartClay found{solver->config().materials.at(std::size_t(number)), {}};
        for (const Particle<double>& p : solver->held(*solver->snapshot()).particles)
            if (p.object == number) found.particles.push_back(p);
        return found;
    };
    run(0.1);
    int number = 0;
    solver->set_gravity({0, 0, 0});
    run(sanitized ? 0.2 : 2);
    PartClay at_rest = clay(number);
    Vec3<double> drift = audit_of(at_rest).momentum;
    drift = (1 / audit_of(at_rest).mass) * drift;
    for (Particle<double>& p : at_rest.particles) p.v = {}, p.C = {};
    const Vec3<double> middle{0.4, 0.4, 0.4};
    for (const double factor : {2.0, 0.5, 1.0}) {
        PartClay other = scaled(at_rest, centre_of_mass({at_rest}), factor, cell_edge);
        std::vector<PartClay> moved{other};
        displace(moved, middle - centre_of_mass(moved));
        solver->remove(number);
        number = solver->add(moved[0].material, moved[0].particles);
        run(sanitized ? 0.1 : 1);
        const PartClay later = clay(number);
        double most = 0;
        for (std::size_t i = 0; i < later.particles.size(); ++i)
            most = std::max(most, length(later.particles[i].x -
                                         cast<double>(cast<float>(moved[0].particles[i].x))));
        EXPECT_LT(most, 0.05 * cell_edge) << factor;
    }
}

// Boxes of clay along x, each `size` particles at 8 per cell, `gap` cells apart.
PartClay boxes(const std::vector<Int3>& sizes, double gap)
{
    PartClay clay{law(Elasticity::neo_hookean, Plasticity::none), {}};
    clay.material.volume = cell_edge * cell_edge * cell_edge / 8;
    double from = 0.1;
    for (const Int3 n : sizes) {
        for (int k = 0; k < n.z; ++k)
            for (int j = 0; j < n.y; ++j)
                for (int i = 0; i < n.x; ++i) {
                    Particle<double> p{};
                    p.x = {from + cell_edge / 2 * (i + 0.5), 0.2 + cell_edge / 2 * (j + 0.5),
                           0.2 + cell_edge / 2 * (k + 0.5)};
                    clay.particles.push_back(p);
                }
        from += cell_edge / 2 * n.x + gap * cell_edge;
    }
    return clay;
}

TEST(ObjectVerbs, PiecesAreConnectedCellsWithoutOppositeLabels)
{
    const Scene scene = scene_with("");
    const Lattice<double>& lattice = scene.setup.lattice;
    const auto counts = [&](const std::vector<PartClay>& parts) {
        const Pieces found = connected_pieces(parts, lattice);
        std::vector<int> sizes(std::size_t(found.count), 0);
        for (const int one : found.of_particle) ++sizes[std::size_t(one)];
        return sizes;
    };
    EXPECT_EQ(counts({boxes({{8, 8, 8}}, 0)}), (std::vector<int>{512}));
    EXPECT_EQ(counts({boxes({{8, 8, 8}, {10, 8, 8}}, 2.1)}), (std::vector<int>{640, 512}));
    EXPECT_EQ(counts({boxes({{8, 8, 8}, {10, 8, 8}}, 0.5)}), (std::vector<int>{1152}));
    // A crumb of 8 belongs to the nearer piece; the clay of two materials is one piece.
    EXPECT_EQ(counts({boxes({{8, 8, 8}, {2, 2, 2}, {10, 8, 8}}, 2.1)}).size(), 2u);
    EXPECT_EQ(counts({boxes({{8, 8, 8}}, 0), boxes({{8, 8, 8}}, 0)}), (std::vector<int>{1024}));
    PartClay cut = boxes({{16, 8, 8}}, 0);
    for (Particle<double>& p : cut.particles) p.sides = p.x.x < 0.1 + 4 * cell_edge ? above : below;
    EXPECT_EQ(counts({cut}), (std::vector<int>{512, 512}));
    EXPECT_EQ(counts({boxes({{2, 2, 2}, {2, 2, 2}}, 3)}), (std::vector<int>{16}));
}

}  // namespace
}  // namespace knead
