// Keeping particles in order: a full sort, by CUB's radix sort as cuda/sort.cu does it or by
// counting, against moving only those that left their block.
#include <cub/device/device_scan.cuh>

#include "rebin.cuh"

namespace knead::micro {
namespace {

constexpr int threads = 128;

// Moves all particles along x; to and fro, so that they stay where they are on average.
__global__ void __launch_bounds__(threads)
    shift_kernel(float4* rows, const int* counts, int room, int all, float by)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i < all && (!counts || i % room < counts[i / room])) rows[i].x += by;
}

__global__ void __launch_bounds__(threads)
    count_kernel(const __grid_constant__ gpu::Views d, int* cells, int* places)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const gpu::ParticleView& particles = d.particles[d.clock->side];
    if (i >= particles.count) return;
    const int cell = d.lattice.index(base_node(particles.position(i), d.lattice.dx));
    places[i] = atomicAdd(cells + cell, 1);
}

__global__ void __launch_bounds__(threads)
    place_kernel(const __grid_constant__ gpu::Views d, const int* starts, const int* places)
{
    const int i = int(blockIdx.x * threads + threadIdx.x), side = d.clock->side;
    const gpu::ParticleView &from = d.particles[side], &to = d.particles[side ^ 1];
    if (i >= from.count) return;
    const int cell = d.lattice.index(base_node(from.position(i), d.lattice.dx));
    const int at = starts[cell] + places[i];
    UNROLL
    for (int r = 0; r < gpu::particle_rows; ++r) to.row(r, at) = from.row(r, i);
    to.ids[at] = from.ids[i];
}

__global__ void flip_kernel(gpu::Clock* clock) { clock->side ^= 1; }

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

class Sorts {
  public:
    Sorts(Bench& on, int nodes)
        : bench(on),
          clay(nodes, Order::drifted, on.stream),
          size(std::to_string(nodes) + "^3"),
          cells(std::size_t(clay.views().lattice.node_count())),
          starts(cells.size()),
          places(std::size_t(clay.count()))
    {
        std::size_t bytes = 0;
        check(scan(nullptr, bytes), "scan");
        scratch = DeviceArray<unsigned char>(bytes);
    }

    void radix()
    {
        time("radix sort by cell, as shipped", [&] {
            gpu::order(d, clay.needs(), clay.store().sort_space(side), bench.stream);
            gpu::arrange(d, clay.needs(), bench.stream);
        });
    }
    // Last: it moves all rows at once, into a copy that takes the place of the other side.
    void counting()
    {
        const auto n = std::size_t(clay.count());
        copied_rows = DeviceArray<float4>(gpu::particle_rows * n);
        copied_ids = DeviceArray<int>(n);
        d.particles[clay.store().clock().side ^ 1] = {copied_rows.data(), copied_ids.data(),
                                                      clay.count()};
        time("counting sort by cell", [&] {
            const int n = clay.count(), blocks = blocks_for(n, threads);
            check(cudaMemsetAsync(cells.data(), 0, cells.bytes(), bench.stream), "sort");
            launch("count", count_kernel, blocks, threads, bench.stream, d, cells.data(),
                   places.data());
            std::size_t bytes = scratch.bytes();
            check(scan(scratch.data(), bytes), "scan");
            launch("place", place_kernel, blocks, threads, bench.stream, d, starts.data(),
                   places.data());
            launch("flip", flip_kernel, 1, 1, bench.stream, d.clock);
        });
    }

  private:
    Bench& bench;
    Clay clay;
    gpu::Views d = clay.views();
    std::string size;
    DeviceArray<float4> copied_rows;
    DeviceArray<int> cells, starts, places, copied_ids;
    DeviceArray<unsigned char> scratch;
    int turns = 0, side = 0;  // which is current

    cudaError_t scan(void* space, std::size_t& bytes) const
    {
        return cub::DeviceScan::ExclusiveSum(space, bytes, cells.data(), starts.data(),
                                             int(cells.size()), bench.stream);
    }

    void time(const char* what, const std::function<void()>& run)
    {
        Row row{"rebin", std::string(what) + ", " + size, "particle"};
        row.count = clay.count();
        row.most = bench.by_copy(2 * 100), row.limit = "copy";
        const auto prepare = [&] {
            side = clay.store().clock().side;
            const float by = (turns++ % 2 ? -0.2f : 0.2f) * clay.views().lattice.dx;
            launch("shift", shift_kernel, blocks_for(clay.count(), threads), threads, bench.stream,
                   d.particles[side].rows, nullptr, 1, clay.count(), by);
        };
        bench.add(row, prepare, run, [&] {
            const Lattice<float> lattice = d.lattice;
            return in_order(d, clay.store().clock().side,
                            [lattice](Int3 base) { return lattice.index(base); });
        });
    }
};

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
        row.most = bench.by_copy(16 + share * 4 * 100), row.limit = "copy";
        const float by = float(4 * share) * d.lattice.dx;
        int turns = 0;
        double most_left = 0;
        bench.add(
            row,
            [&] {
                if (turns) most_left = std::max(most_left, double(counters.downloaded()[0]));
                const int slots = d.particles.count;
                launch("shift", shift_kernel, blocks_for(slots, threads), threads, bench.stream,
                       d.particles.rows, d.counts, bin_room, slots, turns++ % 2 ? -by : by);
            },
            [&] { rebin(d, bench.stream); },
            [&] {
                most_left = std::max(most_left, double(counters.downloaded()[0]));
                return most_left > 0.5 * share * row.count && most_left < 2 * share * row.count &&
                       in_bins();
            });
        char note[64];
        std::snprintf(note, sizeof note, "%.2f %% moved", 100 * most_left / row.count);
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
        Sorts sorts(bench, nodes);
        sorts.radix();
        sorts.counting();
        Binned binned(bench, nodes);
        binned.time(0.001, "0.1 %");
        binned.time(0.01, "1 %");
        binned.time(0.05, "5 %");
        binned.time(0.2, "20 %");
    }
}

}  // namespace knead::micro
