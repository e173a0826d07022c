#include "host/cli/run_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/cli/script.h"
#include "host/files/webp.h"
#include "host/scene/domain.h"

namespace knead {

std::vector<std::string> settings_of(const RunOptions& o)
{
    std::vector<std::string> settings = o.settings;
    if (o.seed) settings.push_back(fmt::format("seed={}", *o.seed));
    if (o.pictures >= 0) settings.push_back(fmt::format("pictures.every={}", o.pictures));
    if (o.deterministic) settings.push_back("deterministic=true");
    if (o.cells > 0) settings.push_back(cells_setting(read_json(o.scene), o.cells));
    return settings;
}

Scene scene_of(const RunOptions& o)
{
    Scene scene = read_scene(o.scene, settings_of(o));
    if (!o.hands.empty()) {
        if (!scene.has_hands && !begin_with_hands(scene, o.hands))
            throw UsageError("--hands: the scene has no \"hands\" to replace");
        scene.hands.recording = o.hands;
    }
    scene.setup.threads = o.threads;
    const bool shows = o.video || (scene.picture_every > 0 && !o.out.empty());
    // A video has about 30 pictures per second.
    if (!shows)
        scene.picture_every = 0;
    else if (scene.picture_every == 0)
        scene.picture_every = std::max(1, int(std::lround(scene.frame_rate / 30)));
    return scene;
}

void check_options(const RunOptions& o)
{
    if (o.scene.empty() == o.resume.empty())
        throw UsageError("knead run needs a SCENE, or --resume with the folder of a run");
    if (o.out.empty() && o.resume.empty() && o.checkpoint.value_or(0) > 0)
        throw UsageError("--checkpoint needs --out DIR");
    if (o.keep_going && o.commands.empty()) throw UsageError("--keep-going needs --commands LOG");
    if (!o.commands.empty() && o.checkpoint.value_or(0) > 0)
        throw UsageError("--checkpoint: not with --commands");
    const std::vector<std::string> forms{"ply", "compressed.ply", "splat", "spz", "sog", "glb",
                                         "none"};
    if (std::find(forms.begin(), forms.end(), o.splats) == forms.end())
        throw UsageError(
            "--splats: expected ply, compressed.ply, splat, spz, sog, glb or none, found \"" +
            o.splats + "\"");
    if (o.splats == "sog" && !webp_available())
        throw UsageError("--splats sog: this program was built without libwebp");
    if (o.out.empty() &&
        (o.video || o.particles || o.pictures > 0 || o.mesh_every > 0 || o.particles_every > 0))
        throw UsageError("--video, --particles, --pictures and sequences need --out DIR");
    const std::vector<std::string> meshes{"glb", "ply", "obj", "stl", "none"};
    if (std::find(meshes.begin(), meshes.end(), o.mesh) == meshes.end())
        throw UsageError("--mesh: expected glb, ply, obj, stl or none, found \"" + o.mesh + "\"");
    if (o.mesh == "none" && o.mesh_every > 0)
        throw UsageError("--mesh-every needs another --mesh than none");
}

}  // namespace knead
