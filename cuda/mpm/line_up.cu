// Order of a frame's runs of particles. Runs near tools come first: started last, they would delay
// the end of the kernel. The other runs are taken alternately from both ends of their order, so
// that the runs in the middle, where approaching tools arrive last, come last.
#include <cub/block/block_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/mpm/project.cuh"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128, scan_threads = 1024;

// Which runs are near tools. A warp per run.
template <class Case>
__global__ void __launch_bounds__(threads) near_runs_kernel(const __grid_constant__ LineUpView d)
{
    constexpr int run_size = run_length(Case::features);
    const Clock& clock = *d.clock;
    const int run = int(blockIdx.x * threads + threadIdx.x) / 32, lane = int(threadIdx.x & 31);
    if (!clock.begins || run >= d.run_count) return;
    const ConstParticleView& particles = d.particles[clock.side];
    bool near = false;
    UNROLL
    for (int k = lane; k < run_size; k += 32) {
        const int i = min(run * run_size + k, particles.count - 1);
        near = near_tools(d.near, d.lattice, particles.position(i)) || near;
    }
    near = __any_sync(all_lanes, near);
    if (lane == 0) d.near_runs[run] = near;
}

// By one thread block; each thread has a contiguous range of runs.
__global__ void __launch_bounds__(scan_threads) line_up_kernel(const __grid_constant__ LineUpView d)
{
    using Scan = cub::BlockScan<int, scan_threads>;
    __shared__ Scan::TempStorage space;
    const int share = (d.run_count + scan_threads - 1) / scan_threads;
    const int first = min(int(threadIdx.x) * share, d.run_count);
    const int last = min(first + share, d.run_count);
    int nears = 0, all_nears = 0;
    for (int run = first; run < last; ++run) nears += d.near_runs[run];
    Scan(space).ExclusiveSum(nears, nears, all_nears);
    const int fars = d.run_count - all_nears;
    for (int run = first; run < last; ++run) {
        const int before = run - nears, after = fars - 1 - before;  // far runs only
        const int place = all_nears + (before <= after ? 2 * before : 2 * after + 1);
        d.runs[d.near_runs[run] ? nears++ : place] = run;
    }
}

constexpr Features relevant(Features f) { return {.blades = f.blades}; }

}  // namespace

void line_up(const Views& views, const Features& features, cudaStream_t stream)
{
    if (features.rests) return;
    const auto find =
        dispatch<relevant>(features, []<class Case>(Case) { return near_runs_kernel<Case>; });
    const LineUpView view = line_up_view(views);
    launch("near runs", find, blocks_for(view.run_count, threads / 32), threads, stream, view);
    launch("line up", line_up_kernel, 1, scan_threads, stream, view);
}

}  // namespace knead::gpu
