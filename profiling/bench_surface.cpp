// Time per surface of the ball on the device: of a graph of the whole, and of each stage; with what
// was computed: counts, volume and a hash, to see whether a change of speed changed the result.
// usage: bench_surface [nodes=128] [smoothings=5] [none|laplace|taubin]
#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "cuda/mpm/stencil.h"
#include "host/bench/ball.h"
#include "host/surface/gpu_surface.h"

namespace {

using namespace knead;

// FNV-1a over the bits of the meshes.
std::uint64_t hash_of(const std::vector<Mesh>& meshes)
{
    std::uint64_t h = 14695981039346656037ull;
    const auto mix = [&h](std::uint32_t bits) {
        for (int k = 0; k < 4; ++k, bits >>= 8) h = (h ^ (bits & 255)) * 1099511628211ull;
    };
    for (const Mesh& m : meshes) {
        for (const auto* points : {&m.vertices, &m.normals})
            for (const Vec3<float> v : *points)
                for (float x : {v.x, v.y, v.z}) mix(std::bit_cast<std::uint32_t>(x));
        for (const Int3 t : m.triangles)
            for (int v : {t.x, t.y, t.z}) mix(std::uint32_t(v));
    }
    return h;
}

// Particles as a solver leaves them: in the order of its lattice's cells.
void sort_by_cell(Setup& s)
{
    const auto index = [&](const Particle<double>& q) {
        return s.lattice.index(base_node(q.x, s.lattice.dx));
    };
    std::stable_sort(s.particles.begin(), s.particles.end(),
                     [&](const auto& a, const auto& b) { return index(a) < index(b); });
}

int run(int nodes, int iterations, Smoothing smoothing)
{
    Setup setup = ball(nodes / 2);
    sort_by_cell(setup);
    SurfaceOptions options;
    options.lattice = {{nodes, nodes, nodes}, 1.0f / float(nodes)};
    options.smoothing = smoothing, options.iterations = iterations;
    GpuSurface surface(setup.particles, setup.materials, options);
    const std::vector<Mesh> meshes = surface.surface(setup.particles);
    double enclosed = 0;
    for (const Mesh& m : meshes) enclosed += volume(m);
    const double clay = double(setup.particles.size()) * setup.materials[0].volume;
    std::printf("%zu particles, density on %d^3: %zu vertices, %zu triangles, %.1f MiB\n",
                setup.particles.size(), nodes, surface.needed().vertices,
                surface.needed().triangles, double(surface.memory()) / 1048576);
    std::printf("volume %.6f of the clay's, hash %016llx\n", enclosed / clay,
                static_cast<unsigned long long>(hash_of(meshes)));
    surface.replays(10);
    std::vector<double> seconds = surface.replays(100);
    std::sort(seconds.begin(), seconds.end());
    std::printf("median %.2f us, best %.2f us of %zu replays\n", 1e6 * seconds[seconds.size() / 2],
                1e6 * seconds.front(), seconds.size());
    for (const StageTime& t : surface.stage_times())
        std::printf("  %-10s %9.2f us\n", t.name.c_str(), 1e6 * t.seconds);
    return hash_of(surface.meshes()) == hash_of(meshes) ? 0 : 1;
}

}  // namespace

int main(int count, char** words)
{
    const auto number = [&](int at, int otherwise) {
        return count > at ? std::atoi(words[at]) : otherwise;
    };
    const int nodes = number(1, 128), iterations = number(2, 5);
    const std::string by = count > 3 ? words[3] : "taubin";
    const Smoothing smoothing = by == "none"      ? Smoothing::none
                                : by == "laplace" ? Smoothing::laplace
                                                  : Smoothing::taubin;
    if (nodes < 32 || nodes > 512 || nodes % 8 || iterations < 0 || iterations > 1000) {
        std::fprintf(stderr,
                     "usage: bench_surface [nodes: 32 to 512, by 8] [smoothings] "
                     "[none|laplace|taubin]\n");
        return 2;
    }
    try {
        return run(nodes, iterations, smoothing);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 4;
    }
}
