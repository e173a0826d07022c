// The summary of a report in text form.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/run/report.h"
#include "host/scene/soften.h"

namespace knead {
namespace {

double at(const Json& j, const char* pointer)
{
    const Json::json_pointer p(pointer);
    return j.contains(p) && j[p].is_number() ? j[p].get<double>() : 0;
}

// An integer count, formatted from a double: a report may hold values beyond integer types.
std::string count_at(const Json& j, const char* pointer)
{
    return fmt::format("{:.0f}", at(j, pointer));
}

std::string counted(const Json& object)
{
    std::string text;
    for (const auto& [name, count] : object.items()) {
        if (!count.is_number() || count == 0) continue;
        text += fmt::format("{}{} {:.0f}", text.empty() ? "" : ", ", name, count.get<double>());
    }
    return text.empty() ? "none" : text;
}

// Stages in frame order, which only the rows of "runs" preserve.
std::string stage_lines(const Json& report)
{
    std::string text;
    for (const Json& run : report["runs"]) {
        const std::string name = run["name"].get<std::string>();
        const std::size_t stage = name.rfind("/stage/");
        if (stage == std::string::npos) continue;
        text += fmt::format("  {:<12} {:>9.3f} ms median {:>9.3f} ms p95\n", name.substr(stage + 7),
                            at(run, "/real_time"), at(run, "/p95"));
    }
    return text;
}

std::string softened_lines(const Json& k)
{
    std::string text;
    if (!k.contains("softened")) return text;
    for (const Json& s : k["softened"])
        text += "softened      " + s["text"].get<std::string>() + "\n";
    return text;
}

struct Wanted {
    const char* pointer;
    Json::value_t type;
};
// Values that a summary cannot do without.
const Wanted wanted[] = {{"/context/scene", Json::value_t::string},
                         {"/context/device", Json::value_t::string},
                         {"/runs", Json::value_t::array},
                         {"/knead/end", Json::value_t::string},
                         {"/knead/time/limited_by", Json::value_t::object},
                         {"/knead/mass/exact", Json::value_t::boolean},
                         {"/knead/volume", Json::value_t::object},
                         {"/knead/rest/mode", Json::value_t::string},
                         {"/knead/guards", Json::value_t::object},
                         {"/knead/state_hash", Json::value_t::string},
                         {"/knead/left_out", Json::value_t::array},
                         {"/knead/outputs", Json::value_t::array}};

void require(const Json& in, const std::string& pointer, Json::value_t type,
             const std::string& file)
{
    const Json::json_pointer p(pointer);
    if (in.contains(p) && in[p].type() == type) return;
    throw InputError(fmt::format("{}: {}: expected {} as in every report, found {}", file, pointer,
                                 Json(type).type_name(),
                                 in.contains(p) ? described(in[p]) : "nothing"));
}

}  // namespace

Json softened_facts(const Scene& scene)
{
    Json all = Json::array();
    for (const Object& one : scene.objects) {
        if (one.softer == 1) continue;
        const double modulus = elastic_modulus(one.material);
        all.push_back({{"object", one.name},
                       {"modulus_Pa", modulus},
                       {"given_Pa", modulus * one.softer},
                       {"times", one.softer},
                       {"text", softened_text(scene, one)}});
    }
    return all;
}

void check_report(const Json& report, const std::string& file)
{
    for (const Wanted& one : wanted) require(report, one.pointer, one.type, file);
    for (std::size_t i = 0; i < report["runs"].size(); ++i)
        require(report, fmt::format("/runs/{}/name", i), Json::value_t::string, file);
    for (const char* texts : {"left_out", "outputs"})
        for (std::size_t i = 0; i < report["knead"][texts].size(); ++i)
            require(report, fmt::format("/knead/{}/{}", texts, i), Json::value_t::string, file);
    if (report["knead"].contains("softened")) {
        require(report, "/knead/softened", Json::value_t::array, file);
        for (std::size_t i = 0; i < report["knead"]["softened"].size(); ++i)
            require(report, fmt::format("/knead/softened/{}/text", i), Json::value_t::string, file);
    }
    if (report["knead"].contains("trouble"))
        require(report, "/knead/trouble", Json::value_t::string, file);
}

std::string summary(const Json& report)
{
    const Json& k = report["knead"];
    const double frame = at(k, "/frame/median_ms");
    std::string text =
        fmt::format("{}: {}, {} of {} frames, {:.4g} s simulated in {:.4g} s\n",
                    report["context"]["scene"].get<std::string>(), k["end"].get<std::string>(),
                    count_at(k, "/frames"), count_at(k, "/frames_wanted"), at(k, "/simulated_s"),
                    at(k, "/wall_s"));
    if (k.contains("cut"))
        text +=
            fmt::format("cut           frame {} ends at {:.4g} of {:.4g} s, after {} substeps\n",
                        count_at(k, "/cut/frame"), at(k, "/cut/reached_s"), at(k, "/frame_s"),
                        count_at(k, "/cut/substeps"));
    if (k.contains("trouble")) text += "trouble       " + k["trouble"].get<std::string>() + "\n";
    text += fmt::format("device        {}\n", report["context"]["device"].get<std::string>());
    text += fmt::format("frame         {:.3f} ms median, {:.3f} ms p95 ({:.1f} frames/s)\n", frame,
                        at(k, "/frame/p95_ms"), frame > 0 ? 1e3 / frame : 0);
    text += stage_lines(report);
    text += fmt::format("particles     {} ({:.1f} MiB), {:.1f} % of the blocks active\n",
                        count_at(k, "/particles"), at(k, "/bytes") / 0x1p20,
                        100 * at(k, "/active_block_share"));
    text += fmt::format("substeps      {}, {:.3g} to {:.3g} s, limited by {}\n",
                        count_at(k, "/time/substeps"), at(k, "/time/dt_min_s"),
                        at(k, "/time/dt_max_s"), counted(k["time"]["limited_by"]));
    text += fmt::format("mass          {:.9g} kg{}\n", at(k, "/mass/last_kg"),
                        k.contains("local")              ? ", of what is clay just now"
                        : k["mass"]["exact"].get<bool>() ? ", unchanged"
                                                         : ", CHANGED");
    text += fmt::format("volume        {:.6g} m^3, drift {:+.3f} %", at(k, "/volume/last_m3"),
                        100 * at(k, "/volume/drift"));
    if (k["volume"].contains("mesh_drift"))
        text += fmt::format("; of the mesh {:+.3f} %", 100 * at(k, "/volume/mesh_drift"));
    text += fmt::format("\nenergy        {:.4g} J kinetic, {:.4g} J elastic\n",
                        at(k, "/energy/kinetic_J"), at(k, "/energy/elastic_J"));
    text += fmt::format("yielded       {:.2f} % of all particle-substeps\n",
                        100 * at(k, "/yielded_share"));
    if (k["rest"]["mode"] != "none")
        text += fmt::format("moved         {:.2f} % of all particle-substeps, {} blocks woken\n",
                            100 * at(k, "/rest/moved_share"), count_at(k, "/rest/woken_blocks"));
    text += fmt::format(
        "penetration   left: mean {:.3g}, p99 {:.3g}, max {:.3g} mm; found: max {:.3g} mm\n",
        at(k, "/penetration/left_mean_mm"), at(k, "/penetration/left_p99_mm"),
        at(k, "/penetration/left_max_mm"), at(k, "/penetration/found_max_mm"));
    if (at(k, "/penetration/between_most") > 0)
        text += fmt::format("between tools {} particles at most, max {:.3g} mm\n",
                            count_at(k, "/penetration/between_most"),
                            at(k, "/penetration/between_max_mm"));
    if (k.contains("splats"))
        text += fmt::format("splats        {}, {} of them interior; {} projections out of tools\n",
                            count_at(k, "/splats/count"), count_at(k, "/splats/inside"),
                            count_at(k, "/splats/projected"));
    text += "guards        " + counted(k["guards"]) + "\n";
    if (k.contains("hands"))
        text += fmt::format("hands         active in {} frames, filter lag {:.1f} ms\n",
                            count_at(k, "/hands/frames_active"), at(k, "/hands/filter_lag_ms"));
    text += softened_lines(k);
    text += "state hash    " + k["state_hash"].get<std::string>() + "\n";
    for (const Json& s : k["left_out"]) text += "left out      " + s.get<std::string>() + "\n";
    for (const Json& s : k["outputs"]) text += "wrote         " + s.get<std::string>() + "\n";
    return text;
}

}  // namespace knead
