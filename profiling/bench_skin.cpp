// How smooth clay looks: roughness at rest and after a squeeze, the rim of a fingertip's dent
// against that of four times finer cells, and how long particles take to be packed. In cells.
//
//   bench_skin [rest | squeeze | rim | time]    all but the rim, which takes minutes, if none
#include <fmt/format.h>

#include <chrono>
#include <cstring>

#include "host/scene/seed.h"
#include "host/surface/surface.h"
#include "tests/scene/pressed_clay.h"
#include "tests/surface/roughness.h"

namespace {

using namespace knead;

Mesh mesh_of(const Scene& scene, const std::vector<Particle<double>>& particles)
{
    return surface(particles, scene.setup.materials, scene.surface).at(0);
}

void print_row(const std::string& what, const Scene& scene, const std::vector<double>& distances)
{
    const Roughness r = roughness_of(distances);
    const double dx = scene.setup.lattice.dx;
    fmt::print("{:32} rms {:.4f}, at most {:.4f}, of {} vertices\n", what, r.rms / dx, r.max / dx,
               r.vertices);
}

void rest()
{
    for (const double per_cell : {8, 4, 1})
        for (const int cells : {24, 32, 48, 64}) {
            const Scene scene = clay_scene(cells, ShapeKind::sphere, {0.503, 0.497, 0.511},
                                           {0.5, 0.5, 0.5}, per_cell);
            const double volume = double(scene.setup.particles.size()) *
                                  scene.setup.materials[0].volume / shape_volume(scene.objects[0]);
            print_row(fmt::format("{} cells, {} a cell, volume {:.5f}", cells, per_cell, volume),
                      scene, from_sphere(mesh_of(scene, scene.setup.particles)));
        }
}

void squeezed()
{
    for (const int cells : {32, 40, 64}) {
        const Pressing p = squeeze(cells);
        const Mesh mesh = mesh_of(p.scene, after(p));
        print_row(fmt::format("{} cells, squeezed", cells), p.scene,
                  from_quadric(mesh, 3 * p.scene.setup.lattice.dx));
    }
}

// Mean height over circles around the dent's axis, every eighth of a 24th of a metre [24ths].
std::vector<double> profile(int cells, unsigned seed)
{
    constexpr double u = 1.0 / 24, step = u / 8;
    const Pressing p = fingertip(cells, seed);
    const Mesh mesh = mesh_of(p.scene, after(p));
    const Vec3<double> axis = p.by[0].to;
    std::vector<LeastSquares<2>> rings(48);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Vec3<double> d = cast<double>(mesh.vertices[v]) - axis;
        const double r = std::hypot(d.x, d.z) / step;
        if (mesh.normals[v].y < 0.1f) continue;
        for (int k = std::max(0, int(r) - 1); k <= int(r) + 2 && k < 48; ++k)
            if (std::abs(r - k) < 1.5) rings[std::size_t(k)].add({1, r - k}, (d.y + axis.y) / u);
    }
    std::vector<double> heights;
    for (LeastSquares<2>& ring : rings) heights.push_back(ring.solved()[0] - 10);
    return heights;
}

void rim()
{
    constexpr int seeds = 24;
    const std::vector<double> fine = profile(96, 1);
    std::vector<double> mean(fine.size());
    double off = 0, steepest = 0, steepest_fine = 0;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        const std::vector<double> coarse = profile(24, seed);
        double sum = 0, rings = 0, most = 0;
        for (std::size_t k = 4; k + 1 < fine.size(); ++k) {
            const double slope = 4 * (fine[k + 1] - fine[k - 1]);
            const double d = (coarse[k] - fine[k]) / std::hypot(1.0, slope);
            if (k >= 12 && k <= 32) sum += d * d, ++rings;
            most = std::max(most, 4 * (coarse[k + 1] - coarse[k - 1]));
            steepest_fine = std::max(steepest_fine, slope);
            mean[k] += coarse[k] / seeds;
        }
        off += std::sqrt(sum / rings) / seeds, steepest += most / seeds;
    }
    fmt::print("{:>8} {:>8} {:>8}\n", "radius", "24", "96");
    for (std::size_t k = 4; k + 1 < fine.size(); ++k)
        fmt::print("{:8.3f} {:8.3f} {:8.3f}\n", double(k) / 8, mean[k], fine[k]);
    fmt::print(
        "off by {:.4f} rms from radius 1.5 to 4; steepest slope {:.3f}, of 96 cells {:.3f}\n", off,
        steepest, steepest_fine);
}

void time()
{
    const auto start = std::chrono::steady_clock::now();
    const Scene scene = clay_scene(124, ShapeKind::sphere, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    fmt::print("{} particles in {:.2f} s\n", scene.setup.particles.size(), took.count());
}

}  // namespace

int main(int count, char** given)
{
    const std::string what = count > 1 ? given[1] : "";
    if (what.empty() || what == "rest") rest();
    if (what.empty() || what == "squeeze") squeezed();
    if (what.empty() || what == "time") time();
    if (what == "rim") rim();
}
