#include <cstring>

#include "profiling/micro/clay.cuh"

namespace knead::micro {
namespace {

// A turn about a slanted axis with some stretch, and a strain to match.
void set_moving(Particle<double>& q)
{
    const Mat3<double> C{{0.3, 0.8, -0.2}, {-0.7, -0.1, 0.4}, {0.3, -0.5, -0.2}};
    q.C = C;
    q.v = Vec3<double>{0.2, -0.1, 0.3} + C * (q.x - Vec3<double>{0.5, 0.5, 0.5});
    q.e = {0.01, -0.004, 0.003, 0.002, -0.001, 0.004};
}

}  // namespace

Setup moving_ball(int nodes, Order order, bool deterministic)
{
    Setup s = ball(nodes);
    s.deterministic = deterministic;
    const auto key = [&](const Particle<double>& q) {
        const int cell = s.lattice.index(base_node(q.x, s.lattice.dx));
        return order == Order::by_block ? cell / block_nodes : cell;
    };
    for (std::size_t i = s.particles.size(); i > 1 && order != Order::by_cell; --i)
        std::swap(s.particles[i - 1], s.particles[scrambled(unsigned(i)) % i]);
    if (order != Order::none)
        std::stable_sort(s.particles.begin(), s.particles.end(),
                         [&](const auto& a, const auto& b) { return key(a) < key(b); });
    const double dx = s.lattice.dx;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        Particle<double>& q = s.particles[i];
        const auto shift = [&](unsigned k) {
            return order == Order::drifted ? dx * (double(random(3 * unsigned(i) + k)) - 0.5) : 0.0;
        };
        q.x = q.x + Vec3<double>{shift(0), shift(1), shift(2)};
        set_moving(q);
    }
    return s;
}

Clay::Clay(int nodes, Order order, cudaStream_t stream, bool deterministic)
    : setup(moving_ball(nodes, order, deterministic)),
      memory(setup),
      seen(memory.views()),
      used(memory.features())
{
    memory.write_input(setup, {}, 1.0 / 90, 0);
    memory.send_input(0, stream);
    gpu::begin(seen, stream);
    check(cudaStreamSynchronize(stream), "begin");
    clock = memory.clock();
    step = float(clock.step(clock.done).dt);
    if (!(step > 0)) throw std::runtime_error("bench_micro: the clay takes no step");
}

void Clay::clear()
{
    memory.clear_grids();
    memory.set_clock(clock);
}

std::vector<float4> Clay::nodes() const
{
    std::vector<float4> host(std::size_t(seen.lattice.node_count()));
    check(cudaMemcpy(host.data(), seen.grid.nodes[parity()], host.size() * sizeof host[0],
                     cudaMemcpyDefault),
          "download");
    return host;
}

}  // namespace knead::micro
