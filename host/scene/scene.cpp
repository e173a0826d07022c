// Reads scenes from JSON. Every key appears once, here or in what this calls, with unit, range and
// default; docs/reference/formats.md documents the same.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "cuda/mpm/body_graph.h"
#include "host/hands/gesture.h"
#include "host/scene/domain.h"
#include "host/scene/names.h"
#include "host/scene/object_json.h"
#include "host/scene/soften.h"
#include "host/scene/splats_options.h"

namespace knead {
namespace {

constexpr int max_objects = 256;

void read_step(ObjectReader& r, Scene& scene)
{
    StepOptions& step = scene.setup.step;
    step.fixed = r.number("fixed", {0, 1, "s"}, step.fixed);
    step.courant = r.number("courant", {0, 1, "", true}, step.courant);
    step.tool = r.number("tool", {0, 1, "", true}, step.tool);
    step.largest = r.number("largest", {0, 1, "s", true}, step.largest);
    scene.most_substeps = r.whole("most_substeps", 1, 2000000000, scene.most_substeps);
    scene.soften_beyond = r.whole("soften_beyond", 0, 1000000, scene.soften_beyond);
}

// For the origin of the defaults see docs/method/model.md.  (29), (30)
void read_rest(ObjectReader& r, Scene& scene)
{
    Rest<double>& rest = scene.setup.rest;
    rest.mode = r.choice<RestMode>(
        "mode",
        {{"none", RestMode::none}, {"sleep", RestMode::sleep}, {"localized", RestMode::localized}},
        RestMode::none);
    const auto creeps = [](const Object& o) {
        return o.material.plasticity == Plasticity::fluid ||
               o.material.plasticity == Plasticity::herschel_bulkley;
    };
    const bool creep = std::any_of(scene.objects.begin(), scene.objects.end(), creeps);
    const double weight = length(scene.setup.gravity), frame = frame_duration(scene);
    rest.push = r.number("acceleration", {0, 1e6, "m/s^2", true}, weight > 0 ? weight / 2 : 5);
    rest.speed =
        r.number("speed", {0, 1000, "m/s", true}, min(creep ? 0.005 : 0.05, rest.push * frame));
    rest.frames = r.whole("frames", 1, 1000000, min(int(std::ceil(0.1 / frame - 1e-9)), 1000000));
    // Two radii of the pressing tool: clay at rest then does not yield under a dent. Two radii of a
    // fingertip are 20 mm.
    const double dx = scene.setup.lattice.dx, wide = max(8 * dx, 0.02 * scene.hands.zoom);
    const bool holds = rest.mode == RestMode::localized;
    rest.reach = r.number("reach", {0, 1000, "m"}, holds ? wide : 4 * dx);
    const bool local = std::any_of(scene.objects.begin(), scene.objects.end(),
                                   [](const Object& o) { return o.local(); });
    if (local && !holds)
        r.fail("mode", "\"localized\" for a scene with an object that has a `depth`", "another");
    if (holds && !scene.has_hands)
        r.fail("mode", "\"none\" or \"sleep\" for a scene without hands", "\"localized\"");
}

void read_objects(ObjectReader& r, Scene& scene)
{
    const Json& list = r.required("objects", "an array of objects");
    if (!list.is_array() || list.size() > max_objects)
        r.fail("objects", fmt::format("an array of at most {} objects", max_objects),
               described(list));
    for (std::size_t i = 0; i < list.size(); ++i)
        ObjectReader::read(list[i], r.file(), r.pointer("objects") + "/" + std::to_string(i),
                           [&](ObjectReader& o) {
                               scene.objects.push_back(read_object(o, fmt::format("object {}", i)));
                           });
    const auto local = [](const Object& o) { return o.local(); };
    if (std::count_if(scene.objects.begin(), scene.objects.end(), local) > 1)
        r.fail("objects", "at most one object with a depth", "several");
    // The clay of a category is drawn either as one surface or as splats.
    for (const Object& a : scene.objects)
        for (const Object& b : scene.objects)
            if (a.category == b.category && a.shape == ShapeKind::splats &&
                b.shape != ShapeKind::splats)
                r.fail(
                    "objects", "another category for objects of splats than for other clay",
                    fmt::format("category {} of \"{}\" and of \"{}\"", a.category, a.name, b.name));
}

void read_side(ObjectReader& r, HandsOptions& hands, Side side)
{
    hands.present[side] = r.flag("present", true);
    hands.held[side] = r.text("held", hands.held[side]);
    if (hands.held[side].empty()) return;
    try {
        tool_rig(hands.held[side], side);
    } catch (const std::invalid_argument& e) {
        r.fail("held", "a tool (slab, rod, cone, ball, knife, scissors)",
               fmt::format("\"{}\" ({})", hands.held[side].substr(0, 60), e.what()));
    }
}

// A gesture also sets the tools that it needs.
void read_recording_name(ObjectReader& r, HandsOptions& hands)
{
    namespace fs = std::filesystem;
    const std::string name = r.text("recording", "squeeze");
    std::vector<std::string> known;
    for (const Gesture& g : gestures()) {
        known.push_back(g.name);
        if (g.name != name) continue;
        hands.recording = name;
        for (Side side : {left, right}) hands.held[side] = g.held[side];
        return;
    }
    if (!fs::path(name).has_extension())
        r.fail("recording", "a gesture or a file (.hands, .jsonl)",
               "\"" + name.substr(0, 60) + "\"; the nearest gesture is \"" +
                   nearest_name(name, known) + "\"");
    hands.recording = r.beside("recording", name, " (--hands takes any path)");
}

void read_hands(ObjectReader& r, Scene& scene)
{
    HandsOptions& h = scene.hands;
    read_recording_name(r, h);
    h.zoom = r.number("zoom", {0.01, 1000, "simulation metres per real metre"}, 1);
    h.at = r.vector("at", {-1000, 1000, "m"}, h.at);
    h.topology = r.choice<Topology>("topology", {{"h25", Topology::h25}, {"h47", Topology::h47}},
                                    Topology::h25);
    r.refuse_renamed("touch", "contact_mode");
    h.mode = r.choice("contact_mode", contact_modes, ContactMode::separate);
    h.friction = r.number("friction", {0, 10}, 0.4);
    h.filter = r.choice<Filter>(
        "filter",
        {{"none", Filter::none}, {"average", Filter::average}, {"adaptive", Filter::adaptive}},
        Filter::adaptive);
    r.object("left", [&](ObjectReader& in) { read_side(in, h, left); });
    r.object("right", [&](ObjectReader& in) { read_side(in, h, right); });
}

void read_surface(ObjectReader& r, Scene& scene)
{
    const int nodes = scene.surface_nodes = r.whole("nodes", 0, 2048, 0);
    if (nodes > 0 && nodes < 8)
        r.fail("nodes", "0 (twice the domain's cells) or 8 to 2048", std::to_string(nodes));
    scene.surface.lattice = stated_surface(scene);
    scene.surface.iso = float(r.number("iso", {0.01, 0.99, "of the rest density"}, 0.5));
    scene.surface.smoothing = r.choice<Smoothing>(
        "smoothing",
        {{"none", Smoothing::none}, {"laplace", Smoothing::laplace}, {"taubin", Smoothing::taubin}},
        Smoothing::taubin);
    scene.surface.iterations = r.whole("iterations", 0, 100, 5);
}

void read_pictures(ObjectReader& r, Scene& scene)
{
    scene.picture_every = r.whole("every", 0, 1000000, 0);
    scene.picture_width = r.whole("width", 16, 8192, scene.picture_width);
    scene.picture_height = r.whole("height", 16, 8192, scene.picture_height);
    scene.captions = read_captions(r);
}

void read_camera(ObjectReader& r, Scene& scene)
{
    scene.eye = r.vector("eye", {-1000, 1000, "m"}, scene.eye);
    scene.target = r.vector("target", {-1000, 1000, "m"}, scene.target);
    const Vec3<double> way = scene.target - scene.eye;
    if (!(dot(way, way) > 1e-12)) r.fail("target", "another point than the eye", "the same");
}

void read_time(ObjectReader& r, Scene& scene)
{
    scene.clock = r.choice<ClockMode>(
        "clock", {{"wall", ClockMode::wall}, {"paper", ClockMode::paper}}, ClockMode::wall);
    scene.frame_rate = r.number("frame_rate", {1, 1000, "frames/s"}, 90);
    scene.frames = r.whole("frames", 0, 10000000, 0);
    r.object("paper", [&](ObjectReader& in) {
        scene.paper_substeps = in.whole("substeps", 1, 10000, 5);
        scene.paper_dt = in.number("dt", {0, 1, "s", true}, 1e-4);
    });
    r.object("step", [&](ObjectReader& in) { read_step(in, scene); });
    if (scene.clock == ClockMode::paper && scene.setup.step.fixed == 0)
        scene.setup.step.fixed = scene.paper_dt;
}

// After objects and hands: bodies have velocity fields, and there may be so many.
void read_contact(ObjectReader& r, Scene& scene)
{
    Setup& setup = scene.setup;
    setup.grid_contact = r.flag("grid", true);
    setup.passes = r.whole("passes", 0, 16, Setup{}.passes);
    setup.contact.separate = r.choice("categories", category_contacts, false);
    setup.contact.friction = r.number("friction", {0, most_body_friction}, BodyContact{}.friction);
    scene.own_pieces = r.flag("pieces", false);
    if (!setup.contact.separate) return;
    std::set<int> categories;
    for (const Object& o : scene.objects) categories.insert(o.category);
    if (categories.size() > std::size_t(most_bodies))
        r.fail("categories",
               fmt::format("\"weld\", or objects of at most {} categories", most_bodies),
               fmt::format("\"separate\" with {}", categories.size()));
}

void read_root(ObjectReader& r, Scene& scene)
{
    const Json& schema = r.required("schema", "\"knead.scene/1\"");
    if (schema != "knead.scene/1") r.fail("schema", "\"knead.scene/1\"", described(schema));
    scene.name = r.text("name", std::filesystem::path(scene.path).stem().string());
    r.object("domain", [&](ObjectReader& in) { read_domain(in, scene); });
    r.object("walls", [&](ObjectReader& in) { read_walls(in, scene); });
    scene.setup.gravity =
        r.vector("gravity", {-most_gravity, most_gravity, "m/s^2"}, {0, -9.81, 0});
    read_objects(r, scene);
    scene.has_hands = r.has("hands");
    const WallOptions& walls = scene.setup.walls;
    if (scene.objects.empty())
        scene.hands.at = 0.5 * (walls.min + walls.max);
    else if (scene.has_hands)
        scene.hands.at = scene.objects[0].centre;
    if (scene.has_hands) r.object("hands", [&](ObjectReader& in) { read_hands(in, scene); });
    r.object("contact", [&](ObjectReader& in) { read_contact(in, scene); });
    read_time(r, scene);
    r.object("rest", [&](ObjectReader& in) { read_rest(in, scene); });
    r.object("splats", [&](ObjectReader& in) { read_upkeep(in, scene.upkeep); });
    r.object("surface", [&](ObjectReader& in) { read_surface(in, scene); });
    r.object("pictures", [&](ObjectReader& in) { read_pictures(in, scene); });
    r.object("camera", [&](ObjectReader& in) { read_camera(in, scene); });
    scene.seed = unsigned(r.whole("seed", 0, std::numeric_limits<int>::max(), 1));
    scene.setup.deterministic = r.flag("deterministic", false);
    soften(scene);
    move_in(scene);
}

// --set objects.0.material.young=2e6: descends into objects and arrays; a preset name on the path
// is expanded to {"preset": name}.
void apply(const std::string& setting, Json& root)
{
    const std::string said = "--set " + setting.substr(0, 200);
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
        throw InputError(said + ": expected path.key=value");
    Json* at = &root;
    std::string walked;
    for (std::size_t from = 0; from <= equals;) {
        const std::size_t to = std::min(setting.find('.', from), equals);
        const std::string key = setting.substr(from, to - from);
        if (key.empty()) throw InputError(said + ": an empty key in the path");
        if (at->is_array()) {
            const bool digits = key.find_first_not_of("0123456789") == std::string::npos;
            const std::size_t i = digits && key.size() < 9 ? std::stoul(key) : at->size();
            if (i >= at->size())
                throw InputError(fmt::format("{}: {}: expected an index below {}, found \"{}\"",
                                             said, walked, at->size(), key));
            at = &(*at)[i];
        } else {
            if (at->is_string()) *at = {{"preset", *at}};
            if (!at->is_object() && !at->is_null())
                throw InputError(fmt::format("{}: {}: expected an object, found {}", said, walked,
                                             described(*at)));
            at = &(*at)[key];
        }
        walked += "/" + key;
        from = to + 1;
    }
    const std::string value = setting.substr(equals + 1);
    Json parsed = Json::parse(value, nullptr, false);
    *at = parsed.is_discarded() ? Json(value) : parsed;
}

}  // namespace

void need_objects(const Scene& scene)
{
    if (!scene.objects.empty()) return;
    throw InputError(fmt::format("{}: /objects: expected an array of 1 to {} objects, found {}",
                                 scene.path, max_objects, described(Json::array())));
}

double frame_duration(const Scene& s)
{
    return s.clock == ClockMode::paper ? s.paper_substeps * s.paper_dt : 1 / s.frame_rate;
}

Scene parse_scene(const std::string& text, const std::string& path,
                  const std::vector<std::string>& settings)
{
    Json root = parse_json(text, path);
    for (const std::string& setting : settings) apply(setting, root);
    Scene scene;
    scene.path = path;
    ObjectReader::read(root, path, "", [&](ObjectReader& r) { read_root(r, scene); });
    return scene;
}

Scene read_scene(const std::string& path, const std::vector<std::string>& settings)
{
    return parse_scene(read_text(path, max_json_bytes), path, settings);
}

}  // namespace knead
