// A ball of clay on a floor, pressed by a sphere from above; its surface is written as a mesh.
// usage: press [MESH.glb | MESH.obj | MESH.ply]
#include <cstdio>
#include <exception>

#include "host/files/mesh_file.h"
#include "host/scene/scene.h"
#include "host/solver/editable_simulator.h"
using namespace knead;
using Point = Vec3<double>;

constexpr int nodes = 32;
constexpr double dx = 0.32 / nodes, floor_height = 3 * dx;     // [m]
constexpr double ball_radius = 0.05, presser_radius = 0.03;    // [m]
constexpr Point ball{0.16, floor_height + ball_radius, 0.16};  // its centre [m]

void add_ball(Setup& setup)  // eight particles a cell
{
    Material<double> clay = preset("soft-clay");
    clay.volume = dx * dx * dx / 8;
    clay.mass = clay.density * clay.volume;
    setup.materials = {clay};
    Particle<double> particle{};
    for (double x = dx / 4; x < 0.32; x += dx / 2)
        for (double y = dx / 4; y < 0.32; y += dx / 2)
            for (double z = dx / 4; z < 0.32; z += dx / 2) {
                particle.x = {x, y, z};
                if (length(particle.x - ball) < ball_radius) setup.particles.push_back(particle);
            }
}

void add_presser(Setup& setup)  // a tool of one sphere, on one joint
{
    setup.rig.spheres = {{{}, {1}, {}, presser_radius}};
    setup.rig.primitives = {{1, {0, 0, 0}, 0}};
    setup.tools = {{ContactMode::separate, 0.3, false, true}};
}

int main(int count, char** arguments)
try {
    Setup setup;
    setup.lattice = {{nodes, nodes, nodes}, dx};
    setup.walls = walls_inside(setup.lattice, 3, ContactMode::separate, 0.3);
    setup.gravity = {0, -9.81, 0};
    add_ball(setup);
    add_presser(setup);
    const auto solver = gpu_present() ? gpu_solver(setup, 0) : cpu_solver(setup);
    Joint<double> joint{{1, 0, 0, 0}, ball + Point{0, ball_radius + presser_radius, 0}};
    for (int frame = 0; frame < 18; ++frame) {
        const Joint<double> before = joint;
        joint.p.y -= 0.2 / 90;  // 0.2 m/s, 90 frames a second
        solver->advance({{before}, {joint}, {1}}, 1.0 / 90);
    }
    const SurfaceOptions options{{{2 * nodes, 2 * nodes, 2 * nodes}, float(dx / 2)}};
    write_mesh(count > 1 ? arguments[1] : "press.glb",
               surface(solver->particles(), setup.materials, options));
    std::printf("%s: %zu particles\n", solver->name().c_str(), setup.particles.size());
} catch (const std::exception& problem) {
    return std::fprintf(stderr, "press: %s\n", problem.what()), 1;
}
