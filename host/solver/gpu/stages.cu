// The stages, launched one by one on a separate store.
#include <cstring>
#include <numeric>

#include "host/solver/gpu/stages.h"
#include "host/solver/gpu/store.cuh"

namespace knead {

using namespace gpu;

namespace {

// The scene with one substep per frame.
Setup stepped(Setup setup, double dt)
{
    setup.step.fixed = dt;
    return setup;
}

}  // namespace

struct GpuStages::State {
    Setup setup;
    Store store;
    Features features;
    int processors = 0;

    State(const Setup& given, double dt)
        : setup(stepped(given, dt)), store(setup, whole_lattice), features(store.features())
    {
    }
    void done() const { wait(cudaStream_t(nullptr), "stage"); }
    // Marks every block as having mass, so that all uploaded nodes are processed.
    void touch_all() const
    {
        Clock clock = store.clock();
        std::vector<int> all(std::size_t(store.views().lattice.block_count()));
        std::iota(all.begin(), all.end(), 0);
        upload(store.box.list[0].data(), all.data(), all.size());
        clock.begun = clock.done;  // even: the first grid is current
        for (int k = 0; k < 2; ++k) clock.dt[k] = float(clock.step(clock.done + k).dt);
        for (int k = 0; k < 3; ++k)
            clock.active[(clock.done + k) % 3] = k == 0 ? int(all.size()) : 0;
        store.set_clock(clock);
    }
    void send(const std::vector<Node<float>>& nodes) const
    {
        static_assert(sizeof(Node<float>) == sizeof(float4));
        upload(store.box.nodes[0].data(), reinterpret_cast<const float4*>(nodes.data()),
               nodes.size());
    }
    std::vector<Node<float>> nodes(int parity) const
    {
        const std::vector<float4> rows = store.box.nodes[parity].downloaded();
        std::vector<Node<float>> out(rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i)
            out[i] = {{rows[i].x, rows[i].y, rows[i].z}, rows[i].w};
        return out;
    }
};

GpuStages::GpuStages(const Setup& setup, const Motion& motion, double dt)
{
    if (!gpu_present()) throw std::runtime_error("no CUDA device");
    state = std::make_unique<State>(setup, dt);
    int device = 0;
    check(cudaGetDevice(&device), "device");
    check(cudaDeviceGetAttribute(&state->processors, cudaDevAttrMultiProcessorCount, device),
          "device");
    state->store.write_input(state->setup, motion, dt, 0, 0);
    state->store.send_input(0, nullptr);
    begin(state->store.views(), nullptr);
    if (state->features.tools) {
        gpu::masks(state->store.views(), nullptr);
        pose(state->store.views(), nullptr);
        line_up(state->store.views(), state->features, nullptr);
    }
    state->done();
}

GpuStages::~GpuStages() = default;

std::vector<int> GpuStages::sort()
{
    const int side = state->store.clock().side;
    gpu::sort_particles(state->store.views(), state->features, state->store.sort_space(), side,
                        nullptr);
    gpu::arrange(state->store.views(), state->features, nullptr);
    state->done();
    return state->store.ids[state->store.clock().side].downloaded();
}

std::vector<Particle<double>> GpuStages::particles() { return state->store.particles(); }

std::vector<Node<float>> GpuStages::p2g()
{
    gpu::p2g(state->store.views(), state->features, state->processors, nullptr);
    state->done();
    if (!state->features.fixed_point) return state->nodes(0);
    const GridView& g = state->store.views().grid;
    const std::vector<long long> sums = state->store.box.sums[0].downloaded();
    std::vector<Node<float>> out(sums.size() / 4);
    const double p = 1 / double(g.momentum_scale), m = 1 / double(g.mass_scale);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const long long* s = &sums[4 * i];
        out[i] = {{float(p * double(s[0])), float(p * double(s[1])), float(p * double(s[2]))},
                  float(m * double(s[3]))};
    }
    return out;
}

std::vector<Node<float>> GpuStages::grid(const std::vector<Node<float>>& sums)
{
    state->send(sums);
    state->touch_all();
    Features plain = state->features;
    plain.fixed_point = false;
    gpu::grid(state->store.views(), plain, state->processors, nullptr);
    state->done();
    return state->nodes(0);
}

std::vector<Particle<double>> GpuStages::g2p(const std::vector<Node<float>>& velocities)
{
    state->send(velocities);
    state->touch_all();
    if (state->features.mean_pressure) find_pressures(state->store.views(), nullptr);
    gpu::g2p(state->store.views(), state->features, state->processors, nullptr);
    state->done();
    return state->store.particles();
}

std::vector<Mask> GpuStages::masks()
{
    std::vector<Mask> out(std::size_t(state->store.views().lattice.block_count()));
    if (state->features.tools)
        check(cudaMemcpy(out.data(), state->store.views().tools.masks, out.size() * sizeof(Mask),
                         cudaMemcpyDefault),
              "masks");
    return out;
}

std::vector<int> GpuStages::lined_up()
{
    const ToolView& t = state->store.views().tools;
    std::vector<int> out(std::size_t(t.run_count));
    check(cudaMemcpy(out.data(), t.runs, out.size() * sizeof(int), cudaMemcpyDefault), "runs");
    return out;
}

}  // namespace knead
