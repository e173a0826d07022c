// How few particles per cell a scene may ask for: elastic clay that is let go from a stretch must
// come back in one piece.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <tuple>

#include "host/base/errors.h"
#include "host/scene/scene.h"
#include "host/scene/seed.h"
#include "host/solver/editable_simulator.h"
#include "tests/folder.h"

namespace knead {
namespace {

using Cells = std::set<std::tuple<int, int, int>>;

// How many regions of cells that touch hold the clay.
int regions(const std::vector<Particle<double>>& clay, double dx)
{
    Cells left;
    for (const Particle<double>& q : clay)
        left.insert({int(q.x.x / dx), int(q.x.y / dx), int(q.x.z / dx)});
    int count = 0;
    for (; !left.empty(); ++count)
        for (Cells front{*left.begin()}; !front.empty();) {
            const auto [x, y, z] = *front.begin();
            front.erase(front.begin());
            left.erase({x, y, z});
            for (int n = 0; n < 27; ++n) {
                const auto next = left.find({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
                if (next != left.end()) front.insert(left.extract(next));
            }
        }
    return count;
}

// The most regions that a bar of 12 x 5 x 5 cells is in while it swings back from a stretch.
int most_regions(Scene scene, double stretch, double per_cell, unsigned seed)
{
    scene.objects[0].per_cell = per_cell, scene.seed = seed;
    build(scene, std::size_t(1) << 33);
    const Vec3<double> centre = scene.objects[0].centre;
    const double across = 1 / std::sqrt(stretch);
    for (Particle<double>& q : scene.setup.particles) {
        const Vec3<double> d = q.x - centre;
        q.x = centre + Vec3<double>{stretch * d.x, across * d.y, across * d.z};
        q.e = {stretch * stretch - 1, 1 / stretch - 1, 1 / stretch - 1, 0, 0, 0};
    }
    scene.setup.threads = 1;
    const auto solver = cpu_solver(scene.setup);
    int most = 0;
    for (int frame = 0; frame < 10; ++frame) {
        solver->advance({}, 0.01);
        most = std::max(most, regions(solver->particles(), scene.setup.lattice.dx));
    }
    return most;
}

class Tearing : public InFolder {};

TEST_F(Tearing, TheFewestParticlesPerCellHoldABarTogetherAndOneDoesNot)
{
    std::ofstream(folder / "bar.json") << R"({"schema": "knead.scene/1", "gravity": [0, 0, 0],
        "objects": [{"shape": "box", "centre": [0.5, 0.5, 0.5], "per_cell": 2,
            "size": [0.1875, 0.078125, 0.078125],
            "material": {"preset": "jelly", "young": 1e5}}]})";
    const std::string bar = (folder / "bar.json").string();
    const Scene scene = read_scene(bar);
    int torn = 0;
    for (const unsigned seed : {1u, 2u, 3u}) {
        EXPECT_EQ(most_regions(scene, 1.6, 2, seed), 1);
        EXPECT_EQ(most_regions(scene, 2, 8, seed), 1);
        torn += most_regions(scene, 1.6, 1, seed) > 1;
    }
    EXPECT_GT(torn, 0);
    try {
        read_scene(bar, {"objects.0.per_cell=1.9"});
        ADD_FAILURE() << "was read";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("/objects/0/per_cell: expected at least 2"),
                  std::string::npos)
            << e.what();
    }
}

}  // namespace
}  // namespace knead
