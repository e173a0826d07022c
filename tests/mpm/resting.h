// What tests of clay that need not move have in common: back ends, clay, a ball that presses it.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "cuda/mpm/sleep.h"
#include "host/hands/hands.h"
#include "host/solver/editable_simulator.h"

namespace knead::resting {

using Given = Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;
constexpr double frame = 1.0 / 90, dx = 1.0 / 32;

struct Backend {
    const char* name;
    std::unique_ptr<EditableSimulator> (*make)(const Given&);
};
inline std::unique_ptr<EditableSimulator> on_device(const Given& s) { return gpu_solver(s, 0); }
inline const Backend backends[] = {{"float", cpu_solver}, {"cuda", on_device}};

class Resting : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override
    {
        if (GetParam().make == on_device && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    std::unique_ptr<EditableSimulator> make(const Given& s) { return GetParam().make(s); }
    // The same with no clay at rest.
    std::unique_ptr<EditableSimulator> awake_throughout(Given s)
    {
        s.rest.mode = RestMode::none;
        return make(s);
    }
};

// Of E = 1 MPa and 1000 kg/m^3: waves of 37 m/s. Yields at `yield` [Pa], 0: never.
inline Given scene(Int3 cells, double yield = 0)
{
    Given s;
    s.lattice = {cells, dx};
    s.walls = walls_inside(s.lattice, 3, ContactMode::sticky, 0.4);
    Material<double> m{};
    m.elasticity = Elasticity::neo_hookean,
    m.plasticity = yield > 0 ? Plasticity::von_mises : Plasticity::none;
    m.density = 1000, m.mu = 1e6 / 2.6, m.lambda = 0.3e6 / (1.3 * 0.4), m.yield = yield;
    m.volume = dx * dx * dx / 8, m.mass = m.volume * m.density;
    s.materials = {m};
    s.rest = {RestMode::sleep, 0.05, 9, 4.9, 4 * dx};
    s.step.courant = 0.8;  // what late waking costs grows with the substep
    return s;
}

// A box of clay from cell to cell.
inline void add(Given& s, Int3 low, Int3 high, Vec3<double> v = {0, 0, 0})
{
    for (int z = 2 * low.z; z < 2 * high.z; ++z)
        for (int y = 2 * low.y; y < 2 * high.y; ++y)
            for (int x = 2 * low.x; x < 2 * high.x; ++x) {
                Particle<double> q{};
                q.x = dx / 2 * Vec3<double>{x + 0.5, y + 0.5, z + 0.5}, q.v = v;
                s.particles.push_back(q);
            }
}

inline Motion at(Vec3<double> from, Vec3<double> to)
{
    Motion m;
    m.from.assign(2 * joint_count, {{1, 0, 0, 0}, from});
    m.to.assign(2 * joint_count, {{1, 0, 0, 0}, to});
    return m;
}
inline const Motion nowhere = at({0, 0, 0}, {0, 0, 0});

// A ball that hangs on the joint.
inline void add_ball(Given& s, double radius)
{
    Binding<float> b{};
    b.weight[0] = 1, b.radius = float(radius);
    s.rig.spheres = {b};
    s.rig.primitives = {{1, {0, 0, 0}, 0}};
    s.tools = {{ContactMode::separate, 0.3, false, true}};
}

inline bool same(const Particle<double>& a, const Particle<double>& b)
{
    return std::memcmp(&a, &b, sizeof a) == 0;
}

struct Apart {
    double mean = 0, max = 0;  // [cells]
};
inline Apart apart(const Particles& a, const Particles& b)
{
    Apart d;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double way = length(a[i].x - b[i].x) / dx;
        d.mean += way / double(a.size()), d.max = std::fmax(d.max, way);
    }
    return d;
}

// A ball presses from above on one end of a slab that sticks to the floor.
struct Pressed {
    Given s = scene({64, 24, 20}, 2e4);
    static constexpr double radius = 3 * dx, top = 8 * dx;
    Pressed()
    {
        add(s, {4, 3, 5}, {60, 8, 13});
        add_ball(s, radius);
    }
    // Sinks by `deep` [m] in so many frames. Tells what moved and woke in all.
    FrameStats press(Simulator& solver, double deep, int frames) const
    {
        const auto place = [&](int f) {
            return Vec3<double>{10 * dx, top + radius + 0.1 * dx - deep * f / frames, 9 * dx};
        };
        FrameStats all;
        for (int f = 0; f < frames; ++f)
            add_to(all, solver.advance(at(place(f), place(f + 1)), frame));
        return all;
    }
};

}  // namespace knead::resting
