#include "host/bench/figures.h"

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/paths.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr double unbounded = std::numeric_limits<double>::infinity();

void need_schema(ObjectReader& r, const std::string& schema)
{
    r.required("schema", "\"" + schema + "\"");
    const std::string found = r.text("schema", "");
    if (found != schema) r.fail("schema", "\"" + schema + "\"", "\"" + found + "\"");
}

std::string required_text(ObjectReader& r, const std::string& key)
{
    r.required(key, "a text");
    return r.text(key, "");
}

// The data of the drawings is only checked for presence; plot.py reads it.
PeerFigures peers_of(const Json& root, const std::string& file)
{
    PeerFigures out;
    ObjectReader::read(root, file, "", [&](ObjectReader& r) {
        need_schema(r, "knead.peers/1");
        r.required("paper", "an object");
        r.required("public_best", "an object");
        r.object("public_best", [&](ObjectReader& best) {
            out.source = required_text(best, "source");
            out.device = required_text(best, "device");
            const Json sizes = best.required("substep_us", "an object");
            best.object("substep_us", [&](ObjectReader& times) {
                for (const auto& [size, time] : sizes.items())
                    out.public_best[size] = 1e-6 * times.number(size, {0, unbounded, "us", true});
            });
        });
        r.object("splat_frame", [&](ObjectReader& frame) {
            out.splat_source = required_text(frame, "source");
            out.splat_frame = 1e-3 * frame.number("ms", {0, unbounded, "ms", true});
        });
        r.required("card", "an object");
        r.object("card", [&](ObjectReader& card) {
            out.card = required_text(card, "name");
            out.multiprocessors = card.number("multiprocessors", {0, unbounded, "", true});
            out.clock = 1e6 * card.number("clock_MHz", {0, unbounded, "MHz", true});
            out.copy = 1e9 * card.number("memory_GB_per_s", {0, unbounded, "GB/s", true}) *
                       card.number("share_of_copy", {0, 1, "", true});
        });
    });
    return out;
}

TargetList targets_of(const Json& root, const std::string& file)
{
    TargetList out;
    ObjectReader::read(root, file, "", [&](ObjectReader& r) {
        need_schema(r, "knead.targets/1");
        out.set_for = required_text(r, "set_for");
        const Json all = r.required("targets", "an object");
        r.object("targets", [&](ObjectReader& list) {
            for (const auto& [name, value] : all.items())
                list.object(name, [&, key = name](ObjectReader& t) {
                    Target target;
                    target.name = required_text(t, "name");
                    target.unit = t.text("unit", "");
                    target.must = t.number("must", {0, unbounded});
                    target.aim = t.number("aim", {0, unbounded});
                    target.min = t.flag("at_least", false);
                    if (target.min ? target.aim < target.must : target.aim > target.must)
                        t.fail("aim", "a bound that is not weaker than must",
                               short_number(target.aim));
                    out.targets[key] = target;
                });
        });
    });
    return out;
}

}  // namespace

std::string figures_folder(const std::string& requested)
{
    if (!requested.empty()) return requested;
    const std::string found = shipped("profiling/targets.json");
    return found.empty() ? "profiling" : fs::path(found).parent_path().string();
}

Figures read_figures(const std::string& folder)
{
    Figures out;
    out.folder = folder;
    const std::string peers = (fs::path(folder) / "peers.json").string(),
                      targets = (fs::path(folder) / "targets.json").string();
    if (fs::exists(peers))
        out.peers = peers_of(read_json(peers), peers);
    else
        out.no_peers = "no file " + peers + " (--data says where)";
    if (fs::exists(targets))
        out.targets = targets_of(read_json(targets), targets);
    else
        out.no_targets = "no file " + targets + " (--data says where)";
    return out;
}

}  // namespace knead
