#include "host/document/document.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <map>

#include "host/assets/mesh_object.h"
#include "host/document/document_text.h"
#include "host/scene/domain.h"
#include "host/scene/object_json.h"
#include "host/scene/shapes.h"
#include "host/scene/soften.h"

namespace knead {
namespace {

bool same(double a, double b)
{
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool same(Vec3<double> a, Vec3<double> b)
{
    return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}
bool same(Quat<double> a, Quat<double> b)
{
    return same(a.w, b.w) && same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}
bool same(const SplatsOptions& a, const SplatsOptions& b)
{
    return a.file == b.file && a.up == b.up && same(a.size, b.size) && same(a.turn, b.turn) &&
           same(a.depth, b.depth);
}
template <class T>
bool same(const std::shared_ptr<const T>& a, const std::shared_ptr<const T>& b)
{
    return a == b || (a && b && equal(*a, *b));
}
bool same(const MeshOptions& a, const MeshOptions& b)
{
    return a.file == b.file && a.up == b.up && same(a.turn, b.turn) && same(a.size, b.size) &&
           same(a.scale, b.scale) && same(a.hollow, b.hollow);
}
bool same(const ObjectSource& a, const ObjectSource& b)
{
    return a.shape == b.shape && same(a.size, b.size) && same(a.velocity, b.velocity) &&
           same(a.per_cell, b.per_cell) && same(a.splats, b.splats) &&
           same(a.rounding, b.rounding) && a.text == b.text && same(a.strand, b.strand) &&
           same(a.mesh, b.mesh);
}

}  // namespace

const SceneObject* Document::find(ObjectId id) const
{
    const auto at = std::ranges::find_if(objects, [&](const auto& o) { return o->id == id; });
    return at == objects.end() ? nullptr : at->get();
}

std::vector<int> Document::hidden_categories() const
{
    std::map<int, bool> hidden;
    for (const auto& o : objects) hidden.try_emplace(o->category, true).first->second &= o->hidden;
    std::vector<int> all;
    for (const auto& [category, is] : hidden)
        if (is) all.push_back(category);
    return all;
}

Vec3<double> own_extents(const SceneObject& of)
{
    Object o = object_of(of);
    o.rotation = {1, 0, 0, 0};
    return extents(o);
}

bool has_nozzle(const Document& document)
{
    return std::ranges::any_of(document.objects, [](const auto& o) { return is_open(*o); });
}

bool has_velocity(const Document& document)
{
    return std::ranges::any_of(document.objects, [](const auto& o) {
        return dot(o->source.velocity, o->source.velocity) > 0;
    });
}

bool equal(Vec3<double> a, Vec3<double> b) { return same(a, b); }
bool equal(const MaterialSpec& a, const MaterialSpec& b)
{
    return a.name == b.name && a.elasticity == b.elasticity && a.plasticity == b.plasticity &&
           std::ranges::all_of(material_quantities(), [&](const MaterialQuantity& q) {
               return same(a.*q.value, b.*q.value);
           });
}
bool equal(const SceneObject& a, const SceneObject& b)
{
    return a.id == b.id && a.name == b.name && a.category == b.category &&
           equal(a.material, b.material) && same(a.pose.q, b.pose.q) && same(a.pose.p, b.pose.p) &&
           same(a.source, b.source) && a.locked == b.locked && a.hidden == b.hidden &&
           a.colour.has_value() == b.colour.has_value() &&
           (!a.colour || same(*a.colour, *b.colour));
}
bool equal(const SceneSettings& a, const SceneSettings& b)
{
    return same(a.gravity, b.gravity) && same(a.walls.min, b.walls.min) &&
           same(a.walls.max, b.walls.max) && a.walls.mode == b.walls.mode &&
           same(a.walls.friction, b.walls.friction) && a.contact.separate == b.contact.separate &&
           same(a.contact.friction, b.contact.friction) && a.cells == b.cells &&
           a.surface_nodes == b.surface_nodes;
}
bool equal(const HandSettings& a, const HandSettings& b)
{
    return std::ranges::equal(a.held, b.held) && std::ranges::equal(a.present, b.present) &&
           same(a.zoom, b.zoom) && same(a.at, b.at);
}
bool equal(const Document& a, const Document& b)
{
    return same(a.scene, b.scene) && same(a.hands, b.hands) &&
           std::ranges::equal(a.objects, b.objects,
                              [](const auto& one, const auto& other) { return same(one, other); });
}

std::uint64_t hash(const Document& document)
{
    const std::string text = document_text(document);
    return XXH64(text.data(), text.size(), 0);
}

SceneObject scene_object(const Object& o, ObjectId id)
{
    const bool splats = o.shape == ShapeKind::splats;
    return {id,
            o.name,
            o.category,
            normalised(o.stated),
            {o.rotation, o.centre},
            {o.shape, splats ? Vec3<double>{} : o.size, o.velocity, o.per_cell,
             splats ? o.splats : SplatsOptions{}, o.rounding, o.text, o.strand,
             o.shape == ShapeKind::mesh ? o.mesh : MeshOptions{}},
            false,
            false};
}

Object object_of(const SceneObject& of)
{
    Object o;
    o.name = of.name, o.category = of.category;
    o.shape = of.source.shape, o.size = of.source.size, o.velocity = of.source.velocity;
    o.per_cell = of.source.per_cell, o.splats = of.source.splats;
    o.rounding = of.source.rounding, o.text = of.source.text, o.strand = of.source.strand;
    add_letters(o);
    o.mesh = of.source.mesh, o.solid = known_solid(o);
    o.centre = of.pose.p, o.rotation = of.pose.q;
    o.stated = of.material;
    o.material = made(of.material), o.material.category = of.category;
    return o;
}

HandsOptions hands_with(HandsOptions hands, const HandSettings& by, Vec3<double> origin)
{
    for (const Side side : {left, right})
        hands.held[side] = by.held[side], hands.present[side] = by.present[side];
    hands.zoom = by.zoom, hands.at = by.at - origin;
    return hands;
}

HandSettings settings_of(const HandsOptions& hands, Vec3<double> origin)
{
    HandSettings s;
    for (const Side side : {left, right})
        s.held[side] = hands.held[side], s.present[side] = hands.present[side];
    s.zoom = hands.zoom, s.at = hands.at + origin;
    return s;
}

Document document_of(const Scene& scene)
{
    Document d;
    for (const Object& o : scene.objects) {
        SceneObject of = scene_object(o, {std::uint32_t(d.objects.size() + 1)});
        of.pose.p = of.pose.p + scene.origin;
        d.objects.push_back(std::make_shared<const SceneObject>(std::move(of)));
    }
    SceneSettings s;
    s.gravity = scene.setup.gravity;
    s.walls = scene.setup.walls;
    s.walls.min = s.walls.min + scene.origin, s.walls.max = s.walls.max + scene.origin;
    s.contact = scene.setup.contact;
    const Int3 cells = scene.stated_cells, nodes = scene.surface.lattice.size;
    s.cells = std::max({cells.x, cells.y, cells.z});
    s.surface_nodes = std::max({nodes.x, nodes.y, nodes.z});
    d.scene = std::make_shared<const SceneSettings>(s);
    HandSettings hands = settings_of(scene.hands, scene.origin);
    if (!scene.has_hands) hands.present[left] = hands.present[right] = false;
    d.hands = std::make_shared<const HandSettings>(std::move(hands));
    return d;
}

Scene scene_of(Scene scene, const Document& d)
{
    const Document before = document_of(scene);
    move_out(scene);
    scene.objects.clear();
    for (const auto& o : d.objects) scene.objects.push_back(object_of(*o));
    scene.setup.gravity = d.scene->gravity;
    scene.setup.walls = d.scene->walls;
    scene.setup.contact = d.scene->contact;
    if (d.scene->surface_nodes != before.scene->surface_nodes) {
        scene.surface_nodes = d.scene->surface_nodes;
        scene.surface.lattice = surface_lattice(scene.setup.lattice, d.scene->surface_nodes);
    }
    if (!equal(*d.hands, *before.hands))
        scene.hands = hands_with(scene.hands, *d.hands, {}), scene.has_hands = true;
    soften(scene);
    move_in(scene);
    return scene;
}

}  // namespace knead
