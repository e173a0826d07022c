// Objects, materials and walls as JSON: what is written reads again with the same bits.
#include "host/scene/object_json.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "host/base/font_file.h"
#include "host/scene/domain.h"
#include "host/scene/names.h"
#include "host/scene/presets.h"
#include "tests/reason.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

// Through text, as in a file.
template <class Read>
auto again(const Json& json, const Read& read, const std::string& file = "document.json")
{
    decltype(read(std::declval<ObjectReader&>())) found{};
    ObjectReader::read(parse_json(json.dump(), file), file, "",
                       [&](ObjectReader& r) { found = read(r); });
    return found;
}
Object object_again(const Json& json, const std::string& file = "document.json")
{
    return again(
        json, [](ObjectReader& r) { return read_object(r, "object 3"); }, file);
}
MaterialSpec material_again(const Json& json)
{
    return again({{"material", json}},
                 [](ObjectReader& r) { return read_material(r, "material"); });
}

std::uint64_t bits(double value) { return std::bit_cast<std::uint64_t>(value); }
bool same(Vec3<double> a, Vec3<double> b)
{
    return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

void expect_same(const MaterialSpec& a, const MaterialSpec& b)
{
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.elasticity, b.elasticity);
    EXPECT_EQ(a.plasticity, b.plasticity);
    for (const MaterialQuantity& q : material_quantities())
        EXPECT_EQ(bits(a.*q.value), bits(b.*q.value)) << q.key << " " << a.*q.value;
}

// A preset with other laws and other values of what these use, anywhere in their ranges; not
// always valid.
MaterialSpec drawn_material(Draw& draw)
{
    const auto& presets = material_specs();
    MaterialSpec m = presets[std::size_t(draw.below(int(presets.size())))];
    if (draw.below(3) == 0)
        m.elasticity = elasticities[std::size_t(draw.below(int(elasticities.size())))].second;
    if (draw.below(3) == 0)
        m.plasticity = plasticities[std::size_t(draw.below(int(plasticities.size())))].second;
    for (const MaterialQuantity& q : material_quantities()) {
        if (!q.used(m)) continue;
        const int how = draw.below(8);
        double& value = m.*q.value;
        if (how == 0) value = draw.in(q.low, q.high);
        if (how == 1) value = q.low;
        if (how == 2) value = q.high * (1 + 1e-10);
        if (how == 3 && q.high > 1) value = draw.power(-3, std::log10(q.high));
        if (how == 4 && q.low == 0) value = -0.0;
        if (how == 5) value = std::nextafter(value, q.high);
    }
    return m;
}

Vec3<double> drawn_extent(Draw& draw)
{
    return {draw.power(-3, 2), draw.power(-3, 2), draw.power(-3, 2)};
}

Object drawn_object(Draw& draw)
{
    Object o;
    o.name = "object \"" + std::to_string(draw.below(1000)) + "\" \xc3\xa4";
    o.shape = shape_kinds[std::size_t(draw.below(int(shape_kinds.size())))].second;
    o.centre = draw.vector(1000), o.velocity = draw.vector(10);
    if (draw.below(2)) o.rotation = unit_rotation({draw.in(-1, 1), draw.in(-1, 1), 0.5, -0.0});
    do o.stated = normalised(drawn_material(draw));
    while (fault_of(o.stated));
    o.category = draw.below(256), o.per_cell = draw.in(2, 64);
    o.size = drawn_extent(draw);
    if (o.shape == ShapeKind::text && font_file().empty()) o.shape = ShapeKind::box;
    if (o.shape == ShapeKind::sphere) o.size.y = o.size.x;
    if (o.shape == ShapeKind::capsule) o.size.y = std::max(o.size.y, o.size.x);
    if (o.shape == ShapeKind::torus) o.size.y = o.size.x * draw.in(0.01, 0.49);
    const bool three = o.shape == ShapeKind::box || o.shape == ShapeKind::ellipsoid ||
                       o.shape == ShapeKind::rounded_box;
    if (!three) o.size.z = o.size.x;
    if (o.shape == ShapeKind::rounded_box)
        o.rounding = draw.in(0, 0.5) * std::min({o.size.x, o.size.y, o.size.z});
    if (o.shape == ShapeKind::text) o.text = "Ton \xc3\xa4", o.size.x = 0;
    if (o.shape == ShapeKind::strand) {
        Strand s;
        s.section = section_kinds[std::size_t(draw.below(int(section_kinds.size())))].second;
        s.diameter = draw.in(0.01, 0.1), s.open = draw.below(2);
        if (s.section == SectionKind::outline) s.outline = {{0, 0}, {draw.in(1, 2), 0}, {0, 1}};
        for (int n = 1 + draw.below(4); n > 0; --n)
            s.path.push_back({draw.vector(0.5), draw.below(2) ? Vec3<double>{} : draw.vector(1)});
        o.size = {}, o.strand = std::make_shared<const Strand>(std::move(s));
    }
    if (o.shape == ShapeKind::mesh) {
        o.size = {};
        o.mesh = {"folder/cup.stl",
                  up_axes[std::size_t(draw.below(int(up_axes.size())))].second,
                  draw.in(-360, 360),
                  draw.power(-3, 2),
                  0,
                  draw.in(0, 1)};
        if (draw.below(2)) std::swap(o.mesh.size, o.mesh.scale);
    }
    if (o.shape != ShapeKind::splats) return o;
    o.size = {};
    o.splats = {"folder/cup.ply", up_axes[std::size_t(draw.below(int(up_axes.size())))].second,
                draw.power(-3, 2), draw.in(-360, 360), draw.in(0, 1)};
    return o;
}

TEST(ObjectJson, MaterialsReadAgainAsTheyWereWritten)
{
    Draw draw(1);
    int valid = 0;
    for (int i = 0; i < 20000 && !HasFailure(); ++i) {
        const MaterialSpec m = drawn_material(draw);
        if (fault_of(m)) continue;
        ++valid;
        const MaterialSpec once = normalised(m);
        expect_same(once, normalised(once));
        EXPECT_FALSE(fault_of(once));
        expect_same(once, material_again(json_of(once)));
        const Material<double> a = made(m), b = made(once);
        EXPECT_NEAR(a.density, b.density, 1e-9 * a.density);
        EXPECT_NEAR(a.mu, b.mu, 1e-9 * a.mu);
    }
    EXPECT_GT(valid, 5000);
}

TEST(ObjectJson, PresetsAreWrittenByTheirNameAlone)
{
    for (const MaterialSpec& preset : material_specs()) {
        EXPECT_EQ(json_of(preset), (Json{{"preset", preset.name}}));
        expect_same(preset, material_again(preset.name));
        expect_same(preset, material_again(json_of(preset)));
        expect_same(preset, normalised(preset));
        MaterialSpec other = preset;
        other.density = 1234.5;
        EXPECT_EQ(json_of(other), (Json{{"preset", preset.name}, {"density", 1234.5}}));
    }
}

TEST(ObjectJson, MaterialsWithoutAPresetAreChangedClay)
{
    for (const MaterialSpec& preset : material_specs()) {
        MaterialSpec m = normalised(stated(made(preset)));
        EXPECT_EQ(m.name, "clay");
        EXPECT_FALSE(fault_of(m));
        expect_same(m, material_again(json_of(m)));
        m.name = "no-such";
        EXPECT_EQ(normalised(m).name, "clay");
    }
}

TEST(ObjectJson, ObjectsReadAgainAsTheyWereWritten)
{
    Draw draw(2);
    for (int i = 0; i < 5000 && !HasFailure(); ++i) {
        const Object o = drawn_object(draw), found = object_again(json_of(o));
        EXPECT_EQ(found.name, o.name);
        EXPECT_EQ(found.shape, o.shape);
        EXPECT_TRUE(same(found.centre, o.centre));
        EXPECT_TRUE(same(found.size, o.size));
        EXPECT_TRUE(same(found.velocity, o.velocity));
        EXPECT_EQ(bits(found.rotation.w), bits(o.rotation.w));
        EXPECT_TRUE(same({found.rotation.x, found.rotation.y, found.rotation.z},
                         {o.rotation.x, o.rotation.y, o.rotation.z}));
        expect_same(found.stated, o.stated);
        EXPECT_EQ(found.category, o.category);
        EXPECT_EQ(found.material.category, o.category);
        EXPECT_EQ(bits(found.per_cell), bits(o.per_cell));
        EXPECT_EQ(bits(found.rounding), bits(o.rounding));
        EXPECT_EQ(found.text, o.text);
        EXPECT_EQ(found.letters != nullptr, o.shape == ShapeKind::text);
        EXPECT_EQ(found.splats.file, o.splats.file);
        EXPECT_EQ(found.splats.up, o.splats.up);
        EXPECT_EQ(bits(found.splats.size), bits(o.splats.size));
        EXPECT_EQ(bits(found.splats.turn), bits(o.splats.turn));
        EXPECT_EQ(bits(found.splats.depth), bits(o.splats.depth));
        EXPECT_EQ(found.mesh.file, o.mesh.file);
        EXPECT_EQ(found.mesh.up, o.mesh.up);
        EXPECT_EQ(bits(found.mesh.turn), bits(o.mesh.turn));
        EXPECT_EQ(bits(found.mesh.size), bits(o.mesh.size));
        EXPECT_EQ(bits(found.mesh.scale), bits(o.mesh.scale));
        EXPECT_EQ(bits(found.mesh.hollow), bits(o.mesh.hollow));
        EXPECT_EQ(json_of(found), json_of(o));
    }
}

TEST(ObjectJson, FilesAreRelativeToTheDocument)
{
    const Json json = {
        {"shape", "splats"}, {"file", "b/cup.ply"}, {"size", 1}, {"centre", {0, 0, 0}}};
    for (const char* path : {"a/scene.json", "/a/scene.json", "./a/scene.json", "scene.json"}) {
        const Object o = object_again(json, path);
        const Json written = json_of(o, path);
        EXPECT_EQ(written["file"], "b/cup.ply") << path;
        EXPECT_EQ(object_again(written, path).splats.file, o.splats.file) << path;
    }
}

TEST(ObjectJson, AMeshHasASizeAScaleOrAUnit)
{
    const auto read = [](const char* key, const Json& value) {
        Json json = {{"shape", "mesh"}, {"file", "cup.stl"}, {"centre", {0, 0, 0}}};
        json[key] = value;
        return object_again(json);
    };
    EXPECT_EQ(read("size", 0.2).mesh.size, 0.2);
    EXPECT_EQ(read("scale", 0.5).mesh.scale, 0.5);
    EXPECT_EQ(read("unit", "mm").mesh.scale, 0.001);
    EXPECT_EQ(read("unit", "in").mesh.scale, 0.0254);
    EXPECT_EQ(read("unit", "cm").mesh.size, 0);
    EXPECT_THROW(read("up", "y"), InputError);
    EXPECT_THROW(read("unit", "ft"), InputError);
    EXPECT_THROW(read("size", 0), InputError);
    const Json both = {
        {"shape", "mesh"}, {"file", "c.stl"}, {"centre", {0, 0, 0}}, {"size", 1}, {"unit", "m"}};
    EXPECT_THROW(object_again(both), InputError);
}

TEST(ObjectJson, RotationsAreDividedByTheirLengthOnce)
{
    Draw draw(3);
    for (int i = 0; i < 10000; ++i) {
        const Vec3<double> axis = draw.in(0.9991, 1.0009) * draw.direction();
        const double turn = draw.in(-4, 4), c = std::cos(turn), s = std::sin(turn);
        Object o;
        o.size = {1, 1, 1}, o.stated = material_spec("clay");
        o.rotation = {c, s * axis.x, s * axis.y, s * axis.z};
        const Object once = object_again(json_of(o)), twice = object_again(json_of(once));
        ASSERT_NEAR(dot(axis, axis) * s * s + c * c, 1, 0.002);
        const Quat<double> a = once.rotation, b = twice.rotation;
        ASSERT_NEAR(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z, 1, 1e-15);
        ASSERT_EQ(bits(a.w), bits(b.w));
        ASSERT_TRUE(same({a.x, a.y, a.z}, {b.x, b.y, b.z}));
    }
}

TEST(ObjectJson, RotationsOfAnotherLengthAreRefused)
{
    const auto complaint = [](const Json& rotation) {
        return reason<InputError>([&] {
            object_again({{"centre", {0, 0, 0}}, {"diameter", 1}, {"rotation", rotation}});
        });
    };
    EXPECT_EQ(complaint({0, 1, 0, 0}), "");
    EXPECT_EQ(complaint({0.9995, 0, 0, 0}), "");
    EXPECT_EQ(complaint({1, 1, 0, 0}),
              "document.json: /rotation: expected a quaternion [w, x, y, z] of length 1, within "
              "0.001, found length 1.4142135623730951");
    EXPECT_NE(complaint({0.9989, 0, 0, 0}), "");
    EXPECT_NE(complaint({0, 0, 0, 0}), "");
    EXPECT_NE(complaint({1e200, 1e200, 0, 0}), "");
    for (const Json& wrong : {Json("x"), Json({1, 0, 0}), Json({1, 0, 0, "0"}), Json(1)})
        EXPECT_NE(complaint(wrong).find("expected a quaternion [w, x, y, z] of length 1, found"),
                  std::string::npos);
}

TEST(ObjectJson, WallsReadAgainAsTheyWereWritten)
{
    Draw draw(4);
    const Lattice<double> lattice{{64, 32, 48}, 1.0 / 64};
    WallOptions last{{0, 0, 0}, {1, 0.5, 0.75}, ContactMode::sticky, 0.4};
    for (int i = 0; i < 1000; ++i) {
        const WallOptions walls{{draw.in(0, 0.2), draw.in(0, 0.2), draw.in(0, 0.2)},
                                {draw.in(0.4, 1), draw.in(0.4, 0.5), draw.in(0.4, 0.75)},
                                contact_modes[std::size_t(draw.below(3))].second,
                                draw.in(0, 10)};
        const auto read = [&](ObjectReader& r) { return read_walls(r, last, lattice); };
        const WallOptions found = again(json_of(walls), read), kept = again(Json::object(), read);
        ASSERT_TRUE(same(found.min, walls.min) && same(found.max, walls.max));
        ASSERT_EQ(found.mode, walls.mode);
        ASSERT_EQ(bits(found.friction), bits(walls.friction));
        ASSERT_TRUE(same(kept.min, last.min) && same(kept.max, last.max));
        last = walls;
    }
}

}  // namespace
}  // namespace knead
