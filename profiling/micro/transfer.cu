// Transfers with the sums over 27 nodes written plainly, against the factorised ones of
// cuda/mpm/g2p.h and cuda/mpm/p2g.h.
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/gather.cuh"
#include "cuda/mpm/p2g.h"
#include "profiling/micro/clay.cuh"

namespace knead::micro {
namespace {

using gpu::Views;

// What a gather or a scatter left of each particle.
struct Out {
    float4 *first, *second, *third;  // count each
};

// v = A x + b on all nodes: what a gather must find again.
HD Mat3<float> field_gradient()
{
    return {{0.3f, 0.8f, -0.2f}, {-0.7f, -0.1f, 0.4f}, {0.3f, -0.5f, -0.2f}};
}
HD Vec3<float> field(Vec3<float> x)
{
    return field_gradient() * (x - Vec3<float>{0.5f, 0.5f, 0.5f}) + Vec3<float>{0.2f, -0.1f, 0.3f};
}

__global__ void __launch_bounds__(threads) field_kernel(const __grid_constant__ Views d, int parity)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.lattice.node_count()) return;
    const Vec3<float> v = field(d.lattice.position(d.lattice.node_at(i)));
    d.grid.nodes[parity][i] = {v.x, v.y, v.z, 1};
}

// The gather as the equations have it: each node by itself.
template <class Velocity>
__device__ void gather_plainly(Particle<float>& q, const Stencil<float>& s, float dx,
                               Velocity&& velocity)
{
    Vec3<float> v{};
    Mat3<float> B{};
    for_each_node(s, dx, [&](Int3 step, float w, Vec3<float> from_particle) {
        const Vec3<float> at = w * velocity(step);
        v = v + at;
        B = B + outer(at, from_particle);
    });
    q.v = v;
    q.C = (4 / (dx * dx)) * B;
}

// Likewise the scatter.
template <class Add>
__device__ void scatter_plainly(const Particle<float>& q, const Material<float>& m,
                                const Stencil<float>& s, float dx, float dt, Add&& add)
{
    const Mat3<float> Q = momentum_gradient(q.C, kirchhoff_stress(q, m), m.mass, m.volume, dx, dt);
    for_each_node(s, dx, [&](Int3 step, float w, Vec3<float> from_particle) {
        add(step, Node<float>{w * (m.mass * q.v + Q * from_particle), w * m.mass});
    });
}

template <bool factorised>
__global__ void __launch_bounds__(threads)
    gather_kernel(const __grid_constant__ Views d, int parity, Out out)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const gpu::ParticleView& particles = d.particles[d.clock->side];
    if (i >= particles.count) return;
    Particle<float> q{};
    q.x = particles.position(i);
    const float dx = d.lattice.dx;
    const Stencil<float> s = stencil(q.x, dx);
    const gpu::Offsets o = gpu::offsets(d.lattice, s.base);
    const auto velocity = [&](Int3 step) {
        if (step.y == 0 && step.z == 0) asm volatile("" ::: "memory");  // as g2p: a plane at a time
        const float4 v = (d.grid.nodes[parity] + o.column(step))[step.z * Lattice<float>::along_z];
        return Vec3<float>{v.x, v.y, v.z};
    };
    if constexpr (factorised)
        gather(q, s, dx, velocity);
    else
        gather_plainly(q, s, dx, velocity);
    out.first[i] = {q.v.x, q.v.y, q.v.z, q.C.a.x};
    out.second[i] = {q.C.a.y, q.C.a.z, q.C.b.x, q.C.b.y};
    out.third[i] = {q.C.b.z, q.C.c.x, q.C.c.y, q.C.c.z};
}

// Shares are added up where they are, so that only arithmetic is timed: all of them, which is the
// particle's momentum and mass, and those of the plane z = 2, so that no sum can be foreseen.
template <bool factorised>
__global__ void __launch_bounds__(threads)
    scatter_kernel(const __grid_constant__ Views d, float dt, Out out)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const gpu::ParticleView& particles = d.particles[d.clock->side];
    if (i >= particles.count) return;
    const Particle<float> q = particles.load(i);
    Material<float> m = d.materials[q.object];
    m.elasticity = Elasticity::neo_hookean, m.plasticity = Plasticity::none;
    const float dx = d.lattice.dx;
    const Stencil<float> s = stencil(q.x, dx);
    float4 all{0, 0, 0, 0}, plane{0, 0, 0, 0};
    const auto plus = [](float4& sum, const Node<float>& n) {
        sum = {sum.x + n.p.x, sum.y + n.p.y, sum.z + n.p.z, sum.w + n.m};
    };
    const auto add = [&](Int3 step, const Node<float>& n) {
        plus(all, n);
        if (step.z == 2) plus(plane, n);
    };
    if constexpr (factorised)
        scatter(q, m, s, dx, dt, add);
    else
        scatter_plainly(q, m, s, dx, dt, add);
    out.first[i] = all;
    out.second[i] = plane;
}

class Transfers {
  public:
    Transfers(Bench& on, int nodes)
        : bench(on), clay(nodes, Order::by_cell, on.stream), size(std::to_string(nodes) + "^3")
    {
        for (auto& array : out) array = DeviceArray<float4>(std::size_t(clay.count()));
        const int cells = clay.views().lattice.node_count();
        launch("field", field_kernel, blocks_for(cells, threads), threads, bench.stream,
               clay.views(), clay.parity());
        check(cudaStreamSynchronize(bench.stream), "field");
    }

    void gathers()
    {
        for (const bool factorised : {false, true})
            time(std::string("gather, ") + (factorised ? "factorised" : "plain"), 64,
                 factorised ? gather_kernel<true> : gather_kernel<false>, clay.parity(),
                 [&] { return gathered(); });
    }
    void scatters()
    {
        for (const bool factorised : {false, true})
            time(std::string("scatter without memory, ") + (factorised ? "factorised" : "plain"),
                 128, factorised ? scatter_kernel<true> : scatter_kernel<false>, clay.dt(),
                 [&] { return scattered(); });
    }

  private:
    Bench& bench;
    Clay clay;
    std::string size;
    DeviceArray<float4> out[3];

    template <class Argument>
    void time(const std::string& what, double bytes, void (*kernel)(Views, Argument, Out),
              Argument argument, const std::function<bool()>& right)
    {
        must_not_spill(what.c_str(), kernel);
        Row row{"transfer", what + ", " + size, "particle"};
        row.count = clay.count();
        row.max = bench.by_copy(bytes), row.limit = "copy";
        bench.add(
            row, [] {},
            [&] {
                launch("transfer", kernel, blocks_for(clay.count(), threads), threads, bench.stream,
                       clay.views(), argument, Out{out[0].data(), out[1].data(), out[2].data()});
            },
            right);
    }

    // Velocity and gradient of the field, everywhere.
    bool gathered() const
    {
        const std::vector<float4> a = out[0].downloaded(), b = out[1].downloaded(),
                                  c = out[2].downloaded();
        const gpu::ParticleView particles = clay.views().particles[0];
        std::vector<float4> rows(std::size_t(particles.count));
        check(cudaMemcpy(rows.data(), particles.rows, rows.size() * sizeof rows[0],
                         cudaMemcpyDefault),
              "download");
        const Mat3<float> A = field_gradient();
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Vec3<float> v = field({rows[i].x, rows[i].y, rows[i].z});
            const Vec3<float> off = v - Vec3<float>{a[i].x, a[i].y, a[i].z};
            const Mat3<float> rest = A - Mat3<float>{{a[i].w, b[i].x, b[i].y},
                                                     {b[i].z, b[i].w, c[i].x},
                                                     {c[i].y, c[i].z, c[i].w}};
            const float gradient = dot(rest.a, rest.a) + dot(rest.b, rest.b) + dot(rest.c, rest.c);
            if (!(dot(off, off) < 1e-10f) || !(gradient < 1e-6f)) return false;
        }
        return true;
    }

    // All shares together are the particle's mass and momentum; and the two forms agree on a plane.
    bool scattered()
    {
        const std::vector<float4> all = out[0].downloaded(), plane = out[1].downloaded();
        const std::vector<Particle<double>> q = clay.store().particles();
        const double m = clay.mass() / clay.count();
        if (first_plane.empty()) first_plane = plane;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const Vec3<double> p{all[i].x, all[i].y, all[i].z};
            const Vec3<double> off = p - m * q[i].v;
            const float4 &u = plane[i], &v = first_plane[i];
            const Vec3<float> apart{u.x - v.x, u.y - v.y, u.z - v.z};
            if (!(std::fabs(double(all[i].w) / m - 1) < 1e-5) || !(length(off) < 1e-4 * m) ||
                !(length(apart) < 1e-4f * float(m)))
                return false;
        }
        return true;
    }
    std::vector<float4> first_plane;
};

}  // namespace

void measure_transfer(Bench& bench)
{
    for (int nodes : {64, 128}) {
        Transfers transfers(bench, nodes);
        transfers.gathers();
        transfers.scatters();
    }
}

}  // namespace knead::micro
