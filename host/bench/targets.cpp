// The table of targets: what a squeeze must cost on the card the targets were set for (an H200).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/bench/bench.h"
#include "host/session/session.h"

namespace knead {
namespace {

// The best public elastoplastic code on an H200, rebinning included: seconds per substep at 137 k,
// 1.1 M and 8.8 M particles. Measured there in 2026-11: claymore 3b19462 and CK-MPM 38bff16.
constexpr double public_best[] = {356e-6, 780e-6, 3922e-6};

Target max(const char* name, const char* unit, double must, double aim)
{
    return {name, unit, must, aim, false, -1, ""};
}
Target min(const char* name, const char* unit, double must, double aim)
{
    return {name, unit, must, aim, true, -1, ""};
}

std::string timed(const BenchRow& row)
{
    std::string text = fmt::format("{} frames, {} in contact, p95 {:.3g} us a substep", row.frames,
                                   row.apply_contact, 1e6 * row.substep.p95);
    const long guards = row.clipped + row.confined + row.repaired;
    if (guards > 0) text += fmt::format(", GUARDS {} ", guards);
    return text + (row.note.empty() ? "" : "; " + row.note);
}

Target measured(Target t, double value, const std::string& note)
{
    t.measured = value, t.note = note;
    return t;
}

// The frame of the paper: 5 substeps, a surface of 128^3 nodes, 5 passes of smoothing.
QueuedFrames paper_frame(Bench& bench)
{
    bench.say("target: frames of 5 substeps and a surface");
    const Scene scene =
        bench.scene({"clock=paper", "paper.substeps=5", "surface.smoothing=laplace"});
    const HandSource hands(hands_of(scene), scene.hands);
    return queued(scene, bench.device, &hands, std::max(0, first_touch(scene, hands)),
                  bench.options.quick ? 6 : 120, true);
}

// The same clay as a ball of 0.1 m between real hands, 3.1 mm cells.
BenchRow hand_scale(Bench& bench)
{
    Drive how;
    how.frames = bench.options.quick ? 4 : 0, how.repeats = bench.options.quick ? 1 : 2;
    how.limit = bench.options.case_limit;
    const std::string at = fmt::format("[0.1,{:.9g},0.1]", 3 * 0.2 / 64 + 0.05);
    std::vector<std::string> settings = walls_on_cells(0.2, 64);
    for (const std::string& s :
         {std::string("domain.edge=0.2"), std::string("objects.0.diameter=0.1"),
          std::string("hands.zoom=1"), "objects.0.centre=" + at, "hands.at=" + at})
        settings.push_back(s);
    return bench.measured("target: hand scale", bench.scene(settings), how);
}

void size_targets(Bench& bench)
{
    const BenchRow small = bench.squeeze(64);
    auto& all = bench.result.targets;
    all.push_back(measured(max("137 k particles, 64^3, per substep", "us", 20, 12),
                           1e6 * small.substep.median, timed(small)));
    const QueuedFrames frame = paper_frame(bench);
    all.push_back(
        measured(max("frame: 5 substeps, density 128^3, march, 5 smoothings", "ms", 0.35, 0.2),
                 frame.frames > 0 ? 1e3 * frame.frame : -1,
                 fmt::format("mean of {} frames, handed over one ahead", frame.frames)));
    all.push_back(
        measured(max("times the host waits for the device in a frame", "", 0, 0),
                 frame.frames > 0 && bench.device.kind == DeviceKind::cuda ? frame.waits : -1,
                 "in the same frames, between handing one over and its end"));
    all.push_back(measured(max("real time: all substeps of 11.1 ms", "ms", 1.5, 0.9),
                           1e3 * small.frame.median,
                           fmt::format("{:.0f} substeps", small.substeps)));
    const BenchRow real = hand_scale(bench);
    all.push_back(measured(max("hand scale: 0.1 m ball, dx 3.1 mm, 11.1 ms", "ms", 6, 4),
                           1e3 * real.frame.median,
                           fmt::format("{:.0f} substeps; {}", real.substeps, timed(real))));
    const double must[] = {17, 5.5, 4.4}, aim[] = {30, 8.5, 6.7};
    const char* const names[] = {"against the best public code, 137 k",
                                 "against the best public code, 1.1 M",
                                 "against the best public code, 8.8 M"};
    std::vector<BenchRow> sizes{small};
    for (int cells : {128, 256}) {
        const Target rate = cells == 128 ? min("1.1 M particles", "G/s", 8, 12)
                                         : min("8.8 M particles", "G/s", 10, 15);
        const double count = 0.5236 * cells * cells * cells;
        const bool large = bench.options.quick || bench.device.kind != DeviceKind::cuda;
        if (bench.stopped() || (large && cells > 128) ||
            !bench.fits(rate.name, count, 600,
                        1.1 * double(small.bytes) / double(small.particles))) {
            all.push_back(measured(rate, -1, large ? "left out: --quick, or a CPU" : "no memory"));
            continue;
        }
        sizes.push_back(bench.squeeze(cells));
        all.push_back(measured(rate, 1e-9 * sizes.back().rate(), timed(sizes.back())));
    }
    const BenchRow& last = sizes.back();
    all.push_back(measured(max("memory per particle, all buffers", "B", 160, 110),
                           double(last.bytes) / double(last.particles),
                           fmt::format("at {:.3g} particles", double(last.particles))));
    for (std::size_t k = 0; k < 3; ++k)
        all.push_back(
            measured(min(names[k], "x", must[k], aim[k]),
                     k < sizes.size() ? public_best[k] / sizes[k].substep.median : -1,
                     fmt::format("theirs {:.0f} us, measured on an H200", 1e6 * public_best[k])));
}

void localized_target(Bench& bench)
{
    const auto first = [&] {
        return std::find_if(bench.result.rows.begin(), bench.result.rows.end(),
                            [](const BenchRow& r) { return r.suite == "localized"; });
    };
    if (first() == bench.result.rows.end()) localized_suite(bench);
    if (bench.stopped() || bench.result.rows.end() - first() < 3) return;
    const BenchRow &near = *first(), &all = *(first() + 1), &held = *(first() + 2);
    bench.result.targets.push_back(
        measured(max("2 M particles, 5 % near hands, against these alone", "x", 1.5, 1.2),
                 all.frame.median / near.frame.median,
                 fmt::format("{:.3g} against {:.3g} particles, the rest asleep; {:.3g} where it is "
                             "held still (localized)",
                             double(all.particles), double(near.particles),
                             held.frame.median / near.frame.median)));
}

void peer_target(Bench& bench)
{
    Target t = min("against our Taichi peer, per substep", "x", 12, 25);
    t.note = "not run: --peers runs it";
    for (const PeerRow& p : bench.result.peers) {
        if (p.name != "taichi") continue;
        t.note = p.problem.empty() ? fmt::format("theirs {:.1f} us, ours {:.1f} us on its scene",
                                                 1e6 * p.substep, 1e6 * p.ours)
                                   : p.problem;
        if (p.problem.empty() && p.ours > 0) t.measured = p.substep / p.ours;
    }
    bench.result.targets.push_back(t);
}

// What a card of the RTX 4090's class might take for the small squeeze: between the ratio of issue
// rates (128 multiprocessors at 2.52 GHz) and that of bandwidths (1008 GB/s, of which a copy gets
// about nine tenths). Which of them holds depends on how much stays in its 72 MB of cache.
void estimate(Bench& bench)
{
    const double clock = gpu_clock();
    if (bench.facts.multiprocessors == 0 || clock <= 0) return;
    const BenchRow& small = bench.squeeze(64);
    const double here = bench.facts.multiprocessors * clock, there = 128 * 2.52e9;
    const double low = small.substep.median * here / there;
    const double high = small.substep.median * bench.facts.copy / (0.9 * 1008e9);
    bench.result.targets.push_back(
        {"ESTIMATE for a card like the RTX 4090, 137 k, per substep", "us", 0, 0, false, -1,
         fmt::format("{:.3g} us if instructions bound it, {:.3g} us if memory does; not measured",
                     1e6 * low, 1e6 * high),
         true});
}

}  // namespace

Met met(const Target& t)
{
    if (t.measured < 0 || (t.must == 0 && t.aim == 0 && t.min)) return Met::open;
    const auto holds = [&](double bound) {
        return t.min ? t.measured >= bound : t.measured <= bound;
    };
    return holds(t.aim) ? Met::aim : holds(t.must) ? Met::must : Met::missed;
}

const char* met_name(Met m)
{
    return m == Met::aim ? "aim" : m == Met::must ? "must" : m == Met::missed ? "MISSED" : "open";
}

void targets_suite(Bench& bench)
{
    size_targets(bench);
    if (!bench.stopped()) localized_target(bench);
    peer_target(bench);
    if (!bench.stopped()) estimate(bench);
}

}  // namespace knead
