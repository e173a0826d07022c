#include "host/scene/scene_hands.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/hands/gesture.h"
#include "host/scene/seed.h"

namespace knead {

Recording hands_of(const Scene& scene)
{
    const HandsOptions& hands = scene.hands;
    std::vector<std::string> names;
    for (const Gesture& g : gestures()) {
        names.push_back(g.name);
        if (g.name != hands.recording) continue;
        GestureOptions options;
        if (!scene.objects.empty()) options.radius = extents(scene.objects[0]).x / 2 / hands.zoom;
        options.topology = hands.topology;
        options.seed = scene.seed;
        return generate(g.name, options);
    }
    const std::filesystem::path file = hands.recording;
    std::error_code problem;
    if (!file.has_extension() && !std::filesystem::exists(file, problem))
        throw InputError(
            fmt::format("{}: no such recording, and no such gesture; the nearest is "
                        "\"{}\"",
                        hands.recording, nearest_name(hands.recording, names)));
    return read_recording(hands.recording);
}

}  // namespace knead
