// Documents after commands, without a simulator: random commands, and what each refuses.
#include "host/document/reduce.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host/document/command_text.h"
#include "host/document/document_text.h"
#include "tests/document/random.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

// What is wrong with a document, of which the objects of `checked` are known to be right.
std::string fault_in(const Document& d, const IdSource& ids, const Document& checked)
{
    std::uint32_t last = 0;
    std::array<int, 256> splats{};  // 1: of splats, 2: of other clay
    auto known = checked.objects.begin();
    if (d.objects.size() > std::size_t(most_objects)) return "too many objects";
    for (const auto& o : d.objects) {
        if (o->id.value <= last || !ids.used(o->id)) return "ids do not rise";
        last = o->id.value;
        if (o->category < 0 || o->category > 255) return "a category outside its range";
        int& kinds = splats[std::size_t(o->category)];
        kinds |= o->source.shape == ShapeKind::splats ? 1 : 2;
        if (kinds == 3) return "a mixed category";
        while (known != checked.objects.end() && (*known)->id < o->id) ++known;
        if (known != checked.objects.end() && *known == o) continue;
        if (o->name.empty() || o->name.size() > 1000) return "no name";
        if (fault_of(o->material)) return "an invalid material";
        if (!equal(o->material, normalised(o->material))) return "a material not normalised";
        const Quat<double>& q = o->pose.q;
        if (!(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-12))
            return "no rotation";
        for (const double x : {o->pose.p.x, o->pose.p.y, o->pose.p.z})
            if (!(std::abs(x) <= 1000)) return "a place outside its range";
    }
    if (d.scene != checked.scene) {
        const SceneSettings& s = *d.scene;
        const Vec3<double> room = s.walls.max - s.walls.min;
        if (!(room.x > 0 && room.y > 0 && room.z > 0)) return "walls without room";
        for (const double x : {s.gravity.x, s.gravity.y, s.gravity.z})
            if (!(std::abs(x) <= most_gravity)) return "gravity outside its range";
        if (s.surface_nodes < fewest_surface_nodes || s.surface_nodes > most_surface_nodes)
            return "surface nodes outside their range";
        if (!(s.walls.friction >= 0 && s.walls.friction <= 10)) return "friction of walls";
    }
    if (d.hands != checked.hands) {
        const auto tools = tool_names();
        for (const std::string& held : d.hands->held)
            if (!held.empty() && std::ranges::find(tools, held) == tools.end()) return "a tool";
        if (!(d.hands->zoom >= 0.01 && d.hands->zoom <= 1000)) return "zoom";
    }
    return "";
}

std::string text_of(const Command& command) { return line_of({0, command, 0}); }

struct Counted {
    long accepted = 0, refused = 0;
};

// Documents grow and shrink, from none to as many objects as there may be.
TEST(Reduce, RandomCommandsKeepDocumentsValidAndRefusalsChangeNothing)
{
    const std::uint64_t seed = std::getenv("KNEAD_LONG") ? std::random_device{}() : 58;
    SCOPED_TRACE(seed);
    Random r(seed);
    std::map<std::string, Counted> counted;
    std::set<std::string> fields;
    std::vector<DocumentPtr> others;
    std::set<std::uint32_t> born;
    DocumentPtr now = empty_room();
    IdSource ids;
    std::size_t most = 0;
    const long count = repeats(sanitized ? 100000 : 1000000, 10000000);
    for (long i = 0; i < count; ++i) {
        if (i % 100000 == 0) now = empty_room(), ids = IdSource(), born.clear();
        const bool grows = i / 2500 % 2 == 0;
        Drawing by{i % 3 == 0 ? 10 : 0, now.get(), 3, true};
        // Of ten, four add or remove an object.
        const int row = r.below(10);
        const std::size_t which = row > 3 ? std::size_t(r.below(int(command_rows.size())))
                                  : (r.below(100) < 90) == grows ? Command(AddObject{}).index()
                                                                 : Command(RemoveObjects{}).index();
        const Command command = random_command(r, by, which);
        const DocumentPtr before = now;
        const std::string text = i % 1024 == 0 ? document_text(*now) : "";
        const std::uint32_t used = ids.most();
        const auto result = reduce(now, command, ids);
        ASSERT_EQ(now, before);
        if (!text.empty()) {
            ASSERT_EQ(document_text(*before), text) << i;
        }
        if (const Refusal* refusal = std::get_if<Refusal>(&result)) {
            ++counted[row_of(command).name].refused;
            fields.insert(std::string(row_of(command).name) + "/" + refusal->field);
            ASSERT_FALSE(refusal->why.empty());
            ASSERT_EQ(ids.most(), used) << i << ": " << refusal->text();
            continue;
        }
        ++counted[row_of(command).name].accepted;
        now = std::get<DocumentPtr>(result);
        ASSERT_TRUE(now);
        if (row_of(command).receiver == Receiver::session) {
            ASSERT_EQ(now, before) << i;
        }
        if (now == before) continue;
        ASSERT_EQ(fault_in(*now, ids, *before), "") << i << ": " << text_of(command);
        most = std::max(most, now->objects.size());
        if (adds_objects(command)) {
            const std::uint32_t id = now->objects.back()->id.value;
            ASSERT_GT(id, used) << i;
            ASSERT_TRUE(born.insert(id).second) << i << ": " << id << " again";
        }
        // The same command again changes nothing, or is refused; but those that act again.
        if (i % 16 == 0 && !adds_objects(command) && !reads_clay(command)) {
            IdSource copy = ids;
            const auto again = reduce(now, command, copy);
            if (const DocumentPtr* same = std::get_if<DocumentPtr>(&again)) {
                ASSERT_EQ(*same, now) << i;
            }
        }
        if (i % 2048 != 0) continue;
        // `hash` and `equal` say the same of any two.
        const auto copy = std::make_shared<const Document>(deep_copy(*now));
        ASSERT_TRUE(equal(*copy, *now));
        ASSERT_EQ(hash(*copy), hash(*now));
        others.push_back(copy);
        for (int k = 0; k < 4; ++k) {
            const DocumentPtr& other = r.of(others);
            ASSERT_EQ(equal(*other, *before), hash(*other) == hash(*before)) << i;
            ASSERT_EQ(equal(*other, *now), hash(*other) == hash(*now)) << i;
        }
        if (others.size() > 64) others.erase(others.begin(), others.begin() + 32);
    }
    EXPECT_EQ(most, std::size_t(most_objects));
    for (const CommandRow& row : command_rows) {
        EXPECT_GT(counted[row.name].accepted, count / 2000) << row.name;
        const char* const unconditional[] = {"reset", "pause", "play", "undo", "redo"};
        const bool never = std::ranges::count(unconditional, std::string_view(row.name)) > 0;
        EXPECT_EQ(counted[row.name].refused == 0, never) << row.name;
    }
    for (const char* field : {"add_object/object",     "remove_objects/objects",
                              "place_object/object",   "place_object/centre",
                              "place_object/rotation", "set_material/material",
                              "set_category/category", "rename/name",
                              "set_flags/object",      "copy_objects/objects",
                              "copy_objects/by",       "copy_objects/names",
                              "copy_objects/ids",      "scale_objects/objects",
                              "scale_objects/factor",  "merge_objects/objects",
                              "merge_objects/name",    "split_object/object",
                              "split_object/plane",    "split_object/pieces",
                              "split_object/names",    "split_object/ids",
                              "set_gravity/gravity",   "set_walls/min",
                              "set_walls/max",         "set_walls/friction",
                              "set_hands/zoom",        "set_hands/at",
                              "set_surface/nodes",     "set_lattice/cells",
                              "carry/objects",         "open/cells",
                              "export/file",           "export/objects",
                              "advance/frames"})
        EXPECT_TRUE(fields.contains(field)) << field << " was never refused";
}

// Two documents that differ in one number by one bit, also in the sign of 0, have other hashes and
// are not equal.
TEST(Reduce, HashAndEqualityTellEveryMemberApart)
{
    IdSource ids;
    Random r(7);
    const DocumentPtr empty = empty_room();
    Drawing by{0, empty.get(), 0, true};
    DocumentPtr d = empty;
    while (d->objects.size() < 4) d = after(d, AddObject{random_object(r, by)}, ids);
    std::vector<Document> all{*d};
    const auto object = [&](std::size_t i, const auto& change) {
        Document next = *d;
        SceneObject o = *d->objects[i];
        change(o);
        next.objects[i] = std::make_shared<const SceneObject>(o);
        all.push_back(next);
    };
    const auto up = [](double& x) { x = std::nextafter(x, 1e300); };
    object(0, [](SceneObject& o) { o.name += "x"; });
    object(0, [](SceneObject& o) { o.name += "x"; });
    object(0, [](SceneObject& o) { o.category += 1; });
    object(0, [](SceneObject& o) { o.locked = !o.locked; });
    object(0, [](SceneObject& o) { o.hidden = !o.hidden; });
    object(0, [](SceneObject& o) { o.id.value += 1000; });
    object(0, [](SceneObject& o) {
        o.material = material_spec(o.material.name == "snow" ? "clay" : "snow");
    });
    object(0, [&](SceneObject& o) { up(o.material.density); });
    object(0, [&](SceneObject& o) { up(o.pose.p.x); });
    object(0, [&](SceneObject& o) { up(o.pose.p.y); });
    object(0, [&](SceneObject& o) { up(o.pose.p.z); });
    for (double Quat<double>::*part :
         {&Quat<double>::w, &Quat<double>::x, &Quat<double>::y, &Quat<double>::z})
        object(0, [&](SceneObject& o) { up(o.pose.q.*part); });
    object(0, [&](SceneObject& o) { up(o.source.velocity.x); });
    object(0, [&](SceneObject& o) { o.source.velocity.y = 0; });
    object(0, [&](SceneObject& o) { o.source.velocity.y = -0.0; });
    object(0, [&](SceneObject& o) { up(o.source.per_cell); });
    const auto scene = [&](const auto& change) {
        Document next = *d;
        SceneSettings s = *d->scene;
        change(s);
        next.scene = std::make_shared<const SceneSettings>(s);
        all.push_back(next);
    };
    scene([&](SceneSettings& s) { up(s.gravity.x); });
    scene([&](SceneSettings& s) { s.gravity.z = -0.0; });
    scene([&](SceneSettings& s) { up(s.walls.min.y); });
    scene([&](SceneSettings& s) { up(s.walls.max.z); });
    scene([&](SceneSettings& s) { up(s.walls.friction); });
    scene([&](SceneSettings& s) { s.walls.mode = ContactMode::slip; });
    scene([&](SceneSettings& s) { ++s.cells; });
    scene([&](SceneSettings& s) { ++s.surface_nodes; });
    const auto hands = [&](const auto& change) {
        Document next = *d;
        HandSettings h = *d->hands;
        change(h);
        next.hands = std::make_shared<const HandSettings>(h);
        all.push_back(next);
    };
    for (const Side side : {left, right}) {
        hands([&](HandSettings& h) { h.held[side] = "rod"; });
        hands([&](HandSettings& h) { h.present[side] = false; });
    }
    hands([&](HandSettings& h) { up(h.zoom); });
    hands([&](HandSettings& h) { up(h.at.x); });
    hands([&](HandSettings& h) { h.at.x = -0.0; });
    Document fewer = *d;
    fewer.objects.pop_back();
    all.push_back(fewer);
    int same = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            EXPECT_EQ(equal(all[i], all[j]), hash(all[i]) == hash(all[j])) << i << " " << j;
            same += equal(all[i], all[j]);
        }
    EXPECT_EQ(same, 1) << "the same change twice";
}

class Refusals : public testing::Test {
  protected:
    Refusals()
    {
        for (const char* name : {"ball", "block", "twin", "twin"}) add(name);
        SceneObject pot;
        pot.name = "pot", pot.category = 9, pot.material = material_spec("clay");
        pot.source.shape = ShapeKind::splats, pot.source.splats.file = "pot.ply";
        pot.source.splats.size = 0.2, pot.source.splats.depth = 0.05;
        pot.pose.p = {0.5, 0.5, 0.5};
        d = after(d, AddObject{pot}, ids);
        EXPECT_EQ(d->objects.size(), 5u);
        d = after(d, SetFlags{ObjectRef("block"), true, {}}, ids);
        EXPECT_TRUE(d->find({2})->locked);
    }
    SceneObject ball(const std::string& name) const
    {
        SceneObject o;
        o.name = name, o.material = material_spec("clay");
        o.source.size = {0.1, 0.1, 0.1}, o.pose.p = {0.5, 0.5, 0.5};
        return o;
    }
    void add(const std::string& name) { d = after(d, AddObject{ball(name)}, ids); }
    // Refused for this field, and with these words.
    void refused(const Command& command, const std::string& field, const std::string& words)
    {
        const std::uint32_t used = ids.most();
        const auto result = reduce(d, command, ids);
        ASSERT_TRUE(std::holds_alternative<Refusal>(result)) << text_of(command);
        const Refusal& refusal = std::get<Refusal>(result);
        EXPECT_EQ(refusal.field, field) << refusal.why;
        EXPECT_NE(refusal.why.find(words), std::string::npos) << refusal.why;
        EXPECT_EQ(ids.most(), used);
    }
    template <class Change>
    void refused_object(const std::string& words, const Change& change)
    {
        SceneObject o = ball("new");
        change(o);
        refused(AddObject{o}, "object", words);
    }
    DocumentPtr taken(const Command& command)
    {
        const auto result = reduce(d, command, ids);
        const Refusal* refusal = std::get_if<Refusal>(&result);
        if (refusal) ADD_FAILURE() << refusal->text();
        return refusal ? d : std::get<DocumentPtr>(result);
    }

    DocumentPtr d = empty_room();
    IdSource ids;
};

TEST_F(Refusals, OfObjectsThatThereAreNotOrSeveral)
{
    const ObjectRef none[] = {ObjectId{0}, ObjectId{6}, ObjectId{0xffffffff}};
    for (const ObjectRef& ref : none) {
        refused(PlaceObject{ref, {}, {}}, "object", "there is no object");
        refused(SetMaterial{ref, material_spec("snow")}, "object", "there is no object");
        refused(SetCategory{ref, 1}, "object", "there is no object");
        refused(Rename{ref, "x"}, "object", "there is no object");
        refused(SetFlags{ref, {}, {}}, "object", "there is no object");
        refused(RemoveObjects{{ObjectId{1}, ref}}, "objects", "there is no object");
        refused(Carry{{ref}, left, true}, "objects", "there is no object");
        refused(Carry{{ref}, left, false}, "objects", "there is no object");
    }
    refused(SetCategory{ObjectRef("bal"), 1}, "object", "the nearest name is \"ball\"");
    refused(SetCategory{ObjectRef("Block"), 1}, "object", "the nearest name is \"block\"");
    refused(SetCategory{ObjectRef("quite another"), 1}, "object",
            "there is no object \"quite another\"");
    refused(SetCategory{ObjectRef(""), 1}, "object", "there is no object");
    refused(SetCategory{ObjectRef("twin"), 1}, "object", "2 objects have the name \"twin\"");
    refused(RemoveObjects{{ObjectRef("twin")}}, "objects", "2 objects have the name \"twin\"");
    refused(RemoveObjects{{}}, "objects", "at least one");
    refused(Carry{{}, left, true}, "objects", "at least one");
    refused(RemoveObjects{{ObjectId{1}, ObjectRef("ball")}}, "objects", "named twice");
    EXPECT_EQ(taken(SetCategory{ObjectRef("ball"), 1})->find({1})->category, 1);
    EXPECT_EQ(taken(RemoveObjects{{ObjectId{3}, ObjectRef("ball")}})->objects.size(), 3u);
}

TEST_F(Refusals, OfLockedObjects)
{
    for (const ObjectRef& ref : {ObjectRef("block"), ObjectRef(ObjectId{2})}) {
        refused(PlaceObject{ref, {}, {}}, "object", "\"block\" is locked");
        refused(SetMaterial{ref, material_spec("snow")}, "object", "locked");
        refused(SetCategory{ref, 1}, "object", "locked");
        refused(Rename{ref, "x"}, "object", "locked");
        refused(RemoveObjects{{ObjectRef("ball"), ref}}, "objects", "locked");
        refused(Carry{{ref}, left, true}, "objects", "locked");
    }
    EXPECT_EQ(taken(Carry{{ObjectRef("block")}, left, false}), d);
    EXPECT_TRUE(taken(SetFlags{ObjectRef("block"), {}, true})->find({2})->locked);
    EXPECT_FALSE(taken(SetFlags{ObjectRef("block"), false, {}})->find({2})->locked);
    EXPECT_TRUE(taken(SetFlags{ObjectRef("block"), false, true})->find({2})->hidden);
}

TEST_F(Refusals, OfCategoriesThatAreOfOtherClay)
{
    refused(SetCategory{ObjectRef("ball"), 9}, "category", "that of \"pot\"");
    refused(SetCategory{ObjectRef("pot"), 0}, "category", "that of \"ball\"");
    refused(SetCategory{ObjectRef("ball"), 256}, "category", "found 256");
    refused(SetCategory{ObjectRef("ball"), -1}, "category", "found -1");
    refused_object("that of \"pot\"", [](SceneObject& o) { o.category = 9; });
    refused_object("found 256", [](SceneObject& o) { o.category = 256; });
    EXPECT_EQ(taken(SetCategory{ObjectRef("pot"), 10})->find({5})->category, 10);
    EXPECT_EQ(taken(SetCategory{ObjectRef("ball"), 255})->find({1})->category, 255);
}

TEST_F(Refusals, OfPlacesOutsideTheWalls)
{
    const auto at = [](double x, double y, double z) {
        return PlaceObject{ObjectRef("ball"), Vec3<double>{x, y, z}, {}};
    };
    refused(at(0.96, 0.5, 0.5), "centre", "x from 0.91 to 1.01 m");
    refused(at(0.5, 0.04, 0.5), "centre", "y from -0.01 to 0.09 m");
    refused(at(0.5, 0.5, 2), "centre", "z from 1.95 to 2.05 m");
    refused(at(1001, 0, 0), "centre", "found 1001");
    refused(at(std::nan(""), 0, 0), "centre", "found");
    EXPECT_EQ(taken(at(0.95, 0.05, 0.5))->find({1})->pose.p.x, 0.95) << "touches two walls";
    refused_object("between the walls", [](SceneObject& o) { o.pose.p.x = 3; });
    refused_object("between the walls", [](SceneObject& o) { o.source.size = {2, 2, 2}; });
    const PlaceObject turned{ObjectRef("ball"), {}, Quat<double>{1, 0.1, 0, 0}};
    refused(turned, "rotation", "of length 1.00498");
    refused(PlaceObject{ObjectRef("ball"), {}, Quat<double>{std::nan(""), 0, 0, 0}}, "rotation",
            "length");
    // A rod along x that does not fit in when it stands.
    d = after(d, SetWalls{{}, Vec3<double>{1, 0.6, 1}, {}, {}}, ids);
    SceneObject rod = ball("rod");
    rod.source.shape = ShapeKind::box, rod.source.size = {0.9, 0.05, 0.05};
    d = after(d, AddObject{rod}, ids);
    const double half = std::sqrt(0.5);
    refused(PlaceObject{ObjectRef("rod"), {}, Quat<double>{half, 0, 0, half}}, "rotation",
            "y from");
}

TEST_F(Refusals, OfShapes)
{
    const auto refused_shape = [&](const std::string& why, ShapeKind shape, Vec3<double> size,
                                   double rounding = 0, const std::string& text = "") {
        refused_object(why, [&](SceneObject& o) {
            o.source.shape = shape, o.source.size = size;
            o.source.rounding = rounding, o.source.text = text;
        });
    };
    const double nan = std::nan("");
    refused_shape("tube: expected less than half the diameter, 0.1 m", ShapeKind::torus,
                  {0.2, 0.1, 0.2});
    refused_shape("one diameter", ShapeKind::torus, {0.2, 0.05, 0.3});
    refused_shape("above 0", ShapeKind::torus, {0.2, 0, 0.2});
    refused_shape("found", ShapeKind::torus, {0.2, nan, 0.2});
    refused_shape("height: expected at least the diameter", ShapeKind::capsule, {0.2, 0.1, 0.2});
    refused_shape("one diameter", ShapeKind::cone, {0.2, 0.1, 0.1});
    refused_shape("at most 1000", ShapeKind::cone, {0.2, 1e9, 0.2});
    refused_shape("above 0", ShapeKind::ellipsoid, {0.2, -0.1, 0.1});
    refused_shape("rounding: expected", ShapeKind::rounded_box, {0.2, 0.1, 0.2}, 0.06);
    refused_shape("rounding: expected", ShapeKind::rounded_box, {0.2, 0.1, 0.2}, nan);
    refused_shape("rounding: expected", ShapeKind::rounded_box, {0.2, 0.1, 0.2}, -0.01);
    refused_shape("text: expected", ShapeKind::text, {0, 0.1, 0.1});
    refused_shape("text: expected", ShapeKind::text, {0, 0.1, 0.1}, 0, "  ");
    refused_shape("1000 bytes", ShapeKind::text, {0, 0.1, 0.1}, 0, std::string(1001, 'x'));
    refused_shape("UTF-8", ShapeKind::text, {0, 0.1, 0.1}, 0, "\xff");
    refused_shape("above 0", ShapeKind::text, {0, 0, 0.1}, 0, "a");
    refused_shape("found", ShapeKind::text, {0, 0.1, nan}, 0, "a");
}

TEST_F(Refusals, OfMaterials)
{
    MaterialSpec m = material_spec("clay");
    m.young = 0;
    refused(SetMaterial{ObjectRef("ball"), m}, "material",
            "young: expected a solid's Young's modulus above 0 Pa, found 0");
    refused_object("young: expected", [&](SceneObject& o) { o.material = m; });
    m = material_spec("clay"), m.poisson = 0.6;
    refused(SetMaterial{ObjectRef("ball"), m}, "material",
            "poisson: expected 0 to 0.499, found 0.6");
    m = material_spec("clay"), m.density = std::nan("");
    refused(SetMaterial{ObjectRef("ball"), m}, "material", "density: expected");
    m = material_spec("clay"), m.elasticity = Elasticity::fixed_corotated;
    refused(SetMaterial{ObjectRef("ball"), m}, "material", "elasticity");
    m = material_spec("snow"), m.density = 333;
    const DocumentPtr with = taken(SetMaterial{ObjectRef("ball"), m});
    EXPECT_EQ(with->find({1})->material.density, 333);
    EXPECT_EQ(with->find({1})->material.name, "snow");
}

TEST_F(Refusals, OfNewObjects)
{
    for (const std::uint32_t used : {1u, 2u, 5u})
        refused_object("has been used", [&](SceneObject& o) { o.id = {used}; });
    d = after(d, RemoveObjects{{ObjectId{5}}}, ids);
    refused_object("the number 5 has been used", [&](SceneObject& o) { o.id = {5}; });
    d = taken(AddObject{[&] {
        SceneObject o = ball("");
        o.id = {90};
        return o;
    }()});
    EXPECT_EQ(d->objects.back()->name, "object 90");
    refused_object("has been used", [&](SceneObject& o) { o.id = {89}; });
    add("next");
    EXPECT_EQ(d->objects.back()->id.value, 91u);
    refused_object("found 1", [](SceneObject& o) { o.source.per_cell = 1; });
    refused_object("above 0", [](SceneObject& o) { o.source.size.x = 0; });
    refused_object("2000", [](SceneObject& o) { o.source.velocity.x = 2000; });
    refused_object("of length 2", [](SceneObject& o) { o.pose.q.w = 2; });
    refused_object("1000 bytes", [](SceneObject& o) { o.name = std::string(1001, 'x'); });
    // One object at most is local clay.
    SceneObject local = ball("local");
    local.source.shape = ShapeKind::splats, local.category = 9;
    local.source.splats = {"x.ply", UpAxis::y, 0.1, 0, 0.01};
    d = taken(AddObject{local});
    refused(AddObject{local}, "object", "at most one object with a depth");
    // And at most 256 there are.
    while (int(d->objects.size()) < most_objects) add("many");
    refused(AddObject{ball("one too many")}, "object", "at most 256 objects");
    d = after(d, RemoveObjects{{ObjectId{1}}}, ids);
    EXPECT_EQ(int(taken(AddObject{ball("instead")})->objects.size()), most_objects);
}

TEST_F(Refusals, OfNumbersOfObjectsThatLogsCouldNotHold)
{
    SceneObject o = ball("last");
    o.id = {0x80000000u};
    refused(AddObject{o}, "object", "expected");
    o.id = {0x7fffffffu};
    d = taken(AddObject{o});
    refused(AddObject{ball("after the last")}, "object", "numbers");
}

TEST_F(Refusals, OfNamesAndTexts)
{
    refused(Rename{ObjectRef("ball"), ""}, "name", "expected a name");
    refused(Rename{ObjectRef("ball"), std::string(1001, 'x')}, "name", "1000 bytes");
    refused(Rename{ObjectRef("ball"), "\xff"}, "name", "UTF-8");
    refused_object("UTF-8", [](SceneObject& o) { o.name = "\xc3"; });
    refused(Mark{std::string(1001, 'x')}, "text", "1000 bytes");
    refused(Mark{"\xf0\x9f\x99"}, "text", "UTF-8");
    refused(Open{std::string(1001, 'x'), {}, {}}, "file", "1000 bytes");
    EXPECT_EQ(taken(Rename{ObjectRef("ball"), "Bällchen 🙂"})->find({1})->name,
              "Bällchen 🙂");
    EXPECT_EQ(taken(Rename{ObjectRef("ball"), "ball"}), d);
}

TEST_F(Refusals, OfSettings)
{
    refused(SetGravity{{0, -1000.5, 0}}, "gravity", "found -1000.5");
    refused(SetGravity{{0, 0, std::nan("")}}, "gravity", "-1000");
    EXPECT_EQ(taken(SetGravity{{0, -1000, 1000}})->scene->gravity.y, -1000);
    EXPECT_EQ(taken(SetGravity{d->scene->gravity}), d);
    refused(SetWalls{Vec3<double>{0, 1, 0}, {}, {}, {}}, "min", "above that of min");
    refused(SetWalls{{}, Vec3<double>{1, 0, 1}, {}, {}}, "max", "above that of min");
    refused(SetWalls{{}, Vec3<double>{1, 1, 1001}, {}, {}}, "max", "found 1001");
    refused(SetWalls{{}, {}, {}, -0.1}, "friction", "found -0.1");
    EXPECT_EQ(taken(SetWalls{{}, {}, ContactMode::slip, {}})->scene->walls.mode, ContactMode::slip);
    refused(SetContact{{}, 2.1}, "friction", "found 2.1");
    EXPECT_TRUE(taken(SetContact{CategoryContact::separate, {}})->scene->contact.separate);
    EXPECT_EQ(taken(SetContact{{}, 0.9})->scene->contact.friction, 0.9);
    EXPECT_EQ(taken(SetContact{CategoryContact::weld, 0.4}), d);
    refused(SetHands{{{}, "spoon"}, {}, {}, {}}, "left", "there is no tool \"spoon\"");
    refused(SetHands{{}, {{}, "knive"}, {}, {}}, "right", "the nearest is \"knife\"");
    refused(SetHands{{}, {}, 0.0, {}}, "zoom", "found 0");
    refused(SetHands{{}, {}, {}, Vec3<double>{0, 2000, 0}}, "at", "found 2000");
    const DocumentPtr with = taken(SetHands{{false, {}}, {{}, "knife"}, 2.0, {}});
    EXPECT_FALSE(with->hands->present[left]);
    EXPECT_TRUE(with->hands->present[right]);
    EXPECT_EQ(with->hands->held[right], "knife");
    refused(SetSurface{7}, "nodes", "found 7");
    refused(SetSurface{1025}, "nodes", "found 1025");
    refused(SetLattice{7}, "cells", "found 7");
    refused(Advance{0}, "frames", "found 0");
    refused(Open{"x", {}, 4}, "cells", "found 4");
    for (const Command& command : {Command(Reset{}), Command(Pause{true}), Command(Play{true}),
                                   Command(Mark{"x"}), Command(SetLattice{8})})
        EXPECT_EQ(taken(command), d);
}

TEST_F(Refusals, OfCopies)
{
    const Vec3<double> by{0.2, 0, 0};
    refused(CopyObjects{{}, by, {}, {}}, "objects", "at least one");
    refused(CopyObjects{{ObjectRef("pot")}, by, {}, {}}, "objects", "near hands only");
    refused(CopyObjects{{ObjectRef("ball"), ObjectId{1}}, by, {}, {}}, "objects", "named twice");
    refused(CopyObjects{{ObjectRef("ball")}, {1001, 0, 0}, {}, {}}, "by", "found 1001");
    refused(CopyObjects{{ObjectRef("ball")}, {999.9, 0, 0}, {}, {}}, "by", "1000");
    refused(CopyObjects{{ObjectRef("ball")}, by, {"a", "b"}, {}}, "names", "at most 1 names");
    refused(CopyObjects{{ObjectRef("ball")}, by, {""}, {}}, "names", "expected a name");
    refused(CopyObjects{{ObjectRef("ball")}, by, {}, {{5}}}, "ids", "5 has been used");
    refused(CopyObjects{{ObjectRef("ball")}, by, {}, {{8}, {9}}}, "ids", "expected 1");
    refused(CopyObjects{{ObjectRef("ball"), ObjectRef("block")}, by, {}, {{9}, {8}}}, "ids", "8");
    // A locked object may be copied; the copy is not locked.
    d = taken(CopyObjects{{ObjectRef("ball"), ObjectRef("block")}, by, {"second"}, {}});
    EXPECT_EQ(d->find({6})->name, "second");
    EXPECT_EQ(d->find({7})->name, "block copy");
    EXPECT_FALSE(d->find({7})->locked);
    EXPECT_DOUBLE_EQ(d->find({7})->pose.p.x, 0.7);
    d = taken(CopyObjects{{ObjectRef("second")}, by, {}, {{20}}});
    EXPECT_EQ(d->find({20})->name, "second copy");
    while (d->objects.size() < std::size_t(most_objects)) add("more");
    refused(CopyObjects{{ObjectRef("ball")}, by, {}, {}}, "objects", "at most 256");
    refused(SplitObject{ObjectRef("ball"), {}, true, {}, {}}, "object", "at most 256");
}

TEST_F(Refusals, OfOtherSizes)
{
    for (const double factor : {0.0, -1.0, 1000.0, 0.0999, 10.001, double(NAN), double(INFINITY)})
        refused(ScaleObjects{{ObjectRef("ball")}, factor}, "factor", "expected");
    refused(MoveObjects{{ObjectRef("block")}, Vec3<double>{1, 0, 0}, {}, {}}, "objects", "locked");
    refused(MoveObjects{{ObjectRef("pot")}, Vec3<double>{1, 0, 0}, {}, {}}, "objects",
            "near hands only");
    refused(MoveObjects{{ObjectRef("ball")}, Vec3<double>{1000, 0, 0}, {}, {}}, "by", "expected");
    EXPECT_EQ(taken(MoveObjects{{ObjectRef("ball")}, Vec3<double>{}, {}, {}}), d);
    EXPECT_EQ(taken(MoveObjects{{ObjectRef("ball")}, {}, Quat<double>{1, 0, 0, 0}, {}}), d);
    refused(SetColour{{ObjectRef("block")}, Vec3<double>{1, 0, 0}}, "objects", "locked");
    refused(SetColour{{ObjectRef("ball")}, Vec3<double>{1, 0, 1.1}}, "colour", "expected");
    EXPECT_EQ(taken(SetColour{{ObjectRef("ball")}, {}}), d);
    const DocumentPtr red = taken(SetColour{{ObjectRef("ball")}, Vec3<double>{1, 0, 0}});
    EXPECT_TRUE(red->find({1})->colour);
    EXPECT_FALSE(equal(*red, *d));
    EXPECT_TRUE(equal(parse_document(document_text(*red), "red", ""), *red));
    refused(ResetObjects{{ObjectRef("block")}}, "objects", "locked");
    refused(ResetObjects{{ObjectRef("pot")}}, "objects", "near hands only");
    refused(ScaleObjects{{}, 2}, "objects", "at least one");
    refused(ScaleObjects{{ObjectRef("block")}, 2}, "objects", "locked");
    refused(ScaleObjects{{ObjectRef("pot")}, 2}, "objects", "near hands only");
    refused(ScaleObjects{{ObjectId{1}, ObjectId{1}}, 2}, "objects", "named twice");
    EXPECT_EQ(taken(ScaleObjects{{ObjectRef("ball")}, 1}), d);
    DocumentPtr two = taken(ScaleObjects{{ObjectRef("ball")}, 2});
    EXPECT_DOUBLE_EQ(two->find({1})->source.size.y, 0.2);
    std::swap(d, two);
    for (int i = 0; i < 3; ++i) d = taken(ScaleObjects{{ObjectRef("ball")}, 10});
    refused(ScaleObjects{{ObjectRef("ball")}, 10}, "factor", "1000 m");
}

TEST_F(Refusals, OfMerges)
{
    refused(MergeObjects{{ObjectRef("ball")}, {}}, "objects", "at least two");
    refused(MergeObjects{{ObjectRef("ball"), ObjectId{1}}, {}}, "objects", "named twice");
    refused(MergeObjects{{ObjectRef("ball"), ObjectRef("block")}, {}}, "objects", "locked");
    refused(MergeObjects{{ObjectRef("block"), ObjectRef("ball")}, {}}, "objects", "locked");
    refused(MergeObjects{{ObjectRef("ball"), ObjectRef("pot")}, {}}, "objects", "near hands");
    refused(MergeObjects{{ObjectId{1}, ObjectId{3}}, ""}, "name", "expected a name");
    SceneObject splats = *d->find({5});
    splats.id = {}, splats.source.splats.depth = 0;
    for (const int category : {9, 9, 10}) {
        splats.name = "s" + std::to_string(d->objects.size()), splats.category = category;
        d = taken(AddObject{splats});
    }
    refused(MergeObjects{{ObjectId{1}, ObjectRef("s5")}, {}}, "objects", "of splats");
    refused(MergeObjects{{ObjectRef("s5"), ObjectRef("s7")}, {}}, "objects", "its category");
    EXPECT_EQ(taken(MergeObjects{{ObjectRef("s5"), ObjectRef("s6")}, {}})->objects.size(), 7u);
    const DocumentPtr merged = taken(MergeObjects{{ObjectId{3}, ObjectId{1}, ObjectId{4}}, "c"});
    EXPECT_EQ(merged->objects.size(), 6u);
    EXPECT_EQ(merged->find({3})->name, "c");
    EXPECT_EQ(merged->find({1}), nullptr);
}

TEST_F(Refusals, OfSplits)
{
    const SplitPlane plane{{0.5, 0.5, 0.5}, {0, 2, 0}};
    const ObjectRef ball = ObjectId{1};
    refused(SplitObject{ball, {}, {}, {}, {}}, "plane", "either");
    refused(SplitObject{ball, {}, false, {}, {}}, "plane", "either");
    refused(SplitObject{ball, plane, true, {}, {}}, "pieces", "either");
    refused(SplitObject{ball, SplitPlane{{}, {}}, {}, {}, {}}, "plane", "longer than 0");
    refused(SplitObject{ball, SplitPlane{{}, {NAN, 0, 0}}, {}, {}, {}}, "plane", "expected");
    refused(SplitObject{ball, SplitPlane{{1e9, 0, 0}, {1, 0, 0}}, {}, {}, {}}, "plane", "m, found");
    refused(SplitObject{ObjectRef("block"), plane, {}, {}, {}}, "object", "locked");
    refused(SplitObject{ObjectRef("pot"), plane, {}, {}, {}}, "object", "near hands only");
    refused(SplitObject{ball, plane, {}, {"a", "b", "c"}, {}}, "names", "at most 2");
    refused(SplitObject{ball, plane, {}, {}, {{1}}}, "ids", "each part");
    refused(SplitObject{ball, plane, {}, {}, {{1}, {7}, {8}}}, "ids", "each part");
    refused(SplitObject{ball, plane, {}, {}, {{7}, {8}}}, "ids", "expected 1 once");
    refused(SplitObject{ball, plane, {}, {}, {{1}, {2}}}, "ids", "2 has been used");
    const DocumentPtr two = taken(SplitObject{ball, plane, {}, {"l", "r"}, {}});
    EXPECT_EQ(two->find({1})->name, "l");
    EXPECT_EQ(two->find({6})->name, "r");
    d = taken(SplitObject{ball, plane, {}, {"l", "r"}, {{7}, {1}}});
    EXPECT_EQ(d->find({1})->name, "r");
    EXPECT_EQ(d->find({7})->name, "l");
    d = taken(SplitObject{ball, {}, true, {}, {{1}, {8}, {9}}});
    EXPECT_EQ(d->find({1})->name, "r");
    EXPECT_EQ(d->find({8})->name, "r 2");
    EXPECT_EQ(d->find({9})->name, "r 3");
}

// Commands are logged with ids.
TEST_F(Refusals, AreNotOfNamesThatAreReplacedByIds)
{
    const Command of[] = {SetCategory{ObjectRef("pot"), 1},
                          RemoveObjects{{ObjectRef("pot"), ObjectId{1}}},
                          Carry{{ObjectRef("ball")}, left, true}};
    const char* text[] = {R"({"set_category":{"category":1,"object":5}})",
                          R"({"remove_objects":{"objects":[5,1]}})",
                          R"({"carry":{"begins":true,"objects":[1],"side":"left"}})"};
    for (int i = 0; i < 3; ++i) EXPECT_EQ(json_of(with_ids(*d, of[i])).dump(), text[i]);
    EXPECT_EQ(std::get<ObjectId>(resolved(*d, ObjectRef("pot"))).value, 5u);
    EXPECT_EQ(std::get<Refusal>(resolved(*d, ObjectRef("twin"), "x")).field, "x");
}

TEST(Document, HiddenCategoriesAreThoseWhoseObjectsAreAllHidden)
{
    IdSource ids;
    DocumentPtr d = empty_room();
    Random r(3);
    const Drawing by{0, d.get()};
    for (int i = 0; i < 5; ++i) {
        SceneObject o = random_object(r, by);
        o.id = {}, o.category = i / 2, o.hidden = i != 3, o.locked = false;
        d = after(d, AddObject{o}, ids);
    }
    EXPECT_EQ(d->hidden_categories(), (std::vector<int>{0, 2}));
}

}  // namespace
}  // namespace knead
