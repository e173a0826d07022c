#include "host/scene/splats_options.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/scene/names.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

// Absolute in a `folder`, so that a log with this path can be read from another one.
std::string named_file(ObjectReader& r, const std::string& folder)
{
    const std::string file = r.text("file", "");
    return folder.empty() || file.empty()
               ? r.beside("file", file)
               : fs::absolute(fs::path(folder) / file).lexically_normal().string();
}

std::string relative_to(const std::string& path, const std::string& file)
{
    return fs::path(file).lexically_relative(fs::path(path).parent_path()).string();
}

}  // namespace

void read_splats_options(ObjectReader& r, SplatsOptions& splats, const std::string& folder)
{
    splats.file = named_file(r, folder);
    splats.size = r.number("size", {0, 1000, "m", true});
    splats.turn = r.number("turn", {-360, 360, "degrees"}, 0);
    splats.depth = r.number("depth", {0, 1000, "m"}, 0);
    splats.up = r.choice("up", up_axes, UpAxis::minus_y);
}

void write_splats_options(const SplatsOptions& splats, const std::string& path, Json& object)
{
    object["file"] = relative_to(path, splats.file);
    object["size"] = splats.size;
    object["turn"] = splats.turn;
    object["depth"] = splats.depth;
    object["up"] = name_of(up_axes, splats.up);
}

void read_mesh_options(ObjectReader& r, MeshOptions& mesh, const std::string& folder)
{
    mesh.file = named_file(r, folder);
    int given = 0;
    for (const char* key : {"size", "scale", "unit"}) given += r.has(key);
    if (given != 1)
        r.fail("size", "one of size (longest extent, m), scale (m) and unit (mm, cm, m, in)",
               given == 0 ? "none" : "several");
    if (r.has("size")) mesh.size = r.number("size", {0, 1000, "m", true});
    if (r.has("scale")) mesh.scale = r.number("scale", {0, 1e6, "m a unit of the file", true});
    if (r.has("unit")) mesh.scale = r.choice("unit", mesh_units, 1.0);
    mesh.turn = r.number("turn", {-360, 360, "degrees"}, 0);
    mesh.hollow = r.number("hollow", {0, 1000, "m"}, 0);
    mesh.up = r.choice("up", up_axes, UpAxis::y);
}

void write_mesh_options(const MeshOptions& mesh, const std::string& path, Json& object)
{
    object["file"] = relative_to(path, mesh.file);
    if (mesh.size > 0) object["size"] = mesh.size;
    if (mesh.scale > 0) object["scale"] = mesh.scale;
    object["turn"] = mesh.turn;
    object["hollow"] = mesh.hollow;
    object["up"] = name_of(up_axes, mesh.up);
}

void read_upkeep(ObjectReader& r, UpkeepOptions& upkeep)
{
    constexpr int most = 100000000;
    upkeep.every = r.whole("every", 1, 1000000, upkeep.every);
    upkeep.capacity = std::size_t(r.whole("capacity", 0, most, 0));
    r.object("split", [&](ObjectReader& in) {
        SplitOptions& split = upkeep.split;
        split.limit = in.number("limit", {0, 1000, "times the length at rest"}, split.limit);
        if (split.limit > 0 && split.limit < 1.1)
            in.fail("limit", "0 (none is split) or 1.1 to 1000 times the length at rest",
                    short_number(split.limit));
        split.smallest = in.number("smallest", {0, 1000, "m"}, split.smallest);
        split.budget = std::size_t(in.whole("budget", 1, most, int(split.budget)));
        upkeep.splits = split.limit > 0;
    });
    r.object("refill", [&](ObjectReader& in) {
        RefillOptions& refill = upkeep.refill;
        refill.see_through = in.number("see_through", {0.001, 1, ""}, refill.see_through);
        refill.budget = std::size_t(in.whole("budget", 1, most, int(refill.budget)));
        upkeep.refills = refill.see_through < 1;
    });
}

}  // namespace knead
