// Bodies of splats that are drawn out or torn, and pictures of them by the way their splats follow.
#pragma once
#include <memory>

#include "host/assets/fill.h"
#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/splats/cells.h"
#include "host/splats/coverage.h"
#include "host/splats/deformed.h"
#include "host/splats/generate.h"
#include "host/splats/refill.h"
#include "host/splats/split.h"
#include "host/surface/mesh.h"

namespace knead::kneaded {

constexpr double frame = 1.0 / 90, dx = 1.0 / 64;  // [s], [m]
constexpr Vec3<double> middle{0.5, 0.5, 0.5};

// How splats are drawn.
enum class Follow { total, elastic, rigid };

struct Body {
    Setup setup;
    CarriedSplats splats;
    double spacing = 0;  // of the particles [m]
    std::size_t surface = 0;
    SurfaceOptions look;
};

// Discs on the faces of a box 0.3 x 0.21 x 0.12 m, `gap` [m] apart, in squares of two colours.
inline SplatCloud box_of_splats(double gap)
{
    SplatCloud c;
    const double half[3] = {0.15, 0.105, 0.06};
    const auto add = [&](Vec3<double> x, std::size_t axis) {
        const float s = float(0.75 * gap), t = float(0.4 * gap);
        c.centre.push_back(cast<float>(middle + x));
        c.rotation.push_back({1, 0, 0, 0});
        c.scale.push_back({axis == 0 ? t : s, axis == 1 ? t : s, axis == 2 ? t : s});
        c.opacity.push_back(0.98f);
        const auto square = [](double at) { return int(std::floor(at / 0.03 + 1e-6)); };
        const bool odd = (square(x.x) + square(x.y) + square(x.z)) & 1;
        c.sh.push_back(odd ? Vec3<float>{0.9f, 0.4f, -0.5f} : Vec3<float>{-0.8f, 0.2f, 0.9f});
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        const int m = int(std::ceil(2 * half[u] / gap)), n = int(std::ceil(2 * half[v] / gap));
        for (int k = 0; k < 2 * m * n; ++k) {
            double x[3];
            x[axis] = k % 2 ? half[axis] : -half[axis];
            x[u] = half[u] * (2 * (k / 2 % m + 0.5) / m - 1);
            x[v] = half[v] * (2 * (k / 2 / m + 0.5) / n - 1);
            add({x[0], x[1], x[2]}, axis);
        }
    }
    return c;
}

// Soft clay with such splats, filled.
inline Body body_of(double gap = 0.005)
{
    FillOptions options;
    options.cell = dx, options.solid.max_cells = 48, options.solid.directions = 48;
    const FilledObject filled = fill(box_of_splats(gap), options);
    Body b;
    b.spacing = std::cbrt(filled.particle_volume), b.surface = filled.surface;
    b.splats = carried(filled.splats);
    Setup& s = b.setup;
    s.lattice = {{64, 64, 64}, dx};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.3);
    s.materials = {paper_clay(dx, 8)};
    Material<double>& m = s.materials[0];
    const double young = 1e5;
    m.plasticity = Plasticity::von_mises, m.yield = 5;
    m.mu = young / 2.6, m.lambda = young * 0.3 / (1.3 * 0.4);
    for (const Vec3<double>& x : filled.particles) s.particles.push_back({x, {}, {}, {}, 0, 0, 0});
    for (const Vec3<float>& x : filled.splats.centre)
        s.gaussians.push_back(gaussian_at(cast<double>(x), 0));
    b.look.lattice = {{128, 128, 128}, float(dx / 2)};
    b.look.smoothing = Smoothing::none;
    return b;
}

// Without what was put inside of it.
inline void make_hollow(Body& b)
{
    std::vector<std::uint32_t> skin;
    for (std::size_t i = 0; i < b.surface; ++i) skin.push_back(std::uint32_t(i));
    b.splats = carried(picked(b.splats.cloud, skin));
    b.setup.gaussians.resize(b.surface);
}

// Thrown so that it is drawn to `times` its length in `seconds`, and keeps its volume.
inline void draw_out(Body& b, double times, double seconds)
{
    const double rate = (times - 1) / seconds;
    for (Particle<double>& p : b.setup.particles) {
        const Vec3<double> d = p.x - middle;
        p.v = rate * Vec3<double>{d.x, -d.y / 2, -d.z / 2};
        p.C = {{rate, 0, 0}, {0, -rate / 2, 0}, {0, 0, -rate / 2}};
    }
}

// Cut at x = 0.5, and its halves thrown apart at this speed [m/s] each.
inline void part(Body& b, double speed)
{
    const auto side = [](double x) { return x < middle.x ? below : above; };
    for (Particle<double>& p : b.setup.particles)
        p.v = {p.x.x < middle.x ? -speed : speed, 0, 0}, p.sides = std::uint32_t(side(p.x.x));
    for (Gaussian<double>& g : b.setup.gaussians) g.sides = std::uint32_t(side(g.x.x));
    b.setup.cuts = true;
}

// The deformation of the particle that is nearest to each: what is left of it as stress.
inline void make_elastic(std::vector<Gaussian<double>>& gaussians,
                         const std::vector<Particle<double>>& particles)
{
    std::vector<Vec3<double>> x;
    for (const Particle<double>& p : particles) x.push_back(p.x);
    const Cells cells(x, dx);
    for (Gaussian<double>& g : gaussians) {
        double nearest = 4 * dx;
        const Particle<double>* found = nullptr;
        cells.each_near(g.x, {2 * dx, 2 * dx, 2 * dx}, [&](std::uint32_t j) {
            if (length(x[j] - g.x) < nearest) nearest = length(x[j] - g.x), found = &particles[j];
        });
        if (!found) continue;
        const Eigen<double> e = eigen(raised(found->e, 1.0));
        const auto root = [](double v) { return std::sqrt(max(v, 0.0)); };
        const Mat3<double> V =
            full(composed(e.axes, {root(e.value.x), root(e.value.y), root(e.value.z)}));
        g.F = V * polar_rotation(g.F);
    }
}

inline Picture picture_of(const SplatCloud& cloud, const std::vector<Gaussian<double>>& gaussians,
                          const Eye<float>& eye)
{
    SplatFrame shown;
    shown.eyes = {eye};
    for (const Gaussian<double>& g : gaussians) {
        shown.moved_centre.push_back(cast<float>(g.x));
        shown.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
    }
    return cpu_raster(cloud, shown).front();
}

inline Picture picture_of(const CarriedSplats& splats, const Simulator& solver,
                          const Eye<float>& eye, Follow follow = Follow::total)
{
    std::vector<Gaussian<double>> g = solver.gaussians();
    if (follow == Follow::elastic) make_elastic(g, solver.particles());
    if (follow == Follow::rigid)
        for (Gaussian<double>& one : g) one.F = diagonal(1.0);
    return picture_of(splats.cloud, g, eye);
}

// Where the clay's surface is, seen by the eye.
inline std::vector<float> clay_seen(const Body& b, const Simulator& solver, const Eye<float>& eye)
{
    const std::vector<Mesh> meshes = surface(solver.particles(), b.setup.materials, b.look);
    return mesh_depths(eye, meshes.at(0).vertices, meshes.at(0).triangles);
}

struct Upkeep {
    SplitOptions split;
    RefillOptions refill;
    bool splits = true, refills = true;
    int every = 3;  // frames
};

// Plays so many frames; with `upkeep`, splats are split and added. Returns how many were.
inline std::pair<std::size_t, std::size_t> play(Body& b, EditableSimulator& solver, int frames,
                                                const Upkeep* upkeep = nullptr)
{
    std::size_t split_up = 0, added = 0;
    for (int f = 1; f <= frames; ++f) {
        solver.advance({}, frame);
        if (!upkeep || f % upkeep->every != 0) continue;
        std::vector<Gaussian<double>> g = solver.gaussians();
        if (upkeep->splits)
            split_up += split(b.splats, g, upkeep->split, b.setup.walls).splits.size();
        if (upkeep->refills)
            added +=
                refill(b.splats, g, solver.particles(), {b.spacing}, upkeep->refill, b.setup.walls)
                    .added.size();
        solver.set_gaussians(g);
    }
    return {split_up, added};
}

}  // namespace knead::kneaded
