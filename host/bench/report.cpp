// Results of a benchmark as text, JSON, CSV and drawings.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/machine.h"
#include "host/bench/bench.h"
#include "host/solver/audit.h"
#include "host/solver/frame_stats.h"

namespace knead {
namespace {

using Json = nlohmann::json;

Json spread_json(const Spread& s, double scale)
{
    return {{"median", scale * s.median},
            {"p95", scale * s.p95},
            {"mean", scale * s.mean},
            {"max", scale * s.max}};
}

Json guards_json(const BenchRow& r)
{
    Json all;
    for (const auto& [name, count] : frame_guards) all[name] = r.acted[count];
    all["crowded"] = r.crowded;
    return all;
}

Json row_json(const BenchRow& r)
{
    Json stages = Json::object();
    for (const StageTime& s : r.stages) stages[s.name] = 1e3 * s.seconds;
    Json counted = Json::object();
    for (const StageWork& s : r.counted.stages)
        counted[s.name] = {{"instructions", s.work.instructions},
                           {"memory_bytes", s.work.memory_bytes},
                           {"level_2_bytes", s.work.cache_bytes}};
    const auto known = [](double x) { return x > 0 ? Json(x) : Json(); };
    const bool pixels = r.drawn.width > 0;
    return {{"suite", r.suite},
            {"name", r.name},
            {"at", r.at},
            {"particles", r.particles},
            {"nodes", {r.nodes.x, r.nodes.y, r.nodes.z}},
            {"frames", r.frames},
            {"repeats", r.repeats},
            {"frames_in_contact", r.in_contact},
            {"substeps_per_frame", r.substeps},
            {"frame_ms", spread_json(r.frame, 1e3)},
            {"substep_us", spread_json(r.substep, 1e6)},
            {"repeats_apart", r.between},
            {"surface_ms", known(1e3 * r.surface)},
            {"items_per_second", known(r.rate())},
            {"bytes", r.bytes},
            {"min_bytes_per_particle", known(r.min_bytes)},
            {"share_of_copy", known(r.copy_share)},
            {"instructions_per_particle", known(r.counted.sum.instructions)},
            {"share_of_issue", known(r.counted.issue_share)},
            {"memory_bytes_per_particle", known(r.counted.sum.memory_bytes)},
            {"share_of_copy_counted", known(r.counted.copy_share)},
            {"level_2_bytes_per_particle", known(r.counted.sum.cache_bytes)},
            {"counted_clock_MHz", known(1e-6 * r.counted.sum.clock())},
            {"moved_share", r.moved},
            {"eye_pixels", pixels ? Json{r.drawn.width, r.drawn.height} : Json()},
            {"splats_moved", pixels ? Json(r.drawn.moved) : Json()},
            {"splats_seen", known(double(r.drawn.visible))},
            {"instances", known(double(r.drawn.instances))},
            {"instances_dropped", r.drawn.visible ? Json(r.drawn.dropped) : Json()},
            {"psnr_dB", known(r.drawn.psnr)},
            {"stages_ms", stages},
            {"stages_counted", counted},
            {"guards", guards_json(r)},
            {"state_hash", r.hash},
            {"hashed_after_frames", r.hashed_after},
            {"note", r.note}};
}

Json target_json(const Target& t)
{
    return {{"name", t.name},          {"unit", t.unit},
            {"must", t.must},          {"aim", t.aim},
            {"at_least", t.min},       {"measured", t.measured < 0 ? Json() : Json(t.measured)},
            {"met", met_name(met(t))}, {"note", t.note}};
}

Json peer_json(const PeerRow& p)
{
    if (!p.problem.empty()) return {{"name", p.name}, {"problem", p.problem}};
    return {{"name", p.name},
            {"substep_us", 1e6 * p.substep},
            {"ours_us", 1e6 * p.ours},
            {"times_as_long", p.ours > 0 ? p.substep / p.ours : 0},
            {"clay_apart_mm", 1e3 * p.apart},
            {"said", p.said}};
}

std::string quoted(std::string text)
{
    for (std::size_t at = 0; (at = text.find('"', at)) != text.npos; at += 2)
        text.insert(at, 1, '"');
    return '"' + text + '"';
}

std::string stage_text(const StageTime& s, const std::vector<StageWork>& counted)
{
    std::string text = fmt::format("    {:<12} {:>9.3f} ms", s.name, 1e3 * s.seconds);
    for (const StageWork& c : counted)
        if (c.name == s.name)
            text +=
                fmt::format("  {:>7.2f} instructions  {:>6.1f} B of memory  {:>6.1f} B of level 2",
                            c.work.instructions, c.work.memory_bytes, c.work.cache_bytes);
    return text + "\n";
}

std::string drawn_text(const BenchRow& r)
{
    const DrawTimes& d = r.drawn;
    std::string text =
        fmt::format("  {:>9.3f} ms (p95 {:.3f})  2 x {} x {}, {} splats moved",
                    1e3 * r.frame.median, 1e3 * r.frame.p95, d.width, d.height, d.moved);
    if (d.visible > 0)
        text +=
            fmt::format(", {} seen, {} instances, {} dropped", d.visible, d.instances, d.dropped);
    return text + (d.psnr > 0 ? fmt::format(", PSNR {:.1f} dB", d.psnr) : "");
}

std::string row_text(const BenchRow& r)
{
    std::string text = fmt::format("{:<46} {:>9}", r.name, r.particles);
    if (r.drawn.width > 0)
        text += drawn_text(r);
    else if (r.suite == "surface")
        text += fmt::format("  {:>9.3f} ms", 1e3 * r.frame.median);
    else
        text += fmt::format(
            "  {:>9.3f} ms a frame (p95 {:.3f})  {:>8.2f} us x {:<4.0f} {:>6.2f} G/s"
            "  {:>4.1f} % of copy  {:>4.0f} B",
            1e3 * r.frame.median, 1e3 * r.frame.p95, 1e6 * r.substep.median, r.substeps,
            1e-9 * r.rate(), 100 * r.copy_share,
            double(r.bytes) / double(std::max<std::size_t>(r.particles, 1)));
    if (r.surface > 0 && r.suite != "surface")
        text += fmt::format("  + {:.2f} ms surface", 1e3 * r.surface);
    text += "\n";
    const DeviceWork& each = r.counted.sum;
    if (each.instructions > 0)
        text += fmt::format(
            "    counted a particle: {:.1f} instructions ({:.1f} % of issue), {:.0f} B of memory "
            "({:.1f} % of copy{}), {:.0f} B of level 2\n",
            each.instructions, 100 * r.counted.issue_share, each.memory_bytes,
            100 * r.counted.copy_share,
            r.min_bytes > 0 ? fmt::format("; at least {:.0f} B", r.min_bytes) : "",
            each.cache_bytes);
    for (const StageTime& s : r.stages) text += stage_text(s, r.counted.stages);
    if (guards_of(r.acted) + r.crowded > 0) {
        text += "    guards:";
        const Json all = guards_json(r);
        for (const auto& [name, count] : all.items())
            text += fmt::format(" {} {}", name, count.get<long>());
        text += "\n";
    }
    return text + (r.note.empty() ? "" : "    " + r.note + "\n");
}

std::string target_text(const Target& t)
{
    const char* sign = t.min ? ">=" : "<=";
    const std::string value = t.measured < 0 ? "-" : fmt::format("{:.4g}", t.measured);
    const auto bound = [&](double x) {
        return t.estimate ? std::string() : fmt::format("{} {:.4g}", sign, x);
    };
    return fmt::format("{:<60} {:<9} {:<9} {:>9} {:<3} {:<6} {}\n", t.name, bound(t.must),
                       bound(t.aim), value, t.unit, t.estimate ? "" : met_name(met(t)), t.note);
}

std::string peer_text(const PeerRow& p)
{
    if (!p.problem.empty()) return fmt::format("{:<28} {}\n", p.name, p.problem);
    return fmt::format(
        "{:<28} {:>9.2f} us   ours {:>8.2f} us   {:>6.1f} x   the clay {:.2g} mm "
        "apart\n",
        p.name, 1e6 * p.substep, 1e6 * p.ours, p.ours > 0 ? p.substep / p.ours : 0, 1e3 * p.apart);
}

}  // namespace

Json bench_json(const Bench& bench)
{
    const bool gpu = bench.device.kind == DeviceKind::cuda;
    Json context = machine_facts(gpu);
    context.update({{"executable", "knead bench"},
                    {"json_schema_version", 1},
                    {"device", bench.facts.name},
                    {"device_memory", bench.facts.memory},
                    {"multiprocessors", bench.facts.multiprocessors},
                    {"level_2_bytes", bench.facts.cache},
                    {"copy_bytes_per_second", bench.facts.copy},
                    {"scene", bench.options.scene},
                    {"suites", bench.options.suites},
                    {"quick", bench.options.quick},
                    {"threads_asked", bench.options.threads}});
    Json rows = Json::array(), targets = Json::array(), peers = Json::array();
    for (const BenchRow& r : bench.result.rows) rows.push_back(row_json(r));
    for (const Target& t : bench.result.targets) targets.push_back(target_json(t));
    for (const PeerRow& p : bench.result.peers) peers.push_back(peer_json(p));
    return {{"schema", "knead.bench/1"}, {"context", context}, {"rows", rows},
            {"targets", targets},        {"peers", peers},     {"left_out", bench.result.left_out}};
}

std::string bench_csv(const BenchResult& result)
{
    std::string out =
        "suite,name,at,particles,nodes_x,frames,repeats,in_contact,substeps,frame_ms,frame_p95_ms,"
        "substep_us,substep_p95_us,surface_ms,G_per_s,bytes,min_bytes,share_of_copy,"
        "instructions,share_of_issue,memory_bytes,share_of_copy_counted,level_2_bytes,"
        "moved_share,eye_width,eye_height,splats_moved,splats_seen,instances,instances_dropped,"
        "psnr_dB,";
    for (const auto& [name, count] : frame_guards) out += fmt::format("{},", name);
    out += "crowded,hash\n";
    for (const BenchRow& r : result.rows) {
        out += fmt::format(
            "{},{},{:.9g},{},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},"
            "{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},",
            r.suite, quoted(r.name), r.at, r.particles, r.nodes.x, r.frames, r.repeats,
            r.in_contact, r.substeps, 1e3 * r.frame.median, 1e3 * r.frame.p95,
            1e6 * r.substep.median, 1e6 * r.substep.p95, 1e3 * r.surface, 1e-9 * r.rate(), r.bytes,
            r.min_bytes, r.copy_share, r.counted.sum.instructions, r.counted.issue_share,
            r.counted.sum.memory_bytes, r.counted.copy_share, r.counted.sum.cache_bytes, r.moved);
        const DrawTimes& d = r.drawn;
        out += fmt::format("{},{},{},{},{},{},{:.6g},", d.width, d.height, d.moved, d.visible,
                           d.instances, d.dropped, d.psnr);
        for (const auto& [name, count] : frame_guards) out += fmt::format("{},", r.acted[count]);
        out += fmt::format("{},{}\n", r.crowded, r.hash);
    }
    return out;
}

std::string bench_text(const Bench& bench)
{
    std::string text =
        fmt::format("{}: copies {:.4g} GB/s, {:.1f} GiB; {}\n", bench.facts.name,
                    1e-9 * bench.facts.copy, double(bench.facts.memory) / 0x1p30, knead_commit());
    std::string suite;
    for (const BenchRow& r : bench.result.rows) {
        if (r.suite != suite) text += "\n" + r.suite + "\n";
        suite = r.suite;
        text += row_text(r);
    }
    if (!bench.result.peers.empty()) text += "\npeers, a substep of the same scene\n";
    for (const PeerRow& p : bench.result.peers) text += peer_text(p);
    if (!bench.result.targets.empty())
        text += fmt::format("\n{:<60} {:<9} {:<9} {:>9} {:<3} met\n",
                            bench.figures.targets
                                ? fmt::format("target (set for {})", bench.figures.targets->set_for)
                                : "target",
                            "must", "aim", "measured", "");
    for (const Target& t : bench.result.targets) text += target_text(t);
    for (const std::string& s : bench.result.left_out) text += "left out: " + s + "\n";
    return text;
}

}  // namespace knead
