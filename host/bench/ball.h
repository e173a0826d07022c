// The paper's benchmark: a ball of elastoplastic clay in a box of 1 m, pressed by two tools from
// left and right. [VR-Doh 2025, section 6]
#pragma once
#include <cmath>

#include "host/hands/hands.h"
#include "host/solver/simulator.h"

namespace knead {

// E [Pa], Poisson's ratio, yield stress [Pa], density [kg/m^3].
inline Material<double> paper_clay(double dx, double per_cell)
{
    constexpr double E = 1e6, nu = 0.3, density = 1000;
    Material<double> m{};
    m.elasticity = Elasticity::neo_hookean;
    m.plasticity = Plasticity::von_mises;
    m.density = density;
    m.mu = E / (2 * (1 + nu));
    m.lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
    m.bulk = E, m.exponent = 1;
    m.yield = 1e5, m.yield_floor = 1e3;
    m.volume = dx * dx * dx / per_cell;
    m.mass = m.density * m.volume;
    return m;
}

// A ball of diameter 0.5 m in the middle of nodes^3 nodes over 1 m; 8 particles per cell, regular.
inline Setup ball(int nodes)
{
    Setup s{};
    s.lattice = {{nodes, nodes, nodes}, 1.0 / nodes};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.3);
    s.gravity = {0, -9.81, 0};
    const double dx = s.lattice.dx;
    s.materials = {paper_clay(dx, 8)};
    for (int z = 0; z < 2 * nodes; ++z)
        for (int y = 0; y < 2 * nodes; ++y)
            for (int x = 0; x < 2 * nodes; ++x) {
                Particle<double> q{};
                q.x = {dx / 2 * (x + 0.5), dx / 2 * (y + 0.5), dx / 2 * (z + 0.5)};
                if (length(q.x - Vec3<double>{0.5, 0.5, 0.5}) < 0.25) s.particles.push_back(q);
            }
    return s;
}

// Adds `count` Gaussians near the ball's surface, as in a captured object: within 1/64 m (a cell)
// of it.
inline void add_gaussians(Setup& s, int count)
{
    for (int i = 0; i < count; ++i) {
        const double height = 1 - (2 * i + 1.0) / count, turn = 2.399963229728653 * i;
        const double across = std::sqrt(1 - height * height), r = 0.25 + (i * 7 % 16 - 11) / 1024.0;
        const Vec3<double> out{across * std::cos(turn), height, across * std::sin(turn)};
        s.gaussians.push_back(gaussian_at(Vec3<double>{0.5, 0.5, 0.5} + r * out, 0));
    }
}

// Adds two cones of radius 6 cm bound to the wrists.
inline void add_tools(Setup& s)
{
    for (int side = 0; side < side_count; ++side) {
        const int wrist_joint = side * joint_count + wrist, first = 2 * side;
        for (int end = 0; end < 2; ++end) {
            Binding<float> b{};
            for (int& j : b.joint) j = wrist_joint;
            b.weight[0] = 1;
            b.offset[0] = {0, end ? 0.12f : -0.12f, 0};
            b.radius = end ? 0.06f : 0.04f;
            s.rig.spheres.push_back(b);
        }
        s.rig.primitives.push_back({2, {first, first + 1, first + 1}, side});
        s.tools.push_back({side ? ContactMode::separate : ContactMode::sticky, 0.4, false, true});
    }
}

// Joints with both wrists at distance `apart` [m] from the middle, tilted by `tilt` [rad].
inline std::vector<Joint<double>> wrists(double apart, double tilt)
{
    std::vector<Joint<double>> joints(std::size_t(int(side_count) * joint_count),
                                      {{1, 0, 0, 0}, {0.5, 0.5, 0.5}});
    for (int side = 0; side < side_count; ++side) {
        Joint<double>& j = joints[std::size_t(side * joint_count + wrist)];
        j.p = {0.5 + (side ? apart : -apart), 0.5, 0.5};
        j.q = turn_about(Vec3<double>{0, 0, 1}, side ? tilt : -tilt);
    }
    return joints;
}

// Motion from t to t + duration [s]: closing at 1 m/s from just outside the ball, then at rest.
inline Motion closing(double t, double duration)
{
    const auto at = [](double time) {
        const double way = std::fmin(1.0 * time, 0.12);
        return wrists(0.31 - way, 2 * way);
    };
    return {at(t), at(t + duration), {1, 1}};
}

}  // namespace knead
