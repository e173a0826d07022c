// What an edit costs: the paper's ball of 137 k particles pressed by two cones, edited between two
// frames. For each edit the call itself, the frame after it (which captures the graphs anew where
// the edit asks for it), and a frame without an edit. Medians over `rounds`; the first, which
// allocates, apart.
//
//   bench_edits [nodes] [rounds]      milliseconds, and a hash of where the clay is in the end
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>

#include "host/bench/ball.h"
#include "host/solver/audit.h"
#include "host/solver/editable_simulator.h"

namespace {

using namespace knead;

double milliseconds(const std::function<void()>& work)
{
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    return took.count();
}

double median(std::vector<double> of)
{
    std::nth_element(of.begin(), of.begin() + long(of.size() / 2), of.end());
    return of[of.size() / 2];
}

// A ball of so many particles in the upper corner of the box.
std::vector<Particle<double>> lump(std::size_t count, double dx)
{
    std::vector<Particle<double>> out;
    for (int r = 1; out.size() < count; ++r) {
        out.clear();
        for (int z = -r; z < r; ++z)
            for (int y = -r; y < r; ++y)
                for (int x = -r; x < r; ++x) {
                    Particle<double> p{};
                    const Vec3<double> d{dx / 2 * (x + 0.5), dx / 2 * (y + 0.5),
                                         dx / 2 * (z + 0.5)};
                    p.x = Vec3<double>{0.75, 0.8, 0.75} + d;
                    if (length(d) < dx / 2 * r) out.push_back(p);
                }
    }
    out.resize(count);
    return out;
}

}  // namespace

int main(int argc, char** argv)
{
    const int nodes = argc > 1 ? std::atoi(argv[1]) : 64;
    const int rounds = std::max(argc > 2 ? std::atoi(argv[2]) : 50, 2);
    Setup scene = ball(nodes);
    add_tools(scene);
    const auto solver = gpu_present() ? gpu_solver(scene, 0) : cpu_solver(scene);
    const double dx = scene.lattice.dx, frame = 1.0 / 90;
    const auto step = [&] { solver->advance(closing(0.05, frame), frame); };
    for (int f = 0; f < 10; ++f) step();
    const std::vector<Particle<double>> more = lump(10000, dx);
    int object = -1;
    std::shared_ptr<const Snapshot> snapshot;
    const struct {
        const char* name;
        std::function<void()> edit;
    } edits[] = {
        {"nothing", [] {}},
        {"snapshot", [&] { snapshot = solver->snapshot(); }},
        {"restore", [&] { solver->restore(*snapshot); }},
        {"add 10 k", [&] { object = solver->add(scene.materials[0], more); }},
        {"move 10 k",
         [&] {
             solver->move(object, {{1, 0, 0, 0}, {0, 1e-4, 0}});
         }},
        {"set material", [&] { solver->set_material(object, scene.materials[0]); }},
        {"set gravity",
         [&] {
             solver->set_gravity({0, -9.81, 0});
         }},
        {"set tools", [&] { solver->set_tools(scene.rig, scene.tools); }},
        {"remove 10 k", [&] { solver->remove(object); }},
    };
    fmt::print("{}, {} particles\n", solver->name(), scene.particles.size());
    fmt::print("{:14} {:>10} {:>10} {:>10} {:>10}\n", "edit", "first ms", "ms", "at most",
               "frame ms");
    std::vector<std::vector<double>> took(std::size(edits)), after(std::size(edits));
    for (int round = 0; round < rounds; ++round)
        for (std::size_t e = 0; e < std::size(edits); ++e) {
            took[e].push_back(milliseconds(edits[e].edit));
            after[e].push_back(milliseconds(step));
        }
    for (std::size_t e = 0; e < std::size(edits); ++e) {
        const double first = took[e][0];
        took[e].erase(took[e].begin());
        fmt::print("{:14} {:10.3f} {:10.3f} {:10.3f} {:10.3f}\n", edits[e].name, first,
                   median(took[e]), *std::max_element(took[e].begin(), took[e].end()),
                   median(after[e]));
    }
    fmt::print("{} particles left, state {}\n", solver->particles().size(),
               hexadecimal(audit(solver->particles(), solver->config().materials, dx).hash));
}
