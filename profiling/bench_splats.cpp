// One case of `knead bench splats`, by itself and of any size: for a profiler, and to try a change.
// Fails where the device's picture is below 50 dB of the CPU's.
// usage: bench_splats [load=660k] [far|near45|near] [frames=200] [width=2064] [height=2208]
//        [check|nocheck|cpu] [still|moving] [fovea in degrees=0: none]
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "host/bench/splats.h"

namespace {

using namespace knead;

int run(const SplatCase& what, Device device)
{
    SplatCloud cloud = generated(what.load);
    sort_by_place(cloud);
    const BenchRow row = splat_row(what, cloud, device, 0);
    const DrawTimes& d = row.drawn;
    fmt::print("{}: {} splats, {} moved, {} seen, 2 x {} x {} pixels\n", row.name, cloud.count(),
               d.moved, d.visible, d.width, d.height);
    fmt::print("{} instances, {} dropped, {:.1f} MiB, at least {:.1f} MB a frame\n", d.instances,
               d.dropped, double(row.bytes) / 1048576,
               1e-6 * row.min_bytes * double(cloud.count()));
    fmt::print("hash {}\n", row.hash);
    fmt::print("median {:.1f} us, p95 {:.1f} us of {} frames\n", 1e6 * row.frame.median,
               1e6 * row.frame.p95, row.frames);
    double sum = 0;
    for (const StageTime& t : row.stages) {
        fmt::print("  {:<14} {:9.2f} us\n", t.name, 1e6 * t.seconds);
        sum += t.seconds;
    }
    if (!row.stages.empty()) fmt::print("  {:<14} {:9.2f} us\n", "sum", 1e6 * sum);
    if (d.psnr == 0) return 0;
    fmt::print("PSNR against the CPU: {:.2f} dB\n", d.psnr);
    return d.psnr >= 50 ? 0 : 1;
}

}  // namespace

int main(int count, char** words)
{
    const auto word = [&](int at, const char* otherwise) {
        return std::string(count > at ? words[at] : otherwise);
    };
    const std::string name = word(1, "660k"), check = word(6, "check"), motion = word(7, "still");
    SplatCase what;
    what.view = word(2, "far"), what.frames = std::atoi(word(3, "200").c_str());
    what.width = std::atoi(word(4, "2064").c_str());
    what.height = std::atoi(word(5, "2208").c_str());
    what.foveate = std::atof(word(8, "0").c_str());
    what.check = check == "check", what.moving = motion == "moving";
    const std::vector<SplatLoad>& loads = splat_loads();
    const auto load = std::find_if(loads.begin(), loads.end(),
                                   [&](const SplatLoad& l) { return l.name == name; });
    const auto among = [](const std::string& one, std::initializer_list<const char*> all) {
        return std::find(all.begin(), all.end(), one) != all.end();
    };
    if (load == loads.end() || !among(what.view, {"far", "near45", "near"}) ||
        !among(check, {"check", "nocheck", "cpu"}) || !among(motion, {"still", "moving"}) ||
        what.frames < 1 || what.frames > 100000 || what.width < 1 || what.width > 8192 ||
        what.height < 1 || what.height > 8192) {
        std::fprintf(stderr,
                     "usage: bench_splats [load] [far|near45|near] [frames] [width] "
                     "[height] [check|nocheck|cpu] [still|moving] [fovea]\nloads:");
        for (const SplatLoad& l : loads) std::fprintf(stderr, " %s", l.name.c_str());
        std::fprintf(stderr, "\n");
        return 2;
    }
    what.load = *load;
    try {
        return run(what, resolved(parse_device(check == "cpu" ? "cpu" : "cuda")));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 4;
    }
}
