// Random commands and documents, made from the table of commands alone: a new command, or a new
// field, is drawn without a change here.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "host/base/font_file.h"
#include "host/document/command_table.h"
#include "host/document/export_plan.h"
#include "host/document/reduce.h"
#include "host/scene/names.h"
#include "host/scene/object_json.h"
#include "host/scene/presets.h"

namespace knead {

// How often a test repeats: `often` if the environment has KNEAD_LONG, else `few`.
inline long repeats(long few, long often) { return std::getenv("KNEAD_LONG") ? often : few; }

class Random {
  public:
    explicit Random(std::uint64_t seed) : engine(seed) {}

    int below(int n) { return int(engine() % std::uint64_t(n)); }
    int whole(int low, int high)  // inclusive
    {
        return int(low + std::int64_t(engine() % (std::uint64_t(std::int64_t(high) - low) + 1)));
    }
    bool one_in(int n) { return below(n) == 0; }
    double in(double low, double high)
    {
        return low + (high - low) * double(engine() >> 11) * 0x1p-53;
    }
    template <class All>
    const auto& of(const All& all)
    {
        return all[std::size_t(below(int(std::size(all))))];
    }

  private:
    std::mt19937_64 engine;
};

// What is drawn.
struct Drawing {
    int wild = 0;              // percent of values outside their ranges
    const Document* document;  // whose objects are meant
    double unknown = 0;        // percent of objects that there are not
    bool splats = false;       // new objects of splats, too
    bool text = false;         // any UTF-8
};

inline double random_number(Random& r, const Bounds& range)
{
    using D = std::numeric_limits<double>;
    const double near_zero[] = {0.0,      -0.0,   D::denorm_min(), -D::denorm_min(),
                                D::min(), 1e-310, 1.0 / 3,         -0.1};
    double x = 0;
    switch (r.below(8)) {
        case 0:
            x = range.low;
            break;
        case 1:
            x = range.high;
            break;
        case 2:
            x = std::nextafter(range.high, range.low);
            break;
        case 3:
            x = r.of(near_zero);
            break;
        case 4:
            x = std::pow(10, r.in(-320, std::log10(std::max(range.high, 1e-300))));
            break;
        default:
            x = r.in(range.low, range.high);
    }
    const bool inside = (range.above ? x > range.low : x >= range.low) && x <= range.high;
    return inside ? x : std::nextafter(range.high, range.low);
}
inline double wild_number(Random& r, const Bounds& range)
{
    using D = std::numeric_limits<double>;
    const double all[] = {D::quiet_NaN(),
                          D::infinity(),
                          -D::infinity(),
                          D::max(),
                          D::lowest(),
                          std::nextafter(range.high, D::infinity()),
                          range.above ? range.low : std::nextafter(range.low, -D::infinity())};
    return r.of(all);
}

inline std::string random_text(Random& r)
{
    const std::string pieces[] = {
        "a",    "Z",    "7", " ", "\"", "\\",   "/", "\n", "\t",    std::string(1, '\0'),
        "\x1f", "\x7f", "ä", "€", "漢", "🙂", "{", "}",  "frame", "id",
        ""};
    std::string text;
    for (int n = r.one_in(20) ? 60 : r.below(8); n > 0; --n) text += r.of(pieces);
    return text;
}

// Few, so that several objects have the same.
inline std::string random_name(Random& r, const Drawing& by)
{
    const std::string names[] = {"a", "b", "c", "ball", "floor", "object 3", "left block", "7"};
    if (r.below(100) < by.wild)
        return r.one_in(2)   ? std::string()
               : r.one_in(2) ? std::string(1001, 'x')
                             : "\xff\xc0" + std::string("a");
    return by.text && r.one_in(2) ? "n" + random_text(r) : r.of(names);
}

inline MaterialSpec random_material(Random& r, const Drawing& by)
{
    MaterialSpec m = r.of(material_specs());
    if (r.one_in(8)) m.elasticity = r.of(elasticities).second;
    if (r.one_in(8)) m.plasticity = r.of(plasticities).second;
    for (const MaterialQuantity& q : material_quantities())
        if (q.used(m) && r.one_in(5)) m.*q.value = r.in(q.low, std::min(q.high, 1e7));
    if (r.below(100) < by.wild) {
        const MaterialQuantity& q = r.of(material_quantities());
        m.*q.value = wild_number(r, {q.low, q.high});
        if (r.one_in(3)) m.name = random_text(r);
        return m;
    }
    return normalised(fault_of(m) ? r.of(material_specs()) : m);
}

inline Quat<double> random_rotation(Random& r)
{
    Quat<double> q{1, 0, 0, 0};
    if (r.one_in(4)) return q;
    q = {r.in(-1, 1), r.in(-1, 1), r.in(-1, 1), r.in(-1, 1)};
    if (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z < 1e-3) return {0, 1, 0, 0};
    const double size = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return unit_rotation({q.w / size, q.x / size, q.y / size, q.z / size});
}

inline std::vector<Point2> random_outline(Random& r)
{
    std::vector<Point2> outline;
    const int corners = 3 + r.below(6);
    for (int k = 0; k < corners; ++k) {
        const double angle = 6.283185307179586 * k / corners, size = r.in(0.5, 1);
        outline.push_back({size * std::cos(angle), size * std::sin(angle)});
    }
    return outline;
}

// A shape of at most 0.2 m, whatever its proportions; a text may be wider.
inline void random_shape(Random& r, ObjectSource& s)
{
    const double across = r.in(0.01, 0.2);
    s.size = {across, r.in(0.01, 0.2), r.in(0.01, 0.2)};
    const double least = std::min({s.size.x, s.size.y, s.size.z});
    switch (s.shape) {
        case ShapeKind::sphere:
            s.size = {across, across, across};
            break;
        case ShapeKind::cylinder:
        case ShapeKind::cone:
            s.size.z = across;
            break;
        case ShapeKind::capsule:
            s.size = {least, std::max(least, s.size.y), least};
            break;
        case ShapeKind::torus:
            s.size = {across, across * r.in(0.01, 0.49), across};
            break;
        case ShapeKind::rounded_box:
            s.rounding = r.one_in(4) ? least / 2 : least * r.in(0, 0.5);
            break;
        case ShapeKind::text:
            s.size = {0, r.in(0.01, 0.1), r.in(0.01, 0.2)};
            s.text = r.of(std::array{"a", "fl", "i\nj", "\xc3\xa4 ?"});
            break;
        case ShapeKind::strand: {
            s.size = {};
            Strand strand;
            strand.section = r.of(section_kinds).second, strand.diameter = across;
            if (strand.section == SectionKind::outline) strand.outline = random_outline(r);
            strand.path.push_back({});
            for (int n = 1 + r.below(5); n > 0; --n)
                strand.path.push_back(
                    {strand.path.back().at + Vec3<double>{r.in(-0.1, 0.1), r.in(-0.1, 0.1), 0.1},
                     {r.in(-1, 1), r.one_in(2) ? 0 : r.in(-1, 1), -0.0}});
            strand.open = r.one_in(3);
            s.strand = std::make_shared<const Strand>(std::move(strand));
            break;
        }
        case ShapeKind::mesh:  // of a file that nobody has read
            s.size = {};
            s.mesh = {
                "/clay/cup.stl",       r.of(up_axes).second, r.in(-180, 180), r.in(0.01, 1), 0,
                r.one_in(2) ? 0 : 0.01};
            if (r.one_in(3)) s.mesh.scale = r.in(1e-4, 2), s.mesh.size = 0;
            break;
        case ShapeKind::box:
        case ShapeKind::ellipsoid:
        case ShapeKind::splats:
            break;
    }
}

inline SceneObject random_object(Random& r, const Drawing& by)
{
    const auto wild = [&] { return r.below(400) < by.wild; };
    SceneObject o;
    if (r.one_in(10)) o.id = {std::uint32_t(r.below(300))};
    o.name = random_name(r, by);
    o.source.shape = r.of(shape_kinds).second;
    if (o.source.shape == ShapeKind::splats && !(by.splats && r.one_in(4)))
        o.source.shape = ShapeKind::box;
    if (o.source.shape == ShapeKind::text && font_file().empty()) o.source.shape = ShapeKind::box;
    random_shape(r, o.source);
    if (o.source.shape == ShapeKind::splats) {
        o.source.size = {};
        o.source.splats = {"/clay/pot.ply", r.of(up_axes).second, r.in(0.01, 1), r.in(-180, 180),
                           r.one_in(2) ? 0 : 0.1};
    }
    // Categories from 200 on are of splats, mostly.
    o.category = o.source.shape == ShapeKind::splats && !wild() ? 200 + r.below(3) : r.below(4);
    o.material = random_material(r, by);
    o.pose = {random_rotation(r), {r.in(0.2, 0.8), r.in(0.2, 0.8), r.in(0.2, 0.8)}};
    if (r.one_in(5)) o.source.velocity = {0, r.in(-2, 2), -0.0};
    if (r.one_in(5)) o.source.per_cell = r.in(2, 64);
    if (r.one_in(10)) o.locked = true;
    if (r.one_in(10)) o.hidden = true;
    if (r.one_in(10)) o.colour = Vec3<double>{r.in(0, 1), r.in(0, 1), 1};
    if (wild()) o.colour = Vec3<double>{0, r.one_in(2) ? 1.5 : std::nan(""), 0};
    if (wild()) o.category = r.one_in(2) ? -1 : 256;
    if (wild()) o.pose.p.y = wild_number(r, anywhere);
    if (wild()) o.pose.p.x = 50;
    if (wild()) o.pose.q.w = r.one_in(2) ? 2 : std::nan("");
    if (wild()) o.source.size.y = r.one_in(2) ? 0 : std::nan("");
    if (wild()) o.source.rounding = r.one_in(2) ? 10 : std::nan("");
    if (wild()) o.source.text = random_text(r);
    if (o.source.strand && wild()) {
        Strand strand = *o.source.strand;
        if (r.one_in(2)) strand.diameter = r.one_in(2) ? 0 : std::nan("");
        if (r.one_in(2)) strand.path.back().at.y = r.one_in(2) ? 1e9 : std::nan("");
        if (r.one_in(2)) strand.path.clear();
        o.source.strand = std::make_shared<const Strand>(std::move(strand));
    }
    if (wild()) o.source.per_cell = r.one_in(2) ? 1 : 1e9;
    if (wild()) o.source.velocity.z = std::numeric_limits<double>::infinity();
    if (wild()) o.id = {0xffffffffu - unsigned(r.below(2))};
    return o;
}

// Draws the fields of a command.
struct RandomFields {
    Random& r;
    const Drawing& by;

    bool wild() const { return r.below(100) < by.wild; }

    template <class F, class T>
    void operator()(const F& f, std::optional<T>& value) const
    {
        value.reset();
        if (r.below(3) > 0) (*this)(f, value.emplace());
    }
    template <class F>
    void operator()(const F& f, double& x) const
    {
        x = wild() ? wild_number(r, f.range) : random_number(r, f.range);
    }
    template <class F>
    void operator()(const F& f, Vec3<double>& v) const
    {
        // Most places are in a room of a metre.
        const bool place = std::string_view(f.range.unit) == "m" && r.below(4) > 0;
        for (double* x : {&v.x, &v.y, &v.z})
            *x = wild()  ? wild_number(r, f.range)
                 : place ? r.in(0.2, 0.8)
                         : random_number(r, f.range);
        if (place && std::string_view(f.key) == "min") v = v - Vec3<double>{0.7, 0.7, 0.7};
        if (place && std::string_view(f.key) == "max") v = v + Vec3<double>{0.7, 0.7, 0.7};
    }
    template <class F>
    void operator()(const F&, Quat<double>& q) const
    {
        q = random_rotation(r);
        if (wild()) q.x = r.one_in(2) ? 2 : std::nan("");
    }
    template <class F>
    void operator()(const F& f, int& n) const
    {
        const int low = int(f.range.low), high = int(f.range.high);
        n = r.one_in(4) ? low : r.one_in(4) ? high : r.whole(low, high);
        if (low == 0 && high == 255 && r.one_in(2)) n = r.below(4);
        if (wild())
            n = r.one_in(2) ? low - 1
                : r.one_in(2) && high < std::numeric_limits<int>::max()
                    ? high + 1
                    : std::numeric_limits<int>::min();
    }
    template <class F>
    void operator()(const F& f, std::vector<int>& numbers) const
    {
        numbers.clear();
        if (r.below(3) > 0) return;
        numbers.resize(std::size_t(r.below(4)));
        for (int& n : numbers) (*this)(f, n);
    }
    template <class F>
    void operator()(const F&, bool& flag) const
    {
        flag = r.one_in(2);
    }
    template <class F>
    void operator()(const F& f, std::string& text) const
    {
        const std::string_view key = f.key;
        if (key == "held")
            text = r.one_in(3) ? "" : r.of(tool_names());
        else if (key == "name")
            text = random_name(r, by);
        else if (key == "file" && r.one_in(2))
            text =
                std::string("text") + r.of(std::array{".glb", ".ply", ".stl", ".splat", ".knead"});
        else
            text = by.text ? random_text(r) : "text";
        if (wild()) text = r.one_in(2) ? std::string(1001, 'x') : random_text(r);
    }
    template <class F>
    void operator()(const F&, std::vector<std::string>& texts) const
    {
        texts.clear();
        for (int n = r.below(4); n > 0; --n) texts.push_back(by.text ? random_text(r) : "seed=3");
    }
    template <class F>
    void operator()(const F&, std::vector<ObjectId>& ids) const
    {
        ids.clear();
        if (!r.one_in(8)) return;
        for (int n = 1 + r.below(3); n > 0; --n) ids.push_back({std::uint32_t(1 + r.below(300))});
    }
    template <class F>
    void operator()(const F&, SplitPlane& plane) const
    {
        for_each_field(plane, *this);
    }
    template <class F>
    void operator()(const F& f, ObjectRef& object) const
    {
        const auto& all = by.document->objects;
        if (all.empty() || r.in(0, 100) < by.unknown) {
            const ObjectId none[] = {{0}, {1000000}, {0xffffffffu}};
            object =
                r.one_in(2) ? ObjectRef(r.of(none)) : ObjectRef(r.one_in(2) ? "bal" : "no such");
            return;
        }
        if (std::string_view(f.key) == "name") {  // of a nozzle
            std::vector<ObjectId> open;
            for (const auto& one : all)
                if (is_open(*one)) open.push_back(one->id);
            if (!open.empty() && r.below(8) > 0) return (void)(object = r.of(open));
        }
        const SceneObject& one = *r.of(all);
        object = r.one_in(3) ? ObjectRef(one.name) : ObjectRef(one.id);
    }
    template <class F>
    void operator()(const F& f, std::vector<ObjectRef>& objects) const
    {
        objects.resize(wild()        ? 0
                       : r.one_in(4) ? std::size_t(1 + r.below(4))
                       : r.one_in(3) ? 1
                                     : 2);
        // Most by number: with several, few would all have a name of their own.
        for (ObjectRef& one : objects)
            if (by.document->objects.empty() || objects.size() == 1 || r.one_in(6))
                (*this)(f, one);
            else
                one = r.of(by.document->objects)->id;
    }
    template <class F>
    void operator()(const F&, MaterialSpec& m) const
    {
        m = random_material(r, by);
    }
    template <class F>
    void operator()(const F&, SceneObject& o) const
    {
        o = random_object(r, by);
    }
    template <class F>
    void operator()(const F&, SetHand& hand) const
    {
        for_each_field(hand, *this);
    }
    template <class F>
    void operator()(const F&, std::vector<Point2>& outline) const
    {
        outline = random_outline(r);
        if (wild()) outline.resize(r.one_in(2) ? 2 : 1001, {std::nan(""), 0});
    }
    template <class F>
    void operator()(const F&, SectionKind& section) const
    {
        section = r.of(section_kinds).second;
    }
    template <class F>
    void operator()(const F&, CategoryContact& contact) const
    {
        contact = CategoryContact(r.below(2));
    }
    template <class F>
    void operator()(const F&, ContactMode& mode) const
    {
        mode = r.of(contact_modes).second;
    }
    template <class F>
    void operator()(const F&, ExportContent& what) const
    {
        what = r.of(export_contents).second;
    }
    template <class F>
    void operator()(const F&, LengthUnit& unit) const
    {
        unit = r.of(length_units).second;
    }
    template <class F>
    void operator()(const F&, Side& side) const
    {
        side = r.one_in(2) ? left : right;
    }
};

template <class C>
C random_fields(Random& r, const Drawing& by)
{
    C command;
    for_each_field(command, RandomFields{r, by});
    return command;
}

// The alternative of that index.
inline Command random_command(Random& r, const Drawing& by, std::size_t index)
{
    Command command;
    visit_command_type(command_rows[index].name, [&]<class C>(std::in_place_type_t<C>) {
        command = random_fields<C>(r, by);
    });
    return command;
}
inline Command random_command(Random& r, const Drawing& by)
{
    return random_command(r, by, std::size_t(r.below(int(command_rows.size()))));
}

// A room of a metre with no objects.
inline DocumentPtr empty_room()
{
    Document d;
    SceneSettings s;
    s.gravity = {0, -9.81, 0};
    s.walls.min = {0, 0, 0}, s.walls.max = {1, 1, 1};
    s.cells = 16, s.surface_nodes = 32;
    d.scene = std::make_shared<const SceneSettings>(s);
    return std::make_shared<const Document>(std::move(d));
}

// The document after the command; the same where it is refused.
inline DocumentPtr after(const DocumentPtr& document, const Command& command, IdSource& ids)
{
    const auto result = reduce(document, command, ids);
    const DocumentPtr* to = std::get_if<DocumentPtr>(&result);
    return to ? *to : document;
}

// Copies that share nothing.
inline Document deep_copy(const Document& d)
{
    Document copy;
    for (const auto& o : d.objects) copy.objects.push_back(std::make_shared<const SceneObject>(*o));
    copy.scene = std::make_shared<const SceneSettings>(*d.scene);
    copy.hands = std::make_shared<const HandSettings>(*d.hands);
    return copy;
}

}  // namespace knead
