// Keeping particles in order: a full sort, as sort.cu does it, against moving only those that
// left their block.
#include "profiling/micro/rebin.cuh"

namespace knead::micro {
namespace {

// Moves all particles along x; to and fro, so that they stay where they are on average.
__global__ void __launch_bounds__(threads)
    shift_kernel(float4* rows, const int* counts, int room, int all, float by)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i < all && (!counts || i % room < counts[i / room])) rows[i].x += by;
}

// Every id once, and every key no less than the one before.
bool in_order(const gpu::Views& views, int side, const std::function<int(Int3)>& key)
{
    const gpu::ParticleView from = views.particles[side];
    const auto n = std::size_t(from.count);
    std::vector<float4> rows(n);
    std::vector<int> ids(n);
    check(cudaMemcpy(rows.data(), from.rows, n * sizeof rows[0], cudaMemcpyDefault), "download");
    check(cudaMemcpy(ids.data(), from.ids, n * sizeof ids[0], cudaMemcpyDefault), "download");
    int before = 0;
    for (const float4& x : rows) {
        const int now = key(base_node(Vec3<float>{x.x, x.y, x.z}, views.lattice.dx));
        if (now < before) return false;
        before = now;
    }
    std::sort(ids.begin(), ids.end());
    for (std::size_t i = 0; i < n; ++i)
        if (ids[i] != int(i)) return false;
    return true;
}

// All of it: by counting, as cuda/mpm/sort.cu does usually, or stably.
void measure_sort(Bench& bench, int nodes, bool stably)
{
    Clay clay(nodes, Order::drifted, bench.stream, stably);
    const gpu::Views d = clay.views();
    const char* const what =
        stably ? "radix sort by cell, for equal bits, " : "counting sort by cell, as shipped, ";
    Row row{"rebin", what + std::to_string(nodes) + "^3", "particle"};
    row.count = clay.count();
    row.max = bench.by_copy(2 * 100), row.limit = "copy";
    int turns = 0, side = 0;  // which is current
    bench.add(
        row,
        [&] {
            side = clay.store().clock().side;
            const float by = (turns++ % 2 ? -0.2f : 0.2f) * d.lattice.dx;
            launch("shift", shift_kernel, blocks_for(clay.count(), threads), threads, bench.stream,
                   d.particles[side].rows, nullptr, 1, clay.count(), by);
        },
        [&] {
            gpu::sort_particles(d, clay.features(), clay.store().sort_space(), side, bench.stream);
            gpu::arrange(d, clay.features(), bench.stream);
        },
        [&] {
            return in_order(d, clay.store().clock().side,
                            [&d](Int3 base) { return d.lattice.index(base); });
        });
}

// The clay of a scene in bins.
class Binned {
  public:
    Binned(Bench& on, int nodes)
        : bench(on), setup(moving_ball(nodes, Order::drifted)), size(std::to_string(nodes) + "^3")
    {
        d.lattice = {setup.lattice.size, float(setup.lattice.dx)};
        number_blocks();
        const auto slots = std::size_t(d.bins) * bin_room, n = setup.particles.size();
        rows = DeviceArray<float4>(gpu::particle_rows * slots);
        ids = DeviceArray<int>(slots);
        leaving_rows = DeviceArray<float4>(gpu::particle_rows * n);
        leaving_ids = DeviceArray<int>(n);
        counters = DeviceArray<int>(2);
        d.particles = {rows.data(), ids.data(), int(slots)};
        d.leaving = {leaving_rows.data(), leaving_ids.data(), int(n)};
        d.left = counters.data(), d.crowded = counters.data() + 1;
        fill();
    }

    // `share` of the particles leave their blocks each time.
    void time(double share, const char* name)
    {
        Row row{"rebin", std::string("only movers between bins, ") + name + " move, " + size,
                "particle"};
        row.count = double(setup.particles.size());
        row.max = bench.by_copy(16 + share * 4 * 100), row.limit = "copy";
        const float by = float(4 * share) * d.lattice.dx;
        int turns = 0;
        double max_left = 0;
        bench.add(
            row,
            [&] {
                if (turns) max_left = std::max(max_left, double(counters.downloaded()[0]));
                const int slots = d.particles.count;
                launch("shift", shift_kernel, blocks_for(slots, threads), threads, bench.stream,
                       d.particles.rows, d.counts, bin_room, slots, turns++ % 2 ? -by : by);
            },
            [&] { rebin(d, bench.stream); },
            [&] {
                max_left = std::max(max_left, double(counters.downloaded()[0]));
                return max_left > 0.5 * share * row.count && max_left < 2 * share * row.count &&
                       in_bins();
            });
        char note[64];
        std::snprintf(note, sizeof note, "%.2f %% moved", 100 * max_left / row.count);
        bench.rows.back().note = note;
        if (turns % 2) {  // back to where they were
            const int slots = d.particles.count;
            launch("shift", shift_kernel, blocks_for(slots, threads), threads, bench.stream,
                   d.particles.rows, d.counts, bin_room, slots, -by);
            rebin(d, bench.stream);
            check(cudaStreamSynchronize(bench.stream), "rebin");
        }
    }

  private:
    Bench& bench;
    Setup setup;
    std::string size;
    BinView d{};
    DeviceArray<float4> rows, leaving_rows;
    DeviceArray<int> ids, leaving_ids, bin_of, counts, counters;

    // Blocks with clay and those around them, which it may move to.
    void number_blocks()
    {
        std::vector<int> bins(std::size_t(d.lattice.block_count()), -1);
        const Int3 edge = d.lattice.blocks();
        for (const Particle<double>& q : setup.particles) {
            const Int3 base = base_node(cast<float>(q.x), d.lattice.dx);
            for (int k = 0; k < 27; ++k) {
                const Int3 b{(base.x >> 2) + k % 3 - 1, (base.y >> 2) + k / 3 % 3 - 1,
                             (base.z >> 2) + k / 9 - 1};
                if (b.x < 0 || b.y < 0 || b.z < 0 || b.x >= edge.x || b.y >= edge.y ||
                    b.z >= edge.z)
                    continue;
                int& bin = bins[std::size_t(d.lattice.block_of(4 * b))];
                if (bin < 0) bin = d.bins++;
            }
        }
        bin_of = DeviceArray<int>(bins);
        d.bin_of = bin_of.data();
    }

    void fill()
    {
        std::vector<float4> host_rows(rows.size());
        std::vector<int> host_ids(ids.size()), host_counts(std::size_t(d.bins)),
            bins = bin_of.downloaded();
        const gpu::ParticleView to{host_rows.data(), host_ids.data(), int(ids.size())};
        for (std::size_t i = 0; i < setup.particles.size(); ++i) {
            const Particle<float> q = cast<float>(setup.particles[i]);
            const int block = d.lattice.block_of(base_node(q.x, d.lattice.dx));
            const int bin = bins[std::size_t(block)], slot = host_counts[std::size_t(bin)]++;
            if (slot >= bin_room) throw std::runtime_error("bench_micro: a bin is too small");
            to.store(bin * bin_room + slot, q);
            to.ids[bin * bin_room + slot] = int(i);
        }
        rows = DeviceArray<float4>(host_rows), ids = DeviceArray<int>(host_ids);
        counts = DeviceArray<int>(host_counts);
        d.particles = {rows.data(), ids.data(), int(ids.size())};
        d.counts = counts.data();
        check(cudaDeviceSynchronize(), "upload");
    }

    // Every particle is there once, in the bin of its block.
    bool in_bins() const
    {
        const std::vector<float4> host_rows = rows.downloaded();
        const std::vector<int> host_ids = ids.downloaded(), host_counts = counts.downloaded(),
                               bins = bin_of.downloaded();
        std::vector<char> seen(setup.particles.size());
        for (int b = 0; b < d.bins; ++b)
            for (int k = 0; k < host_counts[std::size_t(b)]; ++k) {
                const auto at = std::size_t(b) * bin_room + std::size_t(k);
                const float4& x = host_rows[at];
                const Int3 base = base_node(Vec3<float>{x.x, x.y, x.z}, d.lattice.dx);
                if (bins[std::size_t(d.lattice.block_of(base))] != b) return false;
                if (seen[std::size_t(host_ids[at])]++) return false;
            }
        const auto all = std::count(seen.begin(), seen.end(), 1);
        return std::size_t(all) == seen.size() && counters.downloaded()[1] == 0;
    }
};

}  // namespace

void measure_rebin(Bench& bench)
{
    for (int nodes : {64, 128}) {
        measure_sort(bench, nodes, true);
        measure_sort(bench, nodes, false);
        Binned binned(bench, nodes);
        binned.time(0.001, "0.1 %");
        binned.time(0.01, "1 %");
        binned.time(0.05, "5 %");
        binned.time(0.2, "20 %");
    }
}

}  // namespace knead::micro
