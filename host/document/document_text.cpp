#include "host/document/document_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/document/command_table.h"
#include "host/scene/domain.h"
#include "host/scene/names.h"
#include "host/scene/object_json.h"

namespace knead {
namespace {

// Places of a scene may exceed their range by the rounding of Scene::origin.
constexpr Bounds place{-1000.001, 1000.001, "m"};
// A scene may have twice as many nodes as a command, on a lattice that move_in() has enlarged.
constexpr int most_lattice_nodes = 8 * most_surface_nodes;

Json triple(Vec3<double> v) { return {v.x, v.y, v.z}; }

template <class Body>
void required_object(ObjectReader& r, const std::string& key, const Body& body)
{
    r.required(key, "an object");
    r.object(key, body);
}
bool required_flag(ObjectReader& r, const std::string& key)
{
    r.required(key, "true or false");
    return r.flag(key, false);
}
int required_whole(ObjectReader& r, const std::string& key, int low, int high)
{
    r.required(key, fmt::format("a whole number from {} to {}", low, high));
    return r.whole(key, low, high, low);
}

// The file as it was written: other readers make it absolute.
std::string file_in(ObjectReader& r, const std::string& folder)
{
    namespace fs = std::filesystem;
    const std::string file = r.text("file", "");
    return folder.empty() || fs::path(file).is_absolute() ? file
                                                          : (fs::path(folder) / file).string();
}

SceneObject object_in(ObjectReader& r, const std::string& folder)
{
    r.required("id", "its number");
    SceneObject o = read_scene_object(r, folder.empty() ? "." : folder);
    if (o.source.shape == ShapeKind::splats) o.source.splats.file = file_in(r, folder);
    if (o.source.shape == ShapeKind::mesh) o.source.mesh.file = file_in(r, folder);
    return o;
}

// The rules of several objects, as reduce() has them. `last`: the object just read.
void check_among(const Document& d, const SceneObject& last, const ObjectReader& r)
{
    const auto splats = [](const SceneObject& o) { return o.source.shape == ShapeKind::splats; };
    const auto local = [&](const SceneObject& o) { return splats(o) && o.source.splats.depth > 0; };
    if (!d.objects.empty() && d.objects.back()->id >= last.id)
        r.fail("id", fmt::format("a number above {}, the one before", d.objects.back()->id.value),
               std::to_string(last.id.value));
    for (const auto& o : d.objects) {
        if (o->category == last.category && splats(*o) != splats(last))
            r.fail("category", "another category for objects of splats than for other clay",
                   fmt::format("{}, that of object {}", last.category, o->id.value));
        if (local(*o) && local(last)) r.fail("depth", "at most one object with a depth", "another");
    }
}

void read_objects(ObjectReader& r, const std::string& folder, Document& d)
{
    const Json& list = r.required("objects", "an array of objects");
    if (!list.is_array() || list.size() > std::size_t(most_objects))
        r.fail("objects", fmt::format("an array of at most {} objects", most_objects),
               described(list));
    for (std::size_t i = 0; i < list.size(); ++i)
        ObjectReader::read(
            list[i], r.file(), fmt::format("{}/{}", r.pointer("objects"), i),
            [&](ObjectReader& in) {
                SceneObject o = object_in(in, folder);
                check_among(d, o, in);
                d.objects.push_back(std::make_shared<const SceneObject>(std::move(o)));
            });
}

WallOptions walls_in(ObjectReader& r)
{
    WallOptions walls{};
    walls.min = r.vector("min", place), walls.max = r.vector("max", place);
    const Vec3<double> room = walls.max - walls.min;
    if (!(std::min({room.x, room.y, room.z}) > 0))
        r.fail("max", "each component above that of min", "another");
    r.required("contact_mode", "a name");
    walls.mode = r.choice("contact_mode", contact_modes, walls.mode);
    walls.friction = r.number("friction", {0, 10});
    return walls;
}

SceneSettings settings_in(ObjectReader& r)
{
    SceneSettings s;
    s.gravity = r.vector("gravity", {-most_gravity, most_gravity, "m/s^2"});
    required_object(r, "walls", [&](ObjectReader& in) { s.walls = walls_in(in); });
    if (r.has("contact"))
        r.object("contact", [&](ObjectReader& in) {
            in.required("categories", "a name");
            s.contact.separate = in.choice("categories", category_contacts, false);
            s.contact.friction = in.number("friction", {0, most_body_friction});
        });
    s.cells = required_whole(r, "cells", 8, 1024);
    s.surface_nodes = required_whole(r, "surface", fewest_surface_nodes, most_lattice_nodes);
    return s;
}

HandSettings hands_in(ObjectReader& r)
{
    HandSettings h;
    const auto side = [&](Side of, ObjectReader& in) {
        h.present[of] = required_flag(in, "present");
        in.required("held", "a tool, or \"\": the bare hand");
        h.held[of] = in.text("held", "");
        const std::vector<std::string> tools = tool_names();
        if (!h.held[of].empty() && std::ranges::find(tools, h.held[of]) == tools.end())
            in.fail("held", "a tool, or \"\": the bare hand",
                    "\"" + h.held[of].substr(0, 60) + "\"");
    };
    required_object(r, "left", [&](ObjectReader& in) { side(left, in); });
    required_object(r, "right", [&](ObjectReader& in) { side(right, in); });
    h.zoom = r.number("zoom", {0.01, 1000, "simulation metres per real metre"});
    h.at = r.vector("at", place);
    return h;
}

}  // namespace

Json json_of(const SceneObject& object)
{
    Json of = json_of(object_of(object));
    if (object.source.shape == ShapeKind::splats) of["file"] = object.source.splats.file;
    if (object.source.shape == ShapeKind::mesh) of["file"] = object.source.mesh.file;
    if (object.id.value) of["id"] = object.id.value;
    if (object.locked) of["locked"] = true;
    if (object.hidden) of["hidden"] = true;
    if (object.colour) of["colour"] = triple(*object.colour);
    return of;
}

SceneObject read_scene_object(ObjectReader& r, const std::string& folder)
{
    SceneObject o = scene_object(read_object(r, "", folder), {});
    o.id = {std::uint32_t(r.whole("id", 1, int(highest_id), 0))};
    o.locked = r.flag("locked", false);
    o.hidden = r.flag("hidden", false);
    if (r.has("colour")) o.colour = r.vector("colour", {0, 1});
    return o;
}

std::string document_text(const Document& d)
{
    Json objects = Json::array();
    for (const auto& o : d.objects) objects.push_back(json_of(*o));
    const SceneSettings& s = *d.scene;
    const HandSettings& h = *d.hands;
    const auto hand = [&](Side side) {
        return Json{{"present", h.present[side]}, {"held", h.held[side]}};
    };
    Json text{
        {"objects", std::move(objects)},
        {"gravity", triple(s.gravity)},
        {"walls", json_of(s.walls)},
        {"cells", s.cells},
        {"surface", s.surface_nodes},
        {"hands",
         {{"left", hand(left)}, {"right", hand(right)}, {"zoom", h.zoom}, {"at", triple(h.at)}}}};
    // Not written if it is that of documents of before it existed.
    if (s.contact != BodyContact{})
        text["contact"] = {{"categories", name_of(category_contacts, s.contact.separate)},
                           {"friction", s.contact.friction}};
    return text.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Document parse_document(const std::string& text, const std::string& file, const std::string& folder)
{
    Document d;
    ObjectReader::read(parse_json(text, file), file, "", [&](ObjectReader& r) {
        d.scene = std::make_shared<const SceneSettings>(settings_in(r));
        required_object(r, "hands", [&](ObjectReader& in) {
            d.hands = std::make_shared<const HandSettings>(hands_in(in));
        });
        read_objects(r, folder, d);
    });
    return d;
}

}  // namespace knead
