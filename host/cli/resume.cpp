#include "host/cli/resume.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/hands/gesture.h"
#include "host/run/report.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

bool is_gesture(const std::string& name)
{
    for (const Gesture& g : gestures())
        if (g.name == name) return true;
    return false;
}

// Makes the path absolute: the run may be resumed from another folder.
std::string from_anywhere(const std::string& path)
{
    return path.empty() || is_gesture(path) ? path : fs::absolute(path).string();
}

void check_same(const std::string& path, const std::string& hash)
{
    if (file_hash(path) != hash)
        throw InputError(path + ": expected the unchanged file of the run, found " +
                         (fs::exists(path) ? "another" : "none"));
}

std::string hands_file(const Scene& scene)
{
    if (!scene.has_hands || is_gesture(scene.hands.recording)) return "";
    return from_anywhere(scene.hands.recording);
}

// Hashes of the files of the scene's objects, in the order of its objects.
std::vector<std::string> splat_hashes(const Scene& scene)
{
    std::vector<std::string> hashes;
    for (const Object& o : scene.objects)
        if (o.shape == ShapeKind::splats)
            hashes.push_back(file_hash(o.splats.file));
        else if (o.shape == ShapeKind::mesh)
            hashes.push_back(file_hash(o.mesh.file));
    return hashes;
}

void check_splats(const RunOptions& o, const std::vector<std::string>& hashes)
{
    if (hashes.empty()) return;
    if (splat_hashes(read_scene(o.scene, o.settings)) != hashes)
        throw InputError(o.scene + ": expected the unchanged splat files of the run");
}

// Materials of objects that were activated around the hands; frozen ones get an empty material.
void add_local(std::vector<Material<double>>& materials, const LocalState& local,
               const Scene& scene)
{
    const std::size_t before = materials.size();
    for (const Object& o : scene.objects) {
        if (!o.local() || local.objects < int(before) || local.objects > 100000000) continue;
        materials.resize(std::size_t(local.objects), Material<double>{});
        const Material<double> material = materials[std::size_t(&o - scene.objects.data())];
        for (const auto& [cube, object] : local.clay)
            if (object >= int(before) && object < local.objects)
                materials[std::size_t(object)] = material;
    }
}

}  // namespace

Json command_of(const RunOptions& o, const std::string& device, double cpu_seconds,
                const Scene& scene)
{
    const std::string hands = hands_file(scene);
    return {{"scene", from_anywhere(o.scene)},
            {"scene_hash", file_hash(o.scene)},
            {"hands_file", hands},
            {"hands_hash", hands.empty() ? "" : file_hash(hands)},
            {"device", device},
            {"settings", o.settings},
            {"hands", from_anywhere(o.hands)},
            {"frames", o.frames},
            {"deterministic", o.deterministic},
            {"seed", o.seed ? Json(*o.seed) : Json()},
            {"max_memory", o.max_memory},
            {"audit", o.audit_every},
            {"mesh", o.mesh},
            {"pictures", o.pictures},
            {"cells", o.cells},
            {"mesh_every", o.mesh_every},
            {"particles_every", o.particles_every},
            {"video", o.video},
            {"particles", o.particles},
            {"splats", o.splats},
            {"splat_hashes", splat_hashes(scene)},
            {"build", knead_commit()},
            {"cpu_seconds", cpu_seconds}};
}

RunOptions options_of(const Checkpoint& from, const RunOptions& now)
{
    RunOptions o = now;
    const std::string file = (fs::path(now.resume) / checkpoint_name).string();
    try {
        const Json& c = from.command;
        c.at("scene").get_to(o.scene), c.at("device").get_to(o.device);
        c.at("settings").get_to(o.settings), c.at("hands").get_to(o.hands);
        c.at("frames").get_to(o.frames), c.at("deterministic").get_to(o.deterministic);
        if (!c.at("seed").is_null()) o.seed = c.at("seed").get<unsigned>();
        c.at("max_memory").get_to(o.max_memory), c.at("audit").get_to(o.audit_every);
        c.at("mesh").get_to(o.mesh), c.at("pictures").get_to(o.pictures);
        // Missing in checkpoints of older versions.
        o.cells = c.value("cells", 0), o.mesh_every = c.value("mesh_every", 0);
        o.particles_every = c.value("particles_every", 0);
        c.at("video").get_to(o.video), c.at("particles").get_to(o.particles);
        c.at("splats").get_to(o.splats);
        cpu_seconds_of(from), c.at("build").get<std::string>();
        check_same(o.scene, c.at("scene_hash"));
        const std::string hands = c.at("hands_file");
        if (!hands.empty()) check_same(hands, c.at("hands_hash"));
        check_splats(o, c.at("splat_hashes"));
    } catch (const Json::exception& e) {
        throw InputError(file + ": its command is not that of a run: " + e.what());
    }
    o.out = now.resume;
    return o;
}

double cpu_seconds_of(const Checkpoint& from)
{
    return from.command.at("cpu_seconds").get<double>();
}

void load(EditableSimulator& solver, const Checkpoint& from, const Scene& scene,
          SceneSplats& splats, const std::string& file)
{
    const auto check = [&](const char* what, std::size_t expected, std::size_t found) {
        if (found != expected)
            throw InputError(fmt::format("{}: expected the {} {} of its scene, found {}", file,
                                         expected, what, found));
    };
    if (!splats.local())  // else the number of particles varies
        check("particles", scene.setup.particles.size(),
              from.stored.state.contents.particles.size());
    // Splitting and adding splats may have changed the number of Gaussians.
    const bool grown = splats.local() || (scene.upkeep.any() && !scene.setup.gaussians.empty());
    check("Gaussians", grown ? from.stored.splats.count() : scene.setup.gaussians.size(),
          from.stored.state.contents.gaussians.size());
    check("splats", from.stored.state.contents.gaussians.size(), from.stored.splats.count());
    SavedState state = from.stored.state;
    state.config = solver.config();
    add_local(state.config.materials, from.stored.local, scene);
    try {
        splats.set_state(from.stored.splats, from.stored.local);
        solver.load(state);
    } catch (const std::invalid_argument& e) {
        throw InputError(file + ": " + e.what());
    }
}

}  // namespace knead
