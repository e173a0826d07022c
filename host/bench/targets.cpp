// The table of targets: measurements for those in targets.json.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/bench/bench.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/solver/frame_stats.h"

namespace knead {
namespace {

// Adds the target of `key` with the measured value; negative: not measured.
void add(Bench& bench, const std::string& key, double value, const std::string& note)
{
    const auto& all = bench.figures.targets->targets;
    const auto at = all.find(key);
    if (at == all.end()) {
        bench.result.left_out.push_back("target \"" + key + "\": not in " + bench.figures.folder +
                                        "/targets.json");
        return;
    }
    Target t = at->second;
    t.measured = value, t.note = note;
    bench.result.targets.push_back(t);
}

std::string timed(const BenchRow& row)
{
    std::string text = fmt::format("{} frames, {} in contact, p95 {:.3g} us a substep", row.frames,
                                   row.in_contact, 1e6 * row.substep.p95);
    if (const long guards = guards_of(row.acted) + row.crowded; guards > 0)
        text += fmt::format(", GUARDS {} ", guards);
    return text + (row.note.empty() ? "" : "; " + row.note);
}

// The frame of the paper: 5 substeps, a surface of 128^3 nodes, 5 passes of smoothing.
QueuedFrames paper_frame(Bench& bench)
{
    bench.say("target: frames of 5 substeps and a surface");
    const Scene scene =
        bench.scene({"clock=paper", "paper.substeps=5", "surface.smoothing=laplace"});
    const HandSource hands(hands_of(scene), scene.hands);
    return queued(scene, bench.device, &hands, std::max(0, first_contact(scene, hands)),
                  bench.options.quick ? 6 : 120, true);
}

// The same clay as a ball of 0.1 m between hands of natural size, 3.1 mm cells.
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

void frame_targets(Bench& bench, const BenchRow& small)
{
    add(bench, "substep 137 k", 1e6 * small.substep.median, timed(small));
    const QueuedFrames frame = paper_frame(bench);
    add(bench, "paper frame", frame.frames > 0 ? 1e3 * frame.frame : -1,
        fmt::format("mean of {} frames, handed over one ahead", frame.frames));
    add(bench, "host waits",
        frame.frames > 0 && bench.device.kind == DeviceKind::cuda ? frame.waits : -1,
        "in the same frames, between handing one over and its end");
    add(bench, "real time", 1e3 * small.frame.median,
        fmt::format("{:.0f} substeps", small.substeps));
    const BenchRow real = hand_scale(bench);
    add(bench, "hand scale", 1e3 * real.frame.median,
        fmt::format("{:.0f} substeps; {}", real.substeps, timed(real)));
}

// Compares with the best public code at the same size.
void public_target(Bench& bench, const std::string& size, const BenchRow* ours)
{
    if (!bench.figures.peers) return;
    const PeerFigures& peers = *bench.figures.peers;
    const auto at = peers.public_best.find(size);
    if (at == peers.public_best.end())
        return add(bench, "public " + size, -1, "no figure of theirs");
    const bool timed_ours = ours && ours->substep.median > 0;
    add(bench, "public " + size, timed_ours ? at->second / ours->substep.median : -1,
        fmt::format("theirs {:.0f} us, measured on {}", 1e6 * at->second, peers.device));
}

void size_targets(Bench& bench)
{
    const BenchRow small = bench.squeeze(64);
    frame_targets(bench, small);
    std::vector<BenchRow> sizes{small};
    for (int cells : {128, 256}) {
        const std::string rate = cells == 128 ? "rate 1.1 M" : "rate 8.8 M";
        const double count = 0.5236 * cells * cells * cells;
        const bool large = bench.options.quick || bench.device.kind != DeviceKind::cuda;
        if (bench.stopped() || (large && cells > 128) ||
            !bench.fits(rate, count, 600, 1.1 * double(small.bytes) / double(small.particles))) {
            const std::string why = large ? "left out: --quick, or a CPU" : "no memory";
            if (cells == 128) add(bench, "frame 1.1 M", -1, why);
            add(bench, rate, -1, why);
            continue;
        }
        sizes.push_back(bench.squeeze(cells));
        const BenchRow& row = sizes.back();
        if (cells == 128)
            add(bench, "frame 1.1 M", row.frames > 0 ? 1e3 * row.frame.median : -1,
                fmt::format("{:.0f} substeps", row.substeps));
        add(bench, rate, row.frames > 0 ? 1e-9 * row.rate() : -1, timed(row));
    }
    const BenchRow& last = sizes.back();
    add(bench, "memory", double(last.bytes) / double(last.particles),
        fmt::format("at {:.3g} particles", double(last.particles)));
    const char* const names[] = {"137 k", "1.1 M", "8.8 M"};
    for (std::size_t k = 0; k < 3; ++k)
        public_target(bench, names[k], k < sizes.size() ? &sizes[k] : nullptr);
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
    add(bench, "localized", all.frame.median / near.frame.median,
        fmt::format("{:.3g} against {:.3g} particles, the rest asleep; {:.3g} where it is held "
                    "still (localized)",
                    double(all.particles), double(near.particles),
                    held.frame.median / near.frame.median));
}

// The splat row of that name; null: not measured.
const BenchRow* splats(const Bench& bench, const std::string& name)
{
    const std::vector<BenchRow>& rows = bench.result.rows;
    const auto at = std::find_if(rows.begin(), rows.end(),
                                 [&](const BenchRow& r) { return r.name == "splats: " + name; });
    return at == rows.end() ? nullptr : &*at;
}

// Sizes omitted by --quick are not reported.
void picture_targets(Bench& bench)
{
    const BenchRow *far = splats(bench, "660k far"), *near = splats(bench, "660k near"),
                   *fine = splats(bench, "5m-fine far");
    const auto time = [](const BenchRow* r) { return r ? 1e3 * r->frame.median : -1; };
    const auto note = [](const BenchRow* r) {
        return r ? fmt::format("2 x {} x {}, {} splats moved", r->drawn.width, r->drawn.height,
                               r->drawn.moved)
                 : "left out: --quick, or no memory";
    };
    add(bench, "splats 660k far", time(far), note(far));
    add(bench, "splats near", far && near ? time(near) / time(far) : -1, note(near));
    add(bench, "splats 5m-fine", time(fine), note(fine));
    double agreed = -1;
    for (const BenchRow* r : {far, near, fine})
        if (r && r->drawn.psnr > 0)
            agreed = agreed < 0 ? r->drawn.psnr : std::min(agreed, r->drawn.psnr);
    add(bench, "splats cpu", agreed, agreed < 0 ? "no GPU's picture" : "the worst of the above");
    for (const auto& [key, name] : {std::pair{"splats exact", ", against the exact picture"},
                                    std::pair{"splats eyes", ", one order against one an eye"}}) {
        const BenchRow* row =
            splats(bench, (bench.options.quick ? "6k" : "30k") + std::string(name));
        add(bench, key, row ? row->drawn.psnr : -1, row ? note(row) : "");
    }
}

void splat_targets(Bench& bench)
{
    if (!splats(bench, "a frame in real time")) splats_suite(bench);
    picture_targets(bench);
    const BenchRow *bare = splats(bench, "a substep with 0 k Gaussians"),
                   *with = splats(bench, "a substep with 300 k Gaussians");
    add(bench, "gaussians",
        bare && with ? std::max(0.0, 1e6 * (with->substep.median - bare->substep.median)) : -1,
        bare && with ? fmt::format("{:.1f} us a substep with, {:.1f} without",
                                   1e6 * with->substep.median, 1e6 * bare->substep.median)
                     : "left out: --quick");
    const BenchRow *frame = splats(bench, "the paper's frame, 5 substeps"),
                   *real = splats(bench, "a frame in real time");
    add(bench, "splat frame", frame ? 1e3 * frame->frame.median : -1, frame ? frame->note : "");
    add(bench, "splat real time", real ? 1e3 * real->frame.median : -1, real ? real->note : "");
    if (!bench.figures.peers) return;
    const PeerFigures& peers = *bench.figures.peers;
    const bool both = frame && peers.splat_frame > 0;
    add(bench, "splat frame ratio", both ? peers.splat_frame / frame->frame.median : -1,
        both ? fmt::format("theirs {:.1f} ms, {}", 1e3 * peers.splat_frame, peers.splat_source)
             : "no figure of theirs");
}

void peer_target(Bench& bench)
{
    double measured = -1;
    std::string note = "not run: --peers runs it";
    for (const PeerRow& p : bench.result.peers) {
        if (p.name != "taichi") continue;
        note = p.problem.empty() ? fmt::format("theirs {:.1f} us, ours {:.1f} us on its scene",
                                               1e6 * p.substep, 1e6 * p.ours)
                                 : p.problem;
        if (p.problem.empty() && p.ours > 0) measured = p.substep / p.ours;
    }
    add(bench, "taichi", measured, note);
}

// Estimated time of the small squeeze on the card of peers.json: between the ratio of issue rates
// and the ratio of copy rates, depending on how much stays in its cache.
void estimate(Bench& bench)
{
    const double clock = gpu_clock();
    if (!bench.figures.peers || bench.facts.multiprocessors == 0 || clock <= 0) return;
    const PeerFigures& there = *bench.figures.peers;
    const BenchRow& small = bench.squeeze(64);
    const double low = small.substep.median * bench.facts.multiprocessors * clock /
                       (there.multiprocessors * there.clock);
    const double high = small.substep.median * bench.facts.copy / there.copy;
    bench.result.targets.push_back(
        {fmt::format("ESTIMATE for a card like the {}, 137 k, per substep", there.card), "us", 0, 0,
         false, -1,
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
    const auto without = [&](const std::string& what, const std::string& why) {
        if (why.empty()) return;
        bench.say(what + why);
        bench.result.left_out.push_back(what + why);
    };
    without("targets: ", bench.figures.no_targets);
    if (!bench.figures.targets) return;
    without("others' figures: ", bench.figures.no_peers);
    size_targets(bench);
    if (!bench.stopped()) localized_target(bench);
    if (!bench.stopped()) splat_targets(bench);
    peer_target(bench);
    if (!bench.stopped()) estimate(bench);
}

}  // namespace knead
