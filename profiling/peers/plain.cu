// What an afternoon's CUDA makes of the same scene: one thread per particle in the order it was
// given, one atomic addition per node of its stencil, one thread per node of the whole lattice, a
// launch per stage. The formulas are those of the stages; all that is tuned there is left out.
// usage: peer_plain SCENE.json POSITIONS.f32, both as `knead bench --peers` writes them
#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <nv/target>

#include "cuda/device/device_array.cuh"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/plasticity.h"
#include "cuda/mpm/project.h"

namespace knead::peer {
namespace {

using gpu::check;
using gpu::DeviceArray;
using Json = nlohmann::json;

constexpr int threads = 128, numbers = 22;  // per particle

// One array per number of a particle, one after another.
struct Cloud {
    float* numbers;
    int count;

    HD float& at(int k, int i) const { return numbers[k * count + i]; }
    HD Particle<float> load(int i) const
    {
        const auto three = [&](int k) { return Vec3<float>{at(k, i), at(k + 1, i), at(k + 2, i)}; };
        return {three(0),
                three(3),
                {three(6), three(9), three(12)},
                {at(15, i), at(16, i), at(17, i), at(18, i), at(19, i), at(20, i)},
                at(21, i),
                0,
                0};
    }
    HD void store(int i, const Particle<float>& q) const
    {
        const Vec3<float> rows[] = {q.x, q.v, q.C.a, q.C.b, q.C.c};
        for (int r = 0; r < 5; ++r)
            at(3 * r, i) = rows[r].x, at(3 * r + 1, i) = rows[r].y, at(3 * r + 2, i) = rows[r].z;
        at(15, i) = q.e.xx, at(16, i) = q.e.yy, at(17, i) = q.e.zz;
        at(18, i) = q.e.xy, at(19, i) = q.e.xz, at(20, i) = q.e.yz, at(21, i) = q.k;
    }
};

struct World {
    Lattice<float> lattice;
    Walls<float> walls;
    Vec3<float> gravity;
    Material<float> clay;
    float dt;
    PushoutLimits<float> pushout;
    float4* nodes;

    HD int index(Int3 n) const { return (n.z * lattice.size.y + n.y) * lattice.size.x + n.x; }
};

__device__ void add(float4* to, const Node<float>& n)
{
    NV_IF_ELSE_TARGET(NV_PROVIDES_SM_90, (atomicAdd(to, make_float4(n.p.x, n.p.y, n.p.z, n.m));),
                      (atomicAdd(&to->x, n.p.x); atomicAdd(&to->y, n.p.y); atomicAdd(&to->z, n.p.z);
                       atomicAdd(&to->w, n.m);))
}

__global__ void to_grid(World w, Cloud cloud)
{
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i >= cloud.count) return;
    const Particle<float> q = cloud.load(i);
    const Stencil<float> s = stencil(q.x, w.lattice.dx);
    scatter(q, w.clay, s, w.lattice.dx, w.dt, [&](Int3 step, const Node<float>& share) {
        add(&w.nodes[w.index(s.base + step)], share);
    });
}

__global__ void on_grid(World w, Colliders<float> tools, Mask all)
{
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x), nx = w.lattice.size.x,
              ny = w.lattice.size.y;
    if (i >= w.lattice.node_count()) return;
    const float4 sum = w.nodes[i];
    bool clipped;
    const Node<float> node =
        update(Node<float>{{sum.x, sum.y, sum.z}, sum.w}, {i % nx, i / nx % ny, i / (nx * ny)},
               w.lattice, w.walls, w.gravity, w.dt, clipped,
               [&](Vec3<float> x, Vec3<float> v) { return apply_tools(tools, all, x, v); });
    w.nodes[i] = {node.p.x, node.p.y, node.p.z, node.m};
}

__global__ void to_particles(World w, Cloud cloud, Colliders<float> tools, Mask all)
{
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i >= cloud.count) return;
    Particle<float> q = cloud.load(i);
    const Stencil<float> s = stencil(q.x, w.lattice.dx);
    const auto sum = gather(q, s, w.lattice.dx, [&](Int3 step) -> Four<float> {
        const float4 node = w.nodes[w.index(s.base + step)];
        return four(Vec3<float>{node.x, node.y, node.z}, node.w);
    });
    const float per_cell = mass_around(sum) / w.clay.mass;
    damp_isolated_particle(q.C, w.nodes[w.index(s.base + nearest_node)].w / w.clay.mass);
    q.e = advance_b(q.e, q.C, w.dt);
    q.x = q.x + w.dt * q.v;
    std::uint32_t touched = 0;
    project(q, tools, all, 1, w.pushout, per_cell, w.dt, touched);
    confine(q, w.walls);
    yield(q, w.clay, w.dt);
    cloud.store(i, q);
}

// The cones of every substep: spheres that move evenly from frame to frame.
struct Cones {
    std::vector<Sphere<float>> spheres;
    std::vector<Shape<float>> shapes;
    std::vector<Primitive> primitives;
    std::vector<Tool<float>> tools;
    int sphere_count = 0;
};

Vec3<float> vector(const Json& j)
{
    return {j.at(0).get<float>(), j.at(1).get<float>(), j.at(2).get<float>()};
}

Cones cones_of(const Json& scene, float dt, int substeps)
{
    Cones c;
    for (const Json& t : scene.at("contact_mode"))
        c.tools.push_back({t.at("sticky").get<bool>() ? ContactMode::sticky : ContactMode::separate,
                           t.at("friction").get<float>(), false, true});
    for (const Json& pair : scene.at("cones")) {
        const int a = pair.at(0).get<int>(), b = pair.at(1).get<int>();
        c.primitives.push_back({2, {a, b, b}, int(c.primitives.size())});
    }
    const Json& poses = scene.at("spheres");
    c.sphere_count = int(poses.at(0).size());
    for (std::size_t f = 0; f + 1 < poses.size(); ++f)
        for (int k = 1; k <= substeps; ++k) {
            const std::size_t first = c.spheres.size();
            for (std::size_t s = 0; s < std::size_t(c.sphere_count); ++s) {
                const Vec3<float> from = vector(poses[f].at(s)), to = vector(poses[f + 1].at(s));
                const float share = float(k) / float(substeps);
                c.spheres.push_back({from + share * (to - from),
                                     (1 / (dt * float(substeps))) * (to - from),
                                     {0, 0, 0},
                                     poses[f].at(s).at(3).get<float>(),
                                     0});
            }
            for (const Primitive& p : c.primitives) {
                const Sphere<float>&a = c.spheres[first + std::size_t(p.sphere[0])],
                      &b = c.spheres[first + std::size_t(p.sphere[1])];
                c.shapes.push_back(shape(2, a, b, b));
            }
        }
    return c;
}

Material<float> clay_of(const Json& scene)
{
    Material<float> m{};
    m.elasticity = Elasticity::neo_hookean, m.plasticity = Plasticity::von_mises;
    m.mu = scene.at("mu").get<float>(), m.lambda = scene.at("lambda").get<float>();
    m.yield = scene.at("yield").get<float>(), m.yield_floor = m.yield;
    m.mass = scene.at("mass").get<float>(), m.volume = scene.at("volume").get<float>();
    m.density = m.mass / m.volume, m.exponent = 1;
    return m;
}

std::vector<float> seeded(const std::string& file, int count)
{
    std::ifstream in(file, std::ios::binary);
    std::vector<float> x(3 * std::size_t(count)), all(numbers * std::size_t(count));
    if (!in.read(reinterpret_cast<char*>(x.data()), long(x.size() * sizeof(float))))
        throw std::runtime_error(file + ": fewer positions than the scene has particles");
    for (std::size_t i = 0; i < std::size_t(count); ++i)
        for (std::size_t k = 0; k < 3; ++k) all[k * std::size_t(count) + i] = x[3 * i + k];
    return all;
}

double middle(std::vector<double> times, double share)
{
    if (times.empty()) return 0;
    std::sort(times.begin(), times.end());
    return times[std::size_t(share * double(times.size() - 1))];
}

class Simulation {
  public:
    Simulation(const Json& scene, const std::string& positions)
        : n(scene.at("nodes").get<int>()),
          count(scene.at("particles").get<int>()),
          substeps(scene.at("substeps").get<int>()),
          cones(cones_of(scene, scene.at("dt").get<float>(), substeps)),
          cloud(seeded(positions, count)),
          nodes(std::size_t(n) * std::size_t(n) * std::size_t(n)),
          spheres(cones.spheres),
          shapes(cones.shapes),
          primitives(cones.primitives),
          tools(cones.tools)
    {
        world.lattice = {{n, n, n}, scene.at("dx").get<float>()};
        world.walls = walls_on<float>(
            world.lattice,
            walls_inside(world.lattice, scene.at("margin").get<int>(), ContactMode::separate,
                         scene.at("wall_friction").get<double>()));
        world.gravity = vector(scene.at("gravity"));
        world.clay = clay_of(scene);
        world.dt = scene.at("dt").get<float>();
        const StepLimits limits{
            0.85, world.lattice.dx, stiffness(Particle<float>{}, world.clay), 0, 0, 0};
        world.pushout = cast<float>(pushout_limits(limits));
        world.nodes = nodes.data();
        for (std::size_t i = 0; i < cones.primitives.size(); ++i)
            all.bits[i / 32] |= 1u << (i % 32);
    }

    void frame(int f)
    {
        const Cloud q{cloud.data(), count};
        for (int k = 0; k < substeps; ++k) {
            const int at = f * substeps + k, cone_count = int(cones.primitives.size());
            const Colliders<float> c{{spheres.data() + at * cones.sphere_count, cones.sphere_count},
                                     {primitives.data(), cone_count},
                                     {shapes.data() + at * cone_count, cone_count},
                                     {tools.data(), int(cones.tools.size())}};
            check(cudaMemsetAsync(nodes.data(), 0, nodes.bytes()), "clear");
            gpu::launch("p2g", to_grid, gpu::blocks_for(count, threads), threads, nullptr, world,
                        q);
            gpu::launch("grid", on_grid, gpu::blocks_for(n * n * n, threads), threads, nullptr,
                        world, c, all);
            gpu::launch("g2p", to_particles, gpu::blocks_for(count, threads), threads, nullptr,
                        world, q, c, all);
        }
        check(cudaDeviceSynchronize(), "frame");
    }

    // Mean and standard deviation of the particles' places along each axis [m].
    Json places() const
    {
        const std::vector<float> now = cloud.downloaded();
        Json centre = Json::array(), extent = Json::array();
        for (std::size_t k = 0; k < 3; ++k) {
            double sum = 0, squares = 0;
            for (std::size_t i = 0; i < std::size_t(count); ++i) {
                const double from_middle = double(now[k * std::size_t(count) + i]) - 0.5;
                sum += from_middle / count, squares += from_middle * from_middle / count;
            }
            centre.push_back(sum + 0.5), extent.push_back(std::sqrt(squares - sum * sum));
        }
        return {{"centre", centre}, {"extent", extent}};
    }

    int n, count, substeps;

  private:
    Cones cones;
    DeviceArray<float> cloud;
    DeviceArray<float4> nodes;
    DeviceArray<Sphere<float>> spheres;
    DeviceArray<Shape<float>> shapes;
    DeviceArray<Primitive> primitives;
    DeviceArray<Tool<float>> tools;
    World world{};
    Mask all{};
};

void run(const std::string& scene_file, const std::string& positions)
{
    std::ifstream in(scene_file);
    const Json scene = Json::parse(in);
    Simulation clay(scene, positions);
    const int frames = scene.at("frames").get<int>(), warm = scene.at("warm_frames").get<int>();
    std::vector<double> times;
    for (int f = 0; f < frames; ++f) {
        const auto start = std::chrono::steady_clock::now();
        clay.frame(f);
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
        if (f >= warm) times.push_back(time.count() / clay.substeps);
    }
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, 0), "device");
    Json said = {{"peer", "plain CUDA"},
                 {"device", properties.name},
                 {"particles", clay.count},
                 {"frames", times.size()},
                 {"substep_us", 1e6 * middle(times, 0.5)},
                 {"p95_us", 1e6 * middle(times, 0.95)}};
    said.update(clay.places());
    std::printf("%s\n", said.dump().c_str());
}

}  // namespace
}  // namespace knead::peer

int main(int count, char** words)
{
    if (count != 3) {
        std::fprintf(stderr, "usage: peer_plain SCENE.json POSITIONS.f32\n");
        return 2;
    }
    try {
        knead::peer::run(words[1], words[2]);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "peer_plain: %s\n", e.what());
        return 4;
    }
}
