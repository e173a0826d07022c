#include "host/document/reduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "cuda/math/rotation.h"
#include "host/document/command_table.h"
#include "host/document/export_plan.h"
#include "host/scene/object_json.h"
#include "host/scene/presets.h"
#include "host/scene/seed.h"
#include "host/scene/shapes.h"
#include "host/surface/mesh.h"

namespace knead {
namespace {

struct Refused {
    Refusal refusal;
};
[[noreturn]] void refuse(const std::string& field, const std::string& why)
{
    throw Refused{{why, field}};
}

const SceneObject& object_in(const Document& d, const ObjectRef& ref, const std::string& field)
{
    if (const ObjectId* id = std::get_if<ObjectId>(&ref.by)) {
        if (const SceneObject* found = d.find(*id)) return *found;
        refuse(field, fmt::format("there is no object {}", id->value));
    }
    const std::string& name = std::get<std::string>(ref.by);
    const SceneObject* found = nullptr;
    int count = 0;
    for (const auto& o : d.objects)
        if (o->name == name) found = o.get(), ++count;
    if (count == 1) return *found;
    std::vector<std::string> names;
    for (const auto& o : d.objects) names.push_back(o->name);
    const std::string near = count == 0 ? likely_name(name, names) : "";
    refuse(field, count == 0
                      ? fmt::format("there is no object \"{}\"{}", name.substr(0, 60),
                                    near.empty() ? "" : "; the nearest name is \"" + near + "\"")
                      : fmt::format("{} objects have the name \"{}\": give a number", count,
                                    name.substr(0, 60)));
}

// JSON, and with it a log, holds no other texts.
bool is_utf8(const std::string& text)
{
    try {
        Json(text).dump();
        return true;
    } catch (const Json::type_error&) {
        return false;
    }
}

// Numbers of a command from a panel or a program, which no reader has checked.
void check_range(const char* field, double value, const Bounds& range)
{
    const bool low = range.above ? value > range.low : value >= range.low;
    if (low && value <= range.high) return;
    refuse(field, fmt::format("expected {}, found {}", described(range), short_number(value)));
}
struct CheckRanges {
    template <class F>
    void operator()(const F& f, double value) const
    {
        check_range(f.key, value, f.range);
    }
    template <class F>
    void operator()(const F& f, int value) const
    {
        check_range(f.key, value, f.range);
    }
    template <class F>
    void operator()(const F& f, const Vec3<double>& v) const
    {
        for (const double x : {v.x, v.y, v.z}) check_range(f.key, x, f.range);
    }
    template <class F>
    void operator()(const F& f, const std::vector<int>& numbers) const
    {
        for (const int number : numbers) check_range(f.key, number, f.range);
    }
    template <class F>
    void operator()(const F& f, const Quat<double>& q) const
    {
        const double size = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
        if (!(size > 0.999 && size < 1.001))
            refuse(f.key, "expected a quaternion [w, x, y, z] of length 1, found one of length " +
                              short_number(size));
    }
    template <class F>
    void operator()(const F& f, const std::string& text) const
    {
        if (text.size() > 1000) refuse(f.key, "expected at most 1000 bytes of text");
        if (!is_utf8(text)) refuse(f.key, "expected text in UTF-8");
    }
    template <class F, class T>
    void operator()(const F& f, const std::optional<T>& value) const
    {
        if (value) (*this)(f, *value);
    }
    template <class F>
    void operator()(const F&, const SetHand& hand) const
    {
        for_each_field(hand, *this);
    }
    // Errors name the field of the command.
    template <class F>
    void operator()(const F& f, const SplitPlane& plane) const
    {
        for_each_field(plane, [&](const auto& part, const Vec3<double>& v) {
            for (const double x : {v.x, v.y, v.z}) check_range(f.key, x, part.range);
        });
    }
    template <class F, class T>
    void operator()(const F&, const T&) const
    {
    }
};

class Reduction {
  public:
    Reduction(const DocumentPtr& from, IdSource& source) : d(*from), ids(source), same(from) {}

    DocumentPtr operator()(const AddObject& c)
    {
        SceneObject added = c.object;
        if (int(d.objects.size()) >= most_objects)
            refuse("object", fmt::format("a scene has at most {} objects", most_objects));
        if (added.id.value > highest_id)
            refuse("object", fmt::format("expected a number of at most {}", highest_id));
        if (added.id.value && ids.used(added.id))
            refuse("object", fmt::format("the number {} has been used", added.id.value));
        if (!added.id.value && ids.most() >= highest_id)
            refuse("object", "all numbers have been used");
        check_object(added, "object");
        if (added.id.value)
            ids.use(added.id);
        else
            added.id = ids.next();
        added.material = normalised(added.material);
        if (added.source.shape == ShapeKind::splats)
            added.source.size = {};
        else
            added.source.splats = {};
        if (added.source.shape == ShapeKind::mesh)
            added.source.size = {};
        else
            added.source.mesh = {};
        if (added.source.shape != ShapeKind::rounded_box) added.source.rounding = 0;
        if (added.source.shape == ShapeKind::text)
            added.source.size.x = 0;
        else
            added.source.text.clear();
        if (added.source.shape == ShapeKind::strand)
            added.source.size = {};
        else
            added.source.strand.reset();
        if (added.name.empty()) added.name = fmt::format("object {}", added.id.value);
        Document next = d;
        next.objects.push_back(std::make_shared<const SceneObject>(std::move(added)));
        return done(std::move(next));
    }

    DocumentPtr operator()(const RemoveObjects& c)
    {
        if (c.objects.empty()) refuse("objects", "expected at least one object");
        Document next = d;
        for (const ObjectRef& ref : c.objects) {
            const ObjectId id = changeable(ref, "objects").id;
            if (std::erase_if(next.objects, [&](const auto& o) { return o->id == id; }) == 0)
                refuse("objects", fmt::format("object {} is named twice", id.value));
        }
        return done(std::move(next));
    }

    DocumentPtr operator()(const PlaceObject& c)
    {
        SceneObject o = changeable(c.object);
        if (c.centre) o.pose.p = *c.centre;
        if (c.rotation) o.pose.q = unit_rotation(*c.rotation);
        check_walls(o, c.centre ? "centre" : "rotation");
        return replaced(o);
    }

    DocumentPtr operator()(const SetMaterial& c)
    {
        SceneObject o = changeable(c.object);
        o.material = normalised(c.material);
        check_material(o.material, "material");
        return replaced(o);
    }

    DocumentPtr operator()(const SetCategory& c)
    {
        SceneObject o = changeable(c.object);
        o.category = c.category;
        check_category(o, "category");
        return replaced(o);
    }

    DocumentPtr operator()(const Rename& c)
    {
        SceneObject o = changeable(c.object);
        if (c.name.empty()) refuse("name", "expected a name");
        o.name = c.name;
        return replaced(o);
    }

    DocumentPtr operator()(const SetFlags& c)
    {
        SceneObject o = object_in(d, c.object, "object");
        if (c.locked) o.locked = *c.locked;
        if (c.hidden) o.hidden = *c.hidden;
        return replaced(o);
    }

    DocumentPtr operator()(const SetColour& c)
    {
        check_list(c.objects);
        Document next = d;
        bool changes = false;
        for (const ObjectRef& ref : c.objects) {
            SceneObject o = changeable(ref, "objects");
            changes = changes || o.colour.has_value() != c.colour.has_value() ||
                      (c.colour && !equal(*o.colour, *c.colour));
            o.colour = c.colour;
            replace_in(next, std::move(o));
        }
        return changes ? done(std::move(next)) : same;
    }

    DocumentPtr operator()(const CopyObjects& c)
    {
        check_list(c.objects);
        check_names(c.names, c.objects.size());
        const std::vector<ObjectId> numbers = new_numbers(c.ids, c.objects.size(), "objects");
        Document next = d;
        for (std::size_t i = 0; i < c.objects.size(); ++i) {
            SceneObject o = object_in(d, c.objects[i], "objects");
            check_whole(o, "objects");
            o.id = numbers[i], o.locked = false;
            if (is_open(o)) refuse("objects", "a nozzle lays \"" + o.name.substr(0, 60) + "\"");
            o.name = i < c.names.size() ? c.names[i] : numbered(o.name, " copy");
            o.pose.p = o.pose.p + c.by;
            CheckRanges{}(command_field("by", &CopyObjects::by, "", anywhere), o.pose.p);
            next.objects.push_back(std::make_shared<const SceneObject>(std::move(o)));
        }
        ids.use(numbers.back());
        return done(std::move(next));
    }

    // Without the point to turn about, which the clay decides, as if it were the origin.
    DocumentPtr operator()(const MoveObjects& c)
    {
        check_list(c.objects);
        const Quat<double> q = c.turn ? unit_rotation(*c.turn) : Quat<double>{1, 0, 0, 0};
        const Vec3<double> by = c.by.value_or(Vec3<double>{}),
                           about = c.about.value_or(Vec3<double>{});
        const bool turns = c.turn && !(q.x == 0 && q.y == 0 && q.z == 0);
        const bool moves = turns || !(by.x == 0 && by.y == 0 && by.z == 0);
        Document next = d;
        for (const ObjectRef& ref : c.objects) {
            SceneObject o = changeable(ref, "objects");
            check_whole(o, "objects");
            if (turns) {
                o.pose.p = about + rotate(q, o.pose.p - about);
                o.pose.q = unit_rotation(unit(q * o.pose.q));
            }
            o.pose.p = o.pose.p + by;
            CheckRanges{}(command_field(turns ? "turn" : "by", &CopyObjects::by, "", anywhere),
                          o.pose.p);
            replace_in(next, std::move(o));
        }
        return moves ? done(std::move(next)) : same;
    }

    // Of the document nothing changes, but it is another one: there is a step.
    DocumentPtr operator()(const ResetObjects& c)
    {
        check_list(c.objects);
        for (const ObjectRef& ref : c.objects) {
            const SceneObject& o = changeable(ref, "objects");
            check_whole(o, "objects");
            if (o.source.shape == ShapeKind::splats)
                refuse("objects", "\"" + o.name.substr(0, 60) + "\" is of splats");
            if (is_open(o)) refuse("objects", "a nozzle lays \"" + o.name.substr(0, 60) + "\"");
        }
        return done(d);
    }

    DocumentPtr operator()(const ScaleObjects& c)
    {
        check_list(c.objects);
        Document next = d;
        for (const ObjectRef& ref : c.objects) {
            SceneObject o = changeable(ref, "objects");
            check_whole(o, "objects");
            if (c.factor == 1) continue;
            double& splats = o.source.splats.size;
            o.source.size = c.factor * o.source.size, splats = c.factor * splats;
            MeshOptions& mesh = o.source.mesh;
            mesh.size *= c.factor, mesh.scale *= c.factor, mesh.hollow *= c.factor;
            const Vec3<double>& side = o.source.size;
            if (o.source.strand) o.source.strand = scaled(*o.source.strand, c.factor);
            o.source.rounding =
                std::min(c.factor * o.source.rounding, std::min({side.x, side.y, side.z}) / 2);
            // What readers of documents take.
            double most =
                std::max({o.source.size.x, o.source.size.y, o.source.size.z, splats, mesh.size,
                          mesh.scale / 1000, mesh.hollow, mesh_extent(object_of(o))});
            if (o.source.strand)
                for (const StrandPoint& p : o.source.strand->path)
                    most = std::max({most, std::abs(p.at.x), std::abs(p.at.y), std::abs(p.at.z)});
            if (most > 1000) refuse("factor", "expected an object of at most 1000 m");
            replace_in(next, std::move(o));
        }
        return c.factor == 1 ? same : done(std::move(next));
    }

    DocumentPtr operator()(const MergeObjects& c)
    {
        check_list(c.objects);
        if (c.objects.size() < 2) refuse("objects", "expected at least two objects, found one");
        SceneObject first = changeable(c.objects[0], "objects");
        if (c.name) first.name = *c.name;
        if (first.name.empty()) refuse("name", "expected a name");
        const auto splats = [](const SceneObject& o) {
            return o.source.shape == ShapeKind::splats;
        };
        Document next = d;
        for (const ObjectRef& ref : c.objects) {
            const SceneObject& o = changeable(ref, "objects");
            check_whole(o, "objects");
            if (splats(o) != splats(first) || (splats(o) && o.category != first.category))
                refuse("objects", "an object of splats merges with those of its category only");
            if (o.id != first.id)
                std::erase_if(next.objects, [&](const auto& one) { return one->id == o.id; });
        }
        replace_in(next, std::move(first));
        return done(std::move(next));
    }

    // The clay decides which part is larger and how many pieces there are: without numbers of the
    // parts, as if the first of two were the larger.
    DocumentPtr operator()(const SplitObject& c)
    {
        const SceneObject whole = changeable(c.object);
        check_whole(whole, "object");
        if (c.plane.has_value() == c.pieces.value_or(false))
            refuse(c.plane ? "pieces" : "plane", "expected either a plane or pieces: true");
        if (c.plane && !(length(c.plane->normal) > 1e-6))
            refuse("plane", "expected a normal longer than 0");
        const std::size_t parts = c.ids.empty() ? 2 : c.ids.size();
        if (parts < 2 || (c.plane && parts > 2)) refuse("ids", "expected the number of each part");
        const bool open = c.pieces && c.ids.empty();
        check_names(c.names, open ? std::size_t(most_objects) : parts);
        if (!c.categories.empty() && !open && c.categories.size() != parts)
            refuse("categories",
                   fmt::format("expected {} categories, found {}", parts, c.categories.size()));
        std::vector<ObjectId> others = c.ids;
        if (!others.empty() && std::erase(others, whole.id) != 1)
            refuse("ids", fmt::format("expected {} once", whole.id.value));
        others = new_numbers(others, parts - 1, "object");
        Document next = d;
        for (std::size_t i = 0, other = 0; i < parts; ++i) {
            SceneObject o = whole;
            const bool keeps = c.ids.empty() ? i == 0 : c.ids[i] == whole.id;
            if (!keeps) o.name = numbered(whole.name, fmt::format(" {}", other + 2));
            if (!keeps) o.id = others[other++];
            if (!keeps && is_open(o)) {
                Strand ended = *o.source.strand;
                ended.open = false;
                o.source.strand = std::make_shared<const Strand>(std::move(ended));
            }
            if (i < c.names.size()) o.name = c.names[i];
            if (i < c.categories.size()) {
                // It keeps its look.
                if (c.categories[i] != whole.category && !whole.colour &&
                    whole.source.shape != ShapeKind::splats)
                    o.colour = category_srgb(whole.category);
                o.category = c.categories[i];
                check_category(o, "categories");
            }
            if (keeps)
                replace_in(next, std::move(o));
            else
                next.objects.push_back(std::make_shared<const SceneObject>(std::move(o)));
        }
        ids.use(others.back());
        return done(std::move(next));
    }

    DocumentPtr operator()(const SourceBegin& c)
    {
        SceneObject o;
        o.id = new_numbers(c.ids, 1, "name").at(0);
        o.name = c.name;
        if (o.name.empty()) refuse("name", "expected a name");
        if (c.category) o.category = *c.category;
        o.material = normalised(c.material ? *c.material : material_spec("clay"));
        check_material(o.material, "material");
        check_category(o, "category");
        o.pose.p = c.at;
        Strand strand;
        strand.section = c.section.value_or(SectionKind::circle), strand.diameter = c.diameter,
        strand.open = true;
        if (c.outline) strand.outline = *c.outline;
        for (const Point2 p : strand.outline)
            for (const double x : {p.x, p.y}) check_range("outline", x, {-1000, 1000});
        strand.path.push_back({{0, 0, 0}, unit_axis(c.axis)});
        check_strand(strand);
        o.source.shape = ShapeKind::strand;
        o.source.strand = std::make_shared<const Strand>(std::move(strand));
        ids.use(o.id);
        Document next = d;
        next.objects.push_back(std::make_shared<const SceneObject>(std::move(o)));
        return done(std::move(next));
    }

    DocumentPtr operator()(const SourceMove& c)
    {
        SceneObject o = extruded(c.object);
        Strand strand = *o.source.strand;
        const Quat<double> back = conjugate(o.pose.q);
        StrandPoint to{rotate(back, c.at - o.pose.p), strand.path.back().axis};
        if (c.axis) to.axis = rotate(back, unit_axis(c.axis));
        strand.path.push_back(to);
        check_strand(strand);
        o.source.strand = std::make_shared<const Strand>(std::move(strand));
        return replaced(o);
    }

    DocumentPtr operator()(const SourceEnd& c)
    {
        SceneObject o = extruded(c.object);
        if (o.source.strand->path.size() < 2) {
            Document next = d;
            std::erase_if(next.objects, [&](const auto& one) { return one->id == o.id; });
            return done(std::move(next));
        }
        Strand strand = *o.source.strand;
        strand.open = false;
        o.source.strand = std::make_shared<const Strand>(std::move(strand));
        return replaced(o);
    }

    DocumentPtr operator()(const SetGravity& c)
    {
        SceneSettings s = *d.scene;
        s.gravity = c.gravity;
        return settled(s);
    }

    DocumentPtr operator()(const SetWalls& c)
    {
        SceneSettings s = *d.scene;
        if (c.min) s.walls.min = *c.min;
        if (c.max) s.walls.max = *c.max;
        if (c.contact_mode) s.walls.mode = *c.contact_mode;
        if (c.friction) s.walls.friction = *c.friction;
        const Vec3<double> room = s.walls.max - s.walls.min;
        if (!(std::min({room.x, room.y, room.z}) > 0))
            refuse(c.max ? "max" : "min", "expected each component of max above that of min");
        return settled(s);
    }

    DocumentPtr operator()(const SetContact& c)
    {
        SceneSettings s = *d.scene;
        if (c.categories) s.contact.separate = *c.categories == CategoryContact::separate;
        if (c.friction) s.contact.friction = *c.friction;
        return settled(s);
    }

    DocumentPtr operator()(const SetHands& c)
    {
        HandSettings h = *d.hands;
        const SetHand* given[side_count] = {&c.left, &c.right};
        for (const Side side : {left, right}) {
            if (given[side]->present) h.present[side] = *given[side]->present;
            if (!given[side]->held) continue;
            h.held[side] = *given[side]->held;
            const std::vector<std::string> tools = tool_names();
            if (!h.held[side].empty() &&
                std::find(tools.begin(), tools.end(), h.held[side]) == tools.end())
                refuse(side == left ? "left" : "right",
                       fmt::format("there is no tool \"{}\"; the nearest is \"{}\"",
                                   h.held[side].substr(0, 60), nearest_name(h.held[side], tools)));
        }
        if (c.zoom) h.zoom = *c.zoom;
        if (c.at) h.at = *c.at;
        if (equal(h, *d.hands)) return same;
        Document next = d;
        next.hands = std::make_shared<const HandSettings>(std::move(h));
        return done(std::move(next));
    }

    DocumentPtr operator()(const SetSurface& c)
    {
        SceneSettings s = *d.scene;
        s.surface_nodes = c.nodes;
        return settled(s);
    }

    DocumentPtr operator()(const Carry& c)
    {
        for (const ObjectRef& ref : c.objects)
            if (c.begins)
                changeable(ref, "objects");
            else
                object_in(d, ref, "objects");
        if (c.objects.empty()) refuse("objects", "expected at least one object");
        return same;
    }

    DocumentPtr operator()(const Export& c)
    {
        if (c.objects) {
            if (c.objects->empty()) refuse("objects", "expected at least one object");
            if (c.objects->size() > std::size_t(most_objects))
                refuse("objects", fmt::format("expected at most {} objects", most_objects));
            for (const ObjectRef& ref : *c.objects) object_in(d, ref, "objects");
        }
        auto plan = export_plan(d, c);
        if (Refusal* refusal = std::get_if<Refusal>(&plan)) throw Refused{std::move(*refusal)};
        return same;
    }

    // Commands of the session.
    template <class C>
    DocumentPtr operator()(const C&)
    {
        return same;
    }

  private:
    DocumentPtr done(Document next) const
    {
        return std::make_shared<const Document>(std::move(next));
    }

    const SceneObject& changeable(const ObjectRef& ref, const char* field = "object") const
    {
        const SceneObject& o = object_in(d, ref, field);
        if (o.locked) refuse(field, "\"" + o.name.substr(0, 60) + "\" is locked");
        return o;
    }

    // Of a nozzle that has not been ended.
    const SceneObject& extruded(const ObjectRef& ref) const
    {
        const SceneObject& o = changeable(ref, "name");
        if (!is_open(o)) refuse("name", "no nozzle lays \"" + o.name.substr(0, 60) + "\"");
        return o;
    }
    static Vec3<double> unit_axis(const std::optional<Vec3<double>>& axis)
    {
        const double size = axis ? length(*axis) : 0;
        return size > 1e-100 ? 1 / size * *axis : Vec3<double>{};
    }
    static void check_strand(const Strand& strand)
    {
        if (const auto fault = fault_of(strand))
            refuse(fault->key == "path" ? "at" : fault->key,
                   fmt::format("{}: expected {}, found {}", fault->key, fault->expected,
                               fault->found));
    }
    static std::shared_ptr<const Strand> scaled(Strand strand, double factor)
    {
        strand.diameter *= factor;
        for (StrandPoint& p : strand.path) p.at = factor * p.at;
        return std::make_shared<const Strand>(std::move(strand));
    }

    static void replace_in(Document& next, SceneObject by)
    {
        for (auto& o : next.objects)
            if (o->id == by.id && !equal(*o, by))
                return (void)(o = std::make_shared<const SceneObject>(std::move(by)));
    }

    // At least one object, each once.
    void check_list(const std::vector<ObjectRef>& objects) const
    {
        if (objects.empty()) refuse("objects", "expected at least one object");
        std::set<ObjectId> seen;
        for (const ObjectRef& ref : objects)
            if (const ObjectId id = object_in(d, ref, "objects").id; !seen.insert(id).second)
                refuse("objects", fmt::format("object {} is named twice", id.value));
    }

    void check_names(const std::vector<std::string>& names, std::size_t most) const
    {
        if (names.size() > most)
            refuse("names", fmt::format("expected at most {} names, found {}", most, names.size()));
        for (const std::string& name : names) {
            if (name.empty()) refuse("names", "expected a name");
            CheckRanges{}(command_field("names", &Rename::name, ""), name);
        }
    }
    // A name that is derived from another, of at most 1000 bytes.
    static std::string numbered(const std::string& name, const std::string& with)
    {
        return name.size() + with.size() > 1000 ? name : name + with;
    }

    // Most of the clay of a local object has no particles.
    static void check_whole(const SceneObject& o, const char* field)
    {
        if (o.source.shape == ShapeKind::splats && o.source.splats.depth > 0)
            refuse(field, "\"" + o.name.substr(0, 60) + "\" is simulated near hands only");
    }

    // Numbers of so many new objects: as given, of a log; else the next ones, which the caller has
    // to mark as used. `field`: of the objects.
    std::vector<ObjectId> new_numbers(std::vector<ObjectId> given, std::size_t count,
                                      const char* field) const
    {
        if (d.objects.size() + count > std::size_t(most_objects))
            refuse(field, fmt::format("a scene has at most {} objects", most_objects));
        if (given.empty()) {
            if (count > highest_id - ids.most()) refuse(field, "all numbers have been used");
            IdSource next = ids;
            while (given.size() < count) given.push_back(next.next());
        }
        if (given.size() != count)
            refuse("ids", fmt::format("expected {} numbers, found {}", count, given.size()));
        std::uint32_t last = ids.most();
        for (const ObjectId id : given) {
            if (id.value <= last)
                refuse("ids", fmt::format("the number {} has been used", id.value));
            if (id.value > highest_id)
                refuse("ids", fmt::format("expected a number of at most {}", highest_id));
            last = id.value;
        }
        return given;
    }

    DocumentPtr replaced(const SceneObject& by) const
    {
        Document next = d;
        for (auto& o : next.objects) {
            if (o->id != by.id) continue;
            if (equal(*o, by)) return same;
            o = std::make_shared<const SceneObject>(by);
        }
        return done(std::move(next));
    }

    DocumentPtr settled(const SceneSettings& s) const
    {
        if (equal(s, *d.scene)) return same;
        Document next = d;
        next.scene = std::make_shared<const SceneSettings>(s);
        return done(std::move(next));
    }

    void check_material(const MaterialSpec& m, const char* field) const
    {
        if (const auto fault = fault_of(m)) refuse(field, fault->text());
    }

    void check_source(const SceneObject& o, const char* field) const
    {
        const ObjectSource& s = o.source;
        const auto in = [&](const Bounds& range) {
            return command_field(field, &PlaceObject::object, "", range);
        };
        CheckRanges check;
        if (s.shape == ShapeKind::splats) {
            check(in({}), s.splats.file);
            check(in({0, 1000, "m", true}), s.splats.size);
            check(in({-360, 360, "degrees"}), s.splats.turn);
            return check(in({0, 1000, "m"}), s.splats.depth);
        }
        if (s.shape == ShapeKind::strand) {
            if (!s.strand) refuse(field, "expected the path of a strand");
            check(in({0, largest_extent, "m", true}), s.strand->diameter);
            for (const StrandPoint& p : s.strand->path) check(in(anywhere), p.at);
            for (const StrandPoint& p : s.strand->path) check(in({-1000, 1000}), p.axis);
            for (const Point2 p : s.strand->outline)
                check(in({-1000, 1000}), Vec3<double>{p.x, p.y, 0});
        }
        if (s.shape == ShapeKind::mesh) {
            check(in({}), s.mesh.file);
            check(in({0, 1000, "m"}), s.mesh.size);
            check(in({0, 1e6, "m a unit of the file"}), s.mesh.scale);
            check(in({-360, 360, "degrees"}), s.mesh.turn);
            check(in({0, 1000, "m"}), s.mesh.hollow);
            return check_shape(o, field);
        }
        check(in({}), s.text);
        if (s.shape == ShapeKind::text) {
            check(in({0, largest_extent, "m", true}), s.size.y);
            check(in({0, largest_extent, "m", true}), s.size.z);
        } else if (s.shape != ShapeKind::strand) {
            check(in({0, largest_extent, "m", true}), s.size);
            const bool three = s.shape == ShapeKind::box || s.shape == ShapeKind::ellipsoid ||
                               s.shape == ShapeKind::rounded_box;
            if (!three && s.size.x != s.size.z)
                refuse(field, "expected one diameter, found different extents along x and z");
            if (s.shape == ShapeKind::sphere && s.size.x != s.size.y)
                refuse(field, "expected one diameter, found different extents along x and y");
        }
        check_shape(o, field);
    }

    static void check_shape(const SceneObject& o, const char* field)
    {
        if (const auto fault = shape_fault(object_of(o)))
            refuse(field, fmt::format("{}: expected {}, found {}", fault->key, fault->expected,
                                      fault->found));
    }

    void check_object(const SceneObject& o, const char* field) const
    {
        CheckRanges check;
        const auto in = [&](const Bounds& range) {
            return command_field(field, &PlaceObject::object, "", range);
        };
        check(in({0, 255}), o.category);
        check(in(anywhere), o.pose.p);
        check(in(turn_range), o.pose.q);
        check_source(o, field);
        check(in({-1000, 1000, "m/s"}), o.source.velocity);
        check(in({2, 64, "particles per cell"}), o.source.per_cell);
        check(in({}), o.name);
        if (o.colour) check(in({0, 1}), *o.colour);
        check_material(normalised(o.material), field);
        check_category(o, field);
        check_walls(o, field);
        const auto local = [](const SceneObject& of) {
            return of.source.shape == ShapeKind::splats && of.source.splats.depth > 0;
        };
        if (local(o) && std::any_of(d.objects.begin(), d.objects.end(),
                                    [&](const auto& of) { return local(*of); }))
            refuse(field, "expected at most one object with a depth, found several");
    }

    // The clay of a category is drawn either as one surface or as splats.
    void check_category(const SceneObject& o, const char* field) const
    {
        const bool splats = o.source.shape == ShapeKind::splats;
        for (const auto& other : d.objects)
            if (other->id != o.id && other->category == o.category &&
                (other->source.shape == ShapeKind::splats) != splats)
                refuse(field, fmt::format("category {} is that of \"{}\": objects of splats and "
                                          "other clay need different categories",
                                          o.category, other->name.substr(0, 60)));
    }

    // The size of an object of a file is known when that is read; what a strand has beyond the
    // walls is not laid.
    void check_walls(const SceneObject& o, const char* field) const
    {
        if (o.source.shape == ShapeKind::splats || o.source.shape == ShapeKind::strand) return;
        const Object object = object_of(o);
        if (o.source.shape == ShapeKind::mesh && !object.solid) return;
        const Box3<double> box = box_of(object);
        const WallOptions& walls = d.scene->walls;
        const double slack = 1e-9;
        const auto check = [&](const char* axis, double a, double b, double low, double high) {
            if (a >= low - slack && b <= high + slack) return;
            refuse(field, fmt::format("expected the object between the walls, {} from {:.6g} to "
                                      "{:.6g} m, found {} from {:.6g} to {:.6g} m",
                                      axis, low, high, axis, a, b));
        };
        check("x", box.low.x, box.high.x, walls.min.x, walls.max.x);
        check("y", box.low.y, box.high.y, walls.min.y, walls.max.y);
        check("z", box.low.z, box.high.z, walls.min.z, walls.max.z);
    }

    const Document& d;
    IdSource& ids;
    const DocumentPtr& same;
};

}  // namespace

std::variant<DocumentPtr, Refusal> reduce(const DocumentPtr& document, const Command& command,
                                          IdSource& ids)
{
    try {
        return std::visit(
            [&](const auto& c) {
                for_each_field(c, CheckRanges{});
                return Reduction(document, ids)(c);
            },
            command);
    } catch (const Refused& refused) {
        return refused.refusal;
    }
}

std::variant<ObjectId, Refusal> resolved(const Document& document, const ObjectRef& object,
                                         const std::string& field)
{
    try {
        return object_in(document, object, field).id;
    } catch (const Refused& refused) {
        return refused.refusal;
    }
}

Command with_ids(const Document& document, Command command)
{
    std::visit(
        [&](auto& c) {
            for_each_field(c, [&](const auto& f, auto& value) {
                using T = std::remove_cvref_t<decltype(value)>;
                const auto each = [&](std::vector<ObjectRef>& objects) {
                    for (ObjectRef& one : objects) one = object_in(document, one, f.key).id;
                };
                if constexpr (std::is_same_v<T, ObjectRef>) {
                    value = object_in(document, value, f.key).id;
                } else if constexpr (std::is_same_v<T, std::vector<ObjectRef>>) {
                    each(value);
                } else if constexpr (std::is_same_v<T, std::optional<std::vector<ObjectRef>>>) {
                    if (value) each(*value);
                }
            });
        },
        command);
    return command;
}

}  // namespace knead
