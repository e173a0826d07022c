// knead compare: two reports, or two particle files. Exit code 1 if they differ by more than the
// tolerance.
#include "host/cli/compare.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/print.h"
#include "host/files/file_kind.h"
#include "host/files/particle_file.h"

namespace knead {
namespace {

// Physical quantities of a report, which must agree.
const char* const to_agree[] = {"/knead/simulated_s",         "/knead/particles",
                                "/knead/mass/last_kg",        "/knead/volume/last_m3",
                                "/knead/volume/mesh_last_m3", "/knead/energy/kinetic_J",
                                "/knead/energy/elastic_J",    "/knead/yielded_share",
                                "/knead/time/substeps",       "/knead/penetration/left_max_mm"};

double value(const Json& report, const char* pointer)
{
    const Json::json_pointer p(pointer);
    return report.contains(p) && report[p].is_number() ? report[p].get<double>() : std::nan("");
}

// All are mandatory except the volume of the mesh, which not every run makes.
void check_quantities(const Json& report, const std::string& file)
{
    for (const std::string q : to_agree)
        if (q != "/knead/volume/mesh_last_m3" && std::isnan(value(report, q.c_str())))
            throw InputError(file + ": " + q + ": expected a number as in every report");
}

std::string text_at(const Json& report, const char* pointer)
{
    const Json::json_pointer p(pointer);
    return report.contains(p) && report[p].is_string() ? report[p].get<std::string>() : "";
}

double relative(double a, double b)
{
    if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
    const double size = std::fmax(std::fabs(a), std::fabs(b));
    return std::isnan(a) || std::isnan(b) ? INFINITY : std::fabs(a - b) / size;
}

}  // namespace

Json compared(const Json& a, const Json& b, const CompareOptions& o)
{
    check_quantities(a, o.first), check_quantities(b, o.second);
    const std::string hash = text_at(a, "/knead/state_hash");
    const bool same = !hash.empty() && hash == text_at(b, "/knead/state_hash");
    Json all = {{"kind", "reports"}, {"same_state", same}, {"differences", Json::array()}};
    bool agree = true;
    for (const char* q : to_agree) {
        const double first = value(a, q), second = value(b, q), apart = relative(first, second);
        if (apart > o.tolerance) agree = false;
        if (apart > 0)
            all["differences"].push_back(
                {{"what", q}, {"first", first}, {"second", second}, {"relative", apart}});
    }
    const double before = value(a, "/knead/frame/median_ms"),
                 after = value(b, "/knead/frame/median_ms");
    const double ratio = before > 0 ? after / before : std::nan("");
    all["frame_ms"] = {{"first", before}, {"second", after}, {"ratio", ratio}};
    const bool fast = !(o.slower > 0) || ratio <= o.slower;
    if (!fast) all["slower_than_allowed"] = true;
    all["agree"] = (same || agree) && fast;
    return all;
}

Json compared(const std::vector<Particle<double>>& a, const std::vector<Particle<double>>& b,
              const CompareOptions& o)
{
    Json all = {{"kind", "particles"}, {"first", a.size()}, {"second", b.size()}, {"agree", false}};
    if (a.size() != b.size()) return all;
    double sum = 0, farthest = 0, fastest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const Vec3<double> d = a[i].x - b[i].x, dv = a[i].v - b[i].v;
        sum += dot(d, d);
        farthest = max(farthest, length(d)), fastest = max(fastest, length(dv));
    }
    all["rms_m"] = std::sqrt(sum / double(a.size()));
    all["max_m"] = farthest;
    all["max_m_per_s"] = fastest;
    all["agree"] = farthest <= o.tolerance;
    return all;
}

std::string text_of(const Json& all)
{
    std::string text;
    if (all["kind"] == "particles") {
        text = fmt::format("particles     {} and {}\n", all["first"].get<long>(),
                           all["second"].get<long>());
        if (all.contains("rms_m"))
            text +=
                fmt::format("apart         rms {:.6g} m, max {:.6g} m; velocities max {:.6g} m/s\n",
                            all["rms_m"].get<double>(), all["max_m"].get<double>(),
                            all["max_m_per_s"].get<double>());
    } else {
        text = std::string("state         ") +
               (all["same_state"].get<bool>() ? "the same" : "differs") + "\n";
        for (const Json& d : all["differences"])
            text += fmt::format("{:<30} {:>14.8g} {:>14.8g}  {:.3g} apart\n",
                                d["what"].get<std::string>(), d["first"].get<double>(),
                                d["second"].get<double>(), d["relative"].get<double>());
        const Json& f = all["frame_ms"];
        text += fmt::format("frame         {:.4g} ms and {:.4g} ms, ratio {:.3g}{}\n",
                            f["first"].get<double>(), f["second"].get<double>(),
                            f["ratio"].get<double>(),
                            all.contains("slower_than_allowed") ? ": slower than allowed" : "");
    }
    return text + (all["agree"].get<bool>() ? "agree\n" : "DIFFER\n");
}

int compare_verb(const CompareOptions& o)
{
    const FileKind first = file_kind(o.first), second = file_kind(o.second);
    if (first != second || (first != FileKind::report && first != FileKind::particles))
        throw InputError(o.first + ", " + o.second +
                         ": expected two reports or two particle files");
    const Json all = first == FileKind::report
                         ? compared(read_json(o.first), read_json(o.second), o)
                         : compared(read_particles(o.first), read_particles(o.second), o);
    print(o.json ? all.dump(2) + "\n" : text_of(all));
    return all["agree"].get<bool>() ? exit_ok : exit_check;
}

}  // namespace knead
