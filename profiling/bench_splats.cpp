// Time per stereo frame of a generated scene of splats on the device: of a graph of the whole, and
// of each stage; with what was drawn: counts, bytes, a hash, and how far it is from the CPU's
// picture, to see whether a change of speed changed the result. Fails below 50 dB.
// usage: bench_splats [load=660k] [far|near45|near] [frames=200] [width=2064] [height=2208]
//        [check|nocheck|cpu]
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "host/splats/generate.h"
#include "host/splats/gpu_raster.h"

namespace {

using namespace knead;

// FNV-1a over the bits of the pictures.
std::uint64_t hash_of(const std::vector<Picture>& pictures)
{
    std::uint64_t h = 14695981039346656037ull;
    const auto mix = [&h](float x) {
        h = (h ^ std::bit_cast<std::uint32_t>(x)) * 1099511628211ull;
    };
    for (const Picture& p : pictures)
        for (std::size_t i = 0; i < p.pixels(); ++i)
            for (const float x : {p.colour[i].x, p.colour[i].y, p.colour[i].z, p.depth[i]}) mix(x);
    return h;
}

double seconds_since(std::chrono::steady_clock::time_point then)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

std::vector<Picture> on_cpu(const SplatCloud& cloud, const SplatFrame& frame)
{
    const auto then = std::chrono::steady_clock::now();
    std::vector<Picture> pictures = cpu_raster(cloud, frame);
    fmt::print("CPU: {:.3f} s for both eyes\n", seconds_since(then));
    return pictures;
}

// What must be moved at least [bytes]: splats in, what is seen in and out, instances through two
// passes of a sort, pictures out.
double floor_bytes(const SplatCloud& cloud, const RasterStats& s, const SplatFrame& f)
{
    const double pixels = double(f.eyes[0].width) * f.eyes[0].height * double(f.eyes.size());
    const double splat = 48, seen = 6.0 * harmonics(cloud.degree) + 48 * double(f.eyes.size());
    return double(cloud.count()) * (splat + 3 * 16) + double(s.visible) * seen +
           double(s.instances) * (6 + 2 * 12 + 2) + pixels * 12;
}

int run(const SplatLoad& load, const std::string& view, int frames, int width, int height,
        const std::string& check)
{
    SplatCloud cloud = generated(load);
    sort_by_place(cloud);
    SplatFrame frame;
    frame.eyes = load_eyes(view, width, height);
    if (check == "cpu") {
        fmt::print("{} {}: hash {:016x}\n", load.name, view, hash_of(on_cpu(cloud, frame)));
        return 0;
    }
    GpuRaster raster(cloud);
    const std::vector<Picture> pictures = raster.pictures(frame);
    const RasterStats stats = raster.stats();
    fmt::print("{} {}: {} splats, {} seen, 2 x {} x {} pixels\n", load.name, view, cloud.count(),
               stats.visible, width, height);
    fmt::print("{} instances, {} dropped, room for {}, {:.1f} MiB, at least {:.1f} MB a frame\n",
               stats.instances, stats.dropped, raster.room(), double(raster.memory()) / 1048576,
               1e-6 * floor_bytes(cloud, stats, frame));
    fmt::print("hash {:016x}\n", hash_of(pictures));
    raster.replays(10);
    std::vector<double> seconds = raster.replays(frames);
    std::sort(seconds.begin(), seconds.end());
    fmt::print("median {:.1f} us, p95 {:.1f} us, best {:.1f} us of {} frames\n",
               1e6 * seconds[seconds.size() / 2], 1e6 * seconds[seconds.size() * 95 / 100],
               1e6 * seconds.front(), seconds.size());
    double sum = 0;
    for (const StageTime& t : raster.stage_times()) {
        fmt::print("  {:<14} {:9.2f} us\n", t.name, 1e6 * t.seconds);
        sum += t.seconds;
    }
    fmt::print("  {:<14} {:9.2f} us\n", "sum", 1e6 * sum);
    if (check == "nocheck") return 0;
    const std::vector<Picture> host = on_cpu(cloud, frame);
    double worst = 200;
    for (std::size_t e = 0; e < host.size(); ++e)
        worst = std::min(worst, psnr(pictures[e], host[e]));
    fmt::print("PSNR against the CPU: {:.2f} dB\n", worst);
    return worst >= 50 ? 0 : 1;
}

}  // namespace

int main(int count, char** words)
{
    const auto word = [&](int at, const char* otherwise) {
        return std::string(count > at ? words[at] : otherwise);
    };
    const std::string name = word(1, "660k"), view = word(2, "far"), check = word(6, "check");
    const int frames = std::atoi(word(3, "200").c_str()),
              width = std::atoi(word(4, "2064").c_str()),
              height = std::atoi(word(5, "2208").c_str());
    const std::vector<SplatLoad>& loads = splat_loads();
    const auto load = std::find_if(loads.begin(), loads.end(),
                                   [&](const SplatLoad& l) { return l.name == name; });
    const bool known = (view == "far" || view == "near45" || view == "near") &&
                       (check == "check" || check == "nocheck" || check == "cpu");
    if (load == loads.end() || !known || frames < 1 || frames > 100000 || width < 1 ||
        width > 8192 || height < 1 || height > 8192) {
        std::fprintf(stderr,
                     "usage: bench_splats [load] [far|near45|near] [frames] [width] "
                     "[height] [check|nocheck|cpu]\nloads:");
        for (const SplatLoad& l : loads) std::fprintf(stderr, " %s", l.name.c_str());
        std::fprintf(stderr, "\n");
        return 2;
    }
    try {
        return run(*load, view, frames, width, height, check);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 4;
    }
}
