// What an edit costs: the paper's ball of 137 k particles pressed by two cones, edited between two
// frames. For each edit the call itself, the frame after it (which captures the graphs anew where
// the edit asks for it), and a frame without an edit. Medians over `rounds`; the first, which
// allocates, apart.
//
//   bench_edits [nodes] [rounds]      milliseconds, and a hash of where the clay is in the end
//
//   bench_edits pieces [particles] [rounds]
//                                     milliseconds to count the connected pieces of two balls that
//                                     a gap parts (piece_count.h), and their number
//
//   bench_edits commands [rounds]     the same edits as commands of a document, by turns with the
//                                     simulator's edit alone: scenes/squeeze.json, from the top of
//                                     the tree
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>

#include "host/base/machine.h"
#include "host/bench/ball.h"
#include "host/scene/presets.h"
#include "host/session/scene_editor.h"
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

// A command and the simulator's edit that it stands for. Both are made once a round, each before a
// frame of its own.
struct Pair {
    const char* name;
    std::function<void(int round)> edit;
    std::function<Command(int round)> command;
};

int commands(int rounds)
{
    Scene scene = read_scene("scenes/squeeze.json");
    build(scene, available_memory());
    const auto solver = gpu_present() ? gpu_solver(scene.setup, 0) : cpu_solver(scene.setup);
    SceneSplats splats(scene, {});
    SessionLoop loop(
        *solver, [](double, double) { return no_motion(); }, loop_options(scene));
    IdSource ids;
    SceneEditor editor({scene, splats, loop, solver.get(), [](const HandsOptions&) {}, {}},
                       std::make_shared<const Document>(document_of(scene)), ids);
    const ObjectId ball{1};
    const Vec3<double> centre = editor.document()->objects.at(0)->pose.p;
    const auto moved = [](int round) { return Vec3<double>{round % 2 ? 1e-4 : 0.0, 0, 0}; };
    const auto gravity = [](int round) { return Vec3<double>{0, -9.81 - 1e-3 * (round % 7), 0}; };
    const auto clay = [](int round) {
        MaterialSpec spec = material_spec("clay");
        spec.young = 1e6 + round % 7;
        return spec;
    };
    SceneObject lump;
    lump.name = "lump", lump.material = material_spec("clay");
    lump.pose.p = {0.8, 0.8, 0.8}, lump.source.size = {0.21, 0.21, 0.21};
    PreparedObject ready = prepared(scene, scene.setup.walls, lump);
    leave_room(ready, solver->places(surroundings(ready)));
    int number = -1;
    const Pair pairs[] = {
        {"set_gravity", [&](int k) { solver->set_gravity(gravity(k)); },
         [&](int k) { return SetGravity{gravity(k + 1)}; }},
        {"set_material",
         [&](int k) {
             Material<double> m = made(clay(k));
             m.category = solver->config().materials[0].category;
             solver->set_material(0, m);
         },
         [&](int k) {
             return SetMaterial{ball, clay(k + 1)};
         }},
        {"place_object",
         [&](int k) {
             solver->move(0, {{1, 0, 0, 0}, (k % 2 ? 1.0 : -1.0) * Vec3<double>{1e-4, 0, 0}});
         },
         [&](int k) {
             return PlaceObject{ball, centre + moved(k), {}};
         }},
        {"add_object", [&](int) { number = solver->add(ready.material, ready.particles); },
         [&](int) { return AddObject{lump}; }},
        {"remove_objects", [&](int) { solver->remove(number); },
         [&](int) { return RemoveObjects{{ObjectRef("lump")}}; }},
    };
    fmt::print("{}, {} particles, {} in the lump\n", solver->name(), scene.setup.particles.size(),
               ready.particles.size());
    fmt::print("{:16} {:>10} {:>10} {:>12}\n", "command", "edit ms", "command ms", "more ms");
    std::vector<std::vector<double>> edits(std::size(pairs)), by_command(std::size(pairs));
    for (int round = 0; round <= rounds; ++round)
        for (const bool as_command : {false, true})
            for (std::size_t p = 0; p < std::size(pairs); ++p) {
                loop.step();
                loop.particles();
                double took = 0;
                if (as_command) {
                    const Command command = pairs[p].command(round);
                    PreparedObject given = ready;
                    took = milliseconds([&] {
                        const auto refused = editor.apply(command, &given).refusal;
                        if (refused) throw std::runtime_error(refused->text());
                    });
                } else {
                    took = milliseconds([&] { pairs[p].edit(round); });
                }
                if (round > 0) (as_command ? by_command : edits)[p].push_back(took);
            }
    for (std::size_t p = 0; p < std::size(pairs); ++p)
        fmt::print("{:16} {:10.3f} {:10.3f} {:12.3f}\n", pairs[p].name, median(edits[p]),
                   median(by_command[p]), median(by_command[p]) - median(edits[p]));
    return 0;
}

int pieces(int particles, int rounds)
{
    Setup s = ball(64);
    const double radius = std::cbrt(particles / 2.0 / (4.19 * 8)), cells = 4 * radius;
    int n = 32;
    while (n < cells + 16) n *= 2;
    s.lattice = {{n, n, n}, 1.0 / n};
    s.walls = walls_inside(s.lattice, 3, ContactMode::slip, 0);
    s.particles.clear();
    const double dx = s.lattice.dx;
    s.materials.resize(1);
    s.materials[0].volume = dx * dx * dx / 8;
    s.materials[0].mass = s.materials[0].volume * s.materials[0].density;
    for (const double side : {-1.0, 1.0}) {
        const Vec3<double> centre{0.5 + side * (radius + 1) * dx, 0.5, 0.5};
        const int r = int(2 * radius) + 1;
        for (int z = -r; z < r; ++z)
            for (int y = -r; y < r; ++y)
                for (int x = -r; x < r; ++x) {
                    const Vec3<double> d{dx / 2 * (x + 0.5), dx / 2 * (y + 0.5),
                                         dx / 2 * (z + 0.5)};
                    Particle<double> q{};
                    q.x = centre + d;
                    if (length(d) < radius * dx) s.particles.push_back(q);
                }
    }
    const auto solver = gpu_present() ? gpu_solver(s, 0) : cpu_solver(s);
    solver->advance(no_motion(), 1e-4);  // sorted
    const std::vector<int> group = {0};
    std::vector<double> took;
    int count = 0;
    const double first = milliseconds([&] { count = solver->piece_counts(group, 1).at(0); });
    for (int k = 0; k < rounds; ++k)
        took.push_back(milliseconds([&] { solver->piece_counts(group, 1); }));
    fmt::print(
        "{}: {} particles, {} cells, {} pieces: first {:.3f} ms, median {:.3f} ms, worst "
        "{:.3f} ms\n",
        solver->name(), solver->particle_count(), n, count, first, median(took),
        *std::max_element(took.begin(), took.end()));
    return count == 2 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc > 1 && std::string(argv[1]) == "commands")
        return commands(std::max(argc > 2 ? std::atoi(argv[2]) : 50, 2));
    if (argc > 1 && std::string(argv[1]) == "pieces")
        return pieces(argc > 2 ? std::atoi(argv[2]) : 1000000,
                      std::max(argc > 3 ? std::atoi(argv[3]) : 50, 2));
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
