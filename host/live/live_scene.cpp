// Loading of scenes for live sessions.
#include "host/assets/mesh_object.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/live/live_session.h"
#include "host/scene/foresight.h"
#include "host/scene/new_scene.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

std::shared_ptr<const LiveScene> loaded(const SceneSource& source, const DocumentPtr& document,
                                        std::size_t memory, bool needs_hands)
{
    auto made = std::make_shared<LiveScene>();
    made->scene = parse_scene(source.text, source.path, source.settings);
    if (document) made->scene = scene_of(std::move(made->scene), *document);
    made->text = source.text;
    if (memory == 0) memory = available_memory();
    check_substeps(made->scene);
    made->settings = source.settings;
    load_meshes(made->scene);
    made->splats = load_splats(made->scene, memory);
    build(made->scene, memory);
    try {
        if (made->scene.has_hands) made->recording = hands_of(made->scene);
    } catch (const InputError&) {
        if (needs_hands) throw;
    }
    return made;
}

}  // namespace

std::shared_ptr<const LiveScene> load_live_scene(const std::string& path,
                                                 const std::vector<std::string>& settings,
                                                 std::size_t memory)
{
    return loaded({path, scene_text(path), settings}, nullptr, memory, true);
}

std::shared_ptr<const LiveScene> live_scene_of(const SceneSource& source,
                                               const DocumentPtr& document, std::size_t memory)
{
    return loaded(source, document, memory, false);
}

std::shared_ptr<const LiveScene> load_session_scene(const std::string& file, std::size_t memory)
{
    return live_scene_of(session_to_continue(file).scene(), nullptr, memory);
}

std::vector<std::string> fitting_settings(const std::string& path,
                                          const std::vector<std::string>& settings,
                                          std::vector<std::string>& left_out)
{
    const std::string text = scene_text(path);
    parse_scene(text, path);
    std::vector<std::string> fitting;
    for (const std::string& setting : settings) {
        fitting.push_back(setting);
        try {
            parse_scene(text, path, fitting);
        } catch (const InputError&) {
            left_out.push_back(setting);
            fitting.pop_back();
        }
    }
    return fitting;
}

std::vector<int> splat_categories(const Scene& scene)
{
    std::vector<int> found;
    for (const Object& o : scene.objects)
        if (o.shape == ShapeKind::splats) found.push_back(o.category);
    return found;
}

std::vector<int> splat_categories(const Document& document)
{
    std::vector<int> found;
    for (const auto& o : document.objects)
        if (o->source.shape == ShapeKind::splats) found.push_back(o->category);
    return found;
}

Meshes meshes_of(const LiveState& state)
{
    if (state.meshes) return state.meshes;
    return std::make_shared<const std::vector<Mesh>>(state.on_device ? state.on_device->meshes()
                                                                     : std::vector<Mesh>());
}

}  // namespace knead
