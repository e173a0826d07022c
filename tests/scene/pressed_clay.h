// Clay at rest, and pressed by spheres that come, press and go: a ball between two large ones, a
// slab under one of the size of a fingertip.
#pragma once
#include "host/scene/scene.h"
#include "tests/solver/samples.h"

namespace knead {

// A scene of one object of clay on cells^3 cells of 1 m, built.
inline Scene clay_scene(int cells, ShapeKind shape, Vec3<double> centre, Vec3<double> size,
                        double per_cell = 8, unsigned seed = 1)
{
    Scene scene;
    const double dx = 1.0 / cells;
    scene.setup.lattice = {{cells, cells, cells}, dx};
    scene.setup.walls = walls_inside(scene.setup.lattice, cells / 8, ContactMode::sticky, 0.4);
    scene.seed = seed;
    scene.surface.lattice = {{2 * cells, 2 * cells, 2 * cells}, float(dx / 2)};
    Object o;
    o.shape = shape, o.centre = centre, o.size = size, o.per_cell = per_cell;
    Material<double>& m = o.material;
    m.elasticity = Elasticity::neo_hookean, m.plasticity = Plasticity::von_mises;
    m.density = 1000;
    m.mu = 1e6 / 2.6, m.lambda = 0.3e6 / (1.3 * 0.4), m.bulk = 1e6, m.exponent = 1;
    m.yield = 1e5, m.yield_floor = 1e3;
    scene.objects = {o};
    build(scene, std::size_t(1) << 32);
    return scene;
}

// A sphere from where it does not touch the clay to where it presses most.
struct Presser {
    Vec3<double> from, to;  // [m]
    double radius;          // [m]
};

// The ball pressed to three quarters of its width by spheres larger than it. A stratum's share is
// the place on the lattice, so that two balls differ in nothing else.
struct Pressing {
    Scene scene;
    std::vector<Presser> by;
};
inline Pressing squeeze(int cells, double share = 0, unsigned seed = 1)
{
    const Vec3<double> middle =
        Vec3<double>{0.5, 0.5, 0.5} + share / (2 * cells) * Vec3<double>{0.74, 0.42, 0.22};
    Pressing p{clay_scene(cells, ShapeKind::sphere, middle, {0.5, 0.5, 0.5}, 8, seed), {}};
    for (const double side : {-1.0, 1.0}) {
        const Vec3<double> out{side, 0, 0};
        p.by.push_back({middle + 0.61 * out, middle + 0.54 * out, 0.35});
    }
    return p;
}

// A slab of 14 x 7 x 14 twenty-fourths of a metre, into which a sphere of 2.5 sinks by 2.
inline Pressing fingertip(int cells, unsigned seed = 1)
{
    constexpr double u = 1.0 / 24;
    const double floor = 3.0 * u, top = floor + 7 * u;
    Pressing p{clay_scene(cells, ShapeKind::box, {0.5, floor + 3.5 * u, 0.5},
                          {14 * u, 7 * u, 14 * u}, 8, seed),
               {}};
    p.scene.setup.gravity = {0, -9.81, 0};
    const auto above = [&](double height) {
        return Vec3<double>{0.5 + 0.2 * u, top + height, 0.5 + 0.1 * u};
    };
    p.by.push_back({above(2.8 * u), above(0.5 * u), 2.5 * u});
    return p;
}

// What is left when the spheres have come and gone in 40 frames, with minimum jerk, and the clay
// has rested for eight more.
inline std::vector<Particle<double>> after(const Pressing& p)
{
    Setup setup = p.scene.setup;
    setup.tools = {{ContactMode::separate, 0, false, true}};
    for (int k = 0; k < int(p.by.size()); ++k) {
        setup.rig.spheres.push_back(
            {{k, k, k, k}, {1, 0, 0, 0}, {}, float(p.by[std::size_t(k)].radius)});
        setup.rig.primitives.push_back({1, {k, k, k}, 0});
    }
    const auto solver = cpu_solver(setup);
    const auto joints = [&](int frame) {
        const double t = std::max(0.0, 1 - std::abs(frame - 20) / 20.0);
        const double way = t * t * t * (10 - 15 * t + 6 * t * t);
        std::vector<Joint<double>> all;
        for (const Presser& s : p.by) all.push_back({{1, 0, 0, 0}, s.from + way * (s.to - s.from)});
        return all;
    };
    for (int frame = 0; frame < 48; ++frame)
        solver->advance({joints(frame), joints(frame + 1), {}, {}}, 1.0 / 90);
    return solver->particles();
}

}  // namespace knead
