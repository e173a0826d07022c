#include "host/scene/object_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/scene/names.h"
#include "host/scene/presets.h"
#include "host/scene/shapes.h"
#include "host/scene/splats_options.h"

namespace knead {
namespace {

constexpr Quat<double> upright_pose{1, 0, 0, 0};

void override_material(ObjectReader& r, MaterialSpec& m)
{
    m.elasticity = r.choice("elasticity", elasticities, m.elasticity);
    r.refuse_renamed("flow", "plasticity");
    m.plasticity = r.choice("plasticity", plasticities, m.plasticity);
    for (const MaterialQuantity& q : material_quantities())
        m.*q.value = r.number(q.key, {q.low, q.high, q.unit}, m.*q.value);
}

const MaterialSpec& named_material(const ObjectReader& r, const std::string& key, const Json& name)
{
    if (!name.is_string()) r.fail(key, "the name of a preset", described(name));
    try {
        return material_spec(name.get<std::string>());
    } catch (const InputError& e) {
        throw InputError(r.file() + ": " + r.pointer(key) + ": " + e.what());
    }
}

const MaterialSpec& preset_of(const MaterialSpec& material)
{
    const auto& all = material_specs();
    const auto at = std::find_if(
        all.begin(), all.end(), [&](const MaterialSpec& one) { return one.name == material.name; });
    return at == all.end() ? material_spec("clay") : *at;
}

// Distinguishes 0 from -0.
bool same_number(double a, double b) { return a == b && std::signbit(a) == std::signbit(b); }

double length_of(Quat<double> q)
{
    return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
}

// Points of numbers, each of `size`. Coordinates are finite.
std::vector<std::vector<double>> read_points(ObjectReader& r, const std::string& key,
                                             std::size_t size, std::size_t most)
{
    const std::string expected =
        fmt::format("a list of at most {} points of {} numbers", most, size);
    const Json& list = r.required(key, expected);
    if (!list.is_array() || list.size() > most) r.fail(key, expected, described(list));
    std::vector<std::vector<double>> all;
    for (const Json& one : list) {
        if (!one.is_array() || one.size() != size) r.fail(key, expected, described(one));
        std::vector<double>& point = all.emplace_back();
        for (const Json& x : one) {
            if (!x.is_number() || !(std::abs(x.get<double>()) <= largest_extent))
                r.fail(key, fmt::format("numbers from -{0} to {0}", largest_extent), described(x));
            point.push_back(x.get<double>());
        }
    }
    return all;
}

}  // namespace

std::vector<Point2> read_outline(ObjectReader& r, const std::string& key)
{
    std::vector<Point2> outline;
    for (const auto& p : read_points(r, key, 2, most_outline_points))
        outline.push_back({p[0], p[1]});
    return outline;
}

Json json_of(const std::vector<Point2>& outline)
{
    Json all = Json::array();
    for (const Point2 p : outline) all.push_back({p.x, p.y});
    return all;
}

Quat<double> read_rotation(ObjectReader& r, const std::string& key)
{
    const Json* given = r.find(key);
    if (!given) return upright_pose;
    const std::string expected = "a quaternion [w, x, y, z] of length 1";
    if (!given->is_array() || given->size() != 4) r.fail(key, expected, described(*given));
    for (const Json& one : *given)
        if (!one.is_number()) r.fail(key, expected, described(*given));
    const Json& q = *given;
    const Quat<double> read{q[0].get<double>(), q[1].get<double>(), q[2].get<double>(),
                            q[3].get<double>()};
    const double length = length_of(read);
    if (!(length >= 0.999 && length <= 1.001))
        r.fail(key, expected + ", within 0.001", "length " + short_number(length));
    return unit_rotation(read);
}

namespace {

constexpr Bounds extent{0, largest_extent, "m", true};

void read_strand(ObjectReader& r, Object& o)
{
    Strand s;
    s.section = r.choice("section", section_kinds, s.section);
    s.diameter = r.number("diameter", extent);
    if (r.has("outline")) s.outline = read_outline(r, "outline");
    for (const auto& p : read_points(r, "path", 3, most_strand_points))
        s.path.push_back({{p[0], p[1], p[2]}, {}});
    if (r.has("axes")) {
        const auto axes = read_points(r, "axes", 3, most_strand_points);
        if (axes.size() != s.path.size())
            r.fail("axes", fmt::format("{} axes, one per point", s.path.size()),
                   std::to_string(axes.size()));
        for (std::size_t i = 0; i < axes.size(); ++i)
            s.path[i].axis = {axes[i][0], axes[i][1], axes[i][2]};
    }
    s.open = r.flag("open", false);
    o.strand = std::make_shared<const Strand>(std::move(s));
}

void write_strand(const Strand& s, Json& all)
{
    all["section"] = name_of(section_kinds, s.section);
    all["diameter"] = s.diameter;
    if (!s.outline.empty()) all["outline"] = json_of(s.outline);
    const auto points = [&](const char* key, auto member) {
        all[key] = Json::array();
        for (const StrandPoint& p : s.path) {
            const Vec3<double>& v = p.*member;
            all[key].push_back({v.x, v.y, v.z});
        }
    };
    points("path", &StrandPoint::at);
    const Vec3<double> none{};
    const bool axes = std::ranges::any_of(s.path, [&](const StrandPoint& p) {
        return !same_number(p.axis.x, none.x) || !same_number(p.axis.y, none.y) ||
               !same_number(p.axis.z, none.z);
    });
    if (axes) points("axes", &StrandPoint::axis);
    if (s.open) all["open"] = true;
}

// The keys of a shape's size; write_shape() writes them.
void read_shape(ObjectReader& r, Object& o)
{
    switch (o.shape) {
        case ShapeKind::box:
        case ShapeKind::ellipsoid:
            o.size = r.vector("size", extent);
            break;
        case ShapeKind::rounded_box:
            o.size = r.vector("size", extent);
            o.rounding = r.number("rounding", {0, largest_extent / 2, "m"},
                                  std::min({o.size.x, o.size.y, o.size.z}) / 4);
            break;
        case ShapeKind::cylinder:
        case ShapeKind::cone:
        case ShapeKind::capsule: {
            const double across = r.number("diameter", extent);
            o.size = {across, r.number("height", extent), across};
            break;
        }
        case ShapeKind::torus: {
            const double across = r.number("diameter", extent);
            o.size = {across, r.number("tube", extent), across};
            break;
        }
        case ShapeKind::text:
            r.required("text", "a text");
            o.text = r.text("text", "");
            o.size = {0, r.number("height", extent), r.number("depth", extent)};
            add_letters(o);
            break;
        case ShapeKind::strand:
            read_strand(r, o);
            break;
        case ShapeKind::mesh:  // see read_mesh_options()
            break;
        case ShapeKind::sphere:
        case ShapeKind::splats: {
            const double across = r.number("diameter", extent);
            o.size = {across, across, across};
            break;
        }
    }
    if (const auto fault = shape_fault(o)) r.fail(fault->key, fault->expected, fault->found);
}

void write_shape(const Object& o, Json& all)
{
    switch (o.shape) {
        case ShapeKind::rounded_box:
            all["rounding"] = o.rounding;
            [[fallthrough]];
        case ShapeKind::box:
        case ShapeKind::ellipsoid:
            all["size"] = {o.size.x, o.size.y, o.size.z};
            break;
        case ShapeKind::cylinder:
        case ShapeKind::cone:
        case ShapeKind::capsule:
            all["height"] = o.size.y;
            [[fallthrough]];
        case ShapeKind::sphere:
        case ShapeKind::splats:
            all["diameter"] = o.size.x;
            break;
        case ShapeKind::torus:
            all["diameter"] = o.size.x, all["tube"] = o.size.y;
            break;
        case ShapeKind::text:
            all["text"] = o.text, all["height"] = o.size.y, all["depth"] = o.size.z;
            break;
        case ShapeKind::strand:
            write_strand(*o.strand, all);
            break;
        case ShapeKind::mesh:
            break;
    }
}

double read_per_cell(ObjectReader& r)
{
    const double per_cell = r.number("per_cell", {1, 64, "particles per cell"}, 8);
    if (per_cell < 2)
        r.fail("per_cell",
               "at least 2 and at most 64 particles per cell (of fewer, clay drawn to 1.6 times "
               "its length comes apart)",
               short_number(per_cell));
    return per_cell;
}

}  // namespace

Quat<double> unit_rotation(Quat<double> q)
{
    const double length = length_of(q);
    if (std::abs(length - 1) <= 8 * std::numeric_limits<double>::epsilon()) return q;
    return {q.w / length, q.x / length, q.y / length, q.z / length};
}

MaterialSpec normalised(MaterialSpec m)
{
    const MaterialSpec& preset = preset_of(m);
    const bool valid = !fault_of(m);
    m.name = preset.name;
    for (const MaterialQuantity& q : material_quantities()) {
        double& value = m.*q.value;
        if (!q.used(m))
            value = preset.*q.value;
        else if (valid)
            value = std::clamp(value, q.low, q.high);
    }
    return m;
}

MaterialSpec read_material(ObjectReader& r, const std::string& key)
{
    const Json* given = r.find(key);
    if (!given) return material_spec("clay");
    if (given->is_string()) return named_material(r, key, *given);
    MaterialSpec m;
    r.object(key, [&](ObjectReader& in) {
        const Json* name = in.find("preset");
        m = name ? named_material(in, "preset", *name) : material_spec("clay");
        override_material(in, m);
        if (const auto fault = fault_of(m)) in.fail(fault->key, fault->expected, fault->found);
    });
    return m;
}

Json json_of(const MaterialSpec& m)
{
    const MaterialSpec& preset = preset_of(m);
    Json all = {{"preset", preset.name}};
    if (m.elasticity != preset.elasticity) all["elasticity"] = name_of(elasticities, m.elasticity);
    if (m.plasticity != preset.plasticity) all["plasticity"] = name_of(plasticities, m.plasticity);
    for (const MaterialQuantity& q : material_quantities())
        if (!same_number(m.*q.value, preset.*q.value)) all[q.key] = m.*q.value;
    return all;
}

Object read_object(ObjectReader& r, const std::string& default_name, const std::string& folder)
{
    Object o;
    o.name = r.text("name", default_name);
    o.shape = r.choice("shape", shape_kinds, ShapeKind::sphere);
    o.centre = r.vector("centre", {-1000, 1000, "m"});
    if (o.shape == ShapeKind::splats)
        read_splats_options(r, o.splats, folder);
    else if (o.shape == ShapeKind::mesh)
        read_mesh_options(r, o.mesh, folder);
    else
        read_shape(r, o);
    o.rotation = read_rotation(r, "rotation");
    o.velocity = r.vector("velocity", {-1000, 1000, "m/s"}, {0, 0, 0});
    o.stated = read_material(r, "material");
    o.material = made(o.stated);
    o.category = r.whole("category", 0, 255, 0);
    o.material.category = o.category;
    o.per_cell = read_per_cell(r);
    return o;
}

Json json_of(const Object& o, const std::string& path)
{
    const auto triple = [](Vec3<double> v) { return Json{v.x, v.y, v.z}; };
    Json all = {{"name", o.name},
                {"shape", name_of(shape_kinds, o.shape)},
                {"centre", triple(o.centre)},
                {"velocity", triple(o.velocity)},
                {"material", json_of(o.stated)},
                {"category", o.category},
                {"per_cell", o.per_cell}};
    const Quat<double>& q = o.rotation;
    const bool turned = !same_number(q.w, 1) || !same_number(q.x, 0) || !same_number(q.y, 0) ||
                        !same_number(q.z, 0);
    if (turned) all["rotation"] = {q.w, q.x, q.y, q.z};
    if (o.shape == ShapeKind::splats)
        write_splats_options(o.splats, path, all);
    else if (o.shape == ShapeKind::mesh)
        write_mesh_options(o.mesh, path, all);
    else
        write_shape(o, all);
    return all;
}

}  // namespace knead
