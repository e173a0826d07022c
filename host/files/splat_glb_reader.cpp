// Splats from binary glTF, KHR_gaussian_splatting: the points of the default scene, with the
// transforms of their nodes.  [Khronos 2026]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/glb.h"
#include "host/files/gltf_guard.h"
#include "host/files/splat_axes.h"
#include "host/files/splat_gather.h"

namespace knead {
namespace {

constexpr const char* splatting = "KHR_gaussian_splatting";
// Earlier drafts, directly on the primitive, of which the data are SPZ.
constexpr const char* spz_drafts[] = {"KHR_spz_gaussian_splats_compression",
                                      "KHR_gaussian_splatting_compression_spz"};
constexpr const char* allowed_required[] = {splatting, "KHR_mesh_quantization"};
constexpr std::size_t json_at = 20, max_depth = 256, max_nodes = 1 << 16;
// Memory of what is read, as a multiple of the file's size: instances of one mesh are splats each.
constexpr std::size_t most_expansion = 64;

// Whether a primitive has splats, possibly in a form that is refused.
bool is_splats(const Json& primitive)
{
    const auto at = primitive.find("extensions");
    if (at == primitive.end() || !at->is_object()) return false;
    return at->contains(splatting) || at->contains(spz_drafts[0]) || at->contains(spz_drafts[1]);
}

// The numbers of an accessor, inside the file.
struct Numbers {
    std::size_t first = 0;  // offset in the file
    std::size_t count = 0, stride = 0;
    int component = gltf_float;
    bool normalised = false;

    double at(const ByteWindow& file, std::size_t row, std::size_t column) const
    {
        const auto as = [&](auto stored, double most) {
            stored = file.at<decltype(stored)>(first + row * stride + column * sizeof stored);
            return normalised ? std::max(double(stored) / most, -1.0) : double(stored);
        };
        switch (component) {
            case 5120:
                return as(std::int8_t{}, 127);
            case 5121:
                return as(std::uint8_t{}, 255);
            case 5122:
                return as(std::int16_t{}, 32767);
            case 5123:
                return as(std::uint16_t{}, 65535);
            default:
                return file.at<float>(first + row * stride + column * sizeof(float));
        }
    }
    Vec3<double> vector(const ByteWindow& file, std::size_t row) const
    {
        return {at(file, row, 0), at(file, row, 1), at(file, row, 2)};
    }
};

// Attributes of one primitive.
struct SplatPart {
    Numbers centre, rotation, scale, opacity;
    std::vector<Numbers> sh;  // one a coefficient
    int degree = 0;
    bool logs = false;  // a dialect: half axes as logarithms
};

struct Affine {
    Mat3<double> m = diagonal(1.0);
    Vec3<double> shift{0, 0, 0};
};
Affine operator*(const Affine& a, const Affine& b) { return {a.m * b.m, a.m * b.shift + a.shift}; }

class SplatGlbReader {
  public:
    SplatGlbReader(const ByteWindow& all, const std::string& file) : bytes(all), path(file)
    {
        const auto head = [&](std::size_t size) {
            return std::string(bytes.pointer(0, size), size);
        };
        const std::size_t first = std::min(bytes.size(), json_at);
        const std::size_t json_size = glb_json_size(head(first), bytes.size(), path);
        document = parse_json(std::string(bytes.pointer(json_at, json_size), json_size), path);
        if (!document.is_object()) refuse_gltf(path, "/", "an object", described(document));
        const std::size_t chunk = json_at + json_size;
        if (chunk == bytes.size()) return;
        const std::string header(
            bytes.pointer(chunk, std::min<std::size_t>(8, bytes.size() - chunk)),
            std::min<std::size_t>(8, bytes.size() - chunk));
        binary_size = glb_binary_size(header, chunk, bytes.size(), path);
        binary = chunk + 8;
    }

    SplatFile read()
    {
        check_required();
        walk_scene();
        if (placed_parts.empty())
            refuse_gltf(path, "/meshes",
                        fmt::format("points with {} in the default scene", splatting), "none");
        int degree = 0;
        for (const auto& [part, where] : placed_parts) degree = std::max(degree, part.degree);
        check_count(degree);
        SplatGather gather("glb", degree);
        gather.reserve(count);
        for (const auto& [part, where] : placed_parts) add(part, where, gather);
        SplatFile file = gather.gathered(path);
        file.notes = notes;
        if (skipped > 0)
            file.notes.push_back(
                fmt::format("{} primitives that are no splats are left out", skipped));
        return file;
    }

  private:
    const Json& item(const char* section, std::size_t index, const std::string& from) const
    {
        const auto at = document.find(section);
        const std::size_t size = at != document.end() && at->is_array() ? at->size() : 0;
        if (index >= size)
            refuse_gltf(path, from, fmt::format("one of {} {}", size, section),
                        std::to_string(index));
        const Json& one = (*at)[index];
        if (!one.is_object())
            refuse_gltf(path, fmt::format("/{}/{}", section, index), "an object", described(one));
        return one;
    }

    // A whole number below 2^32.
    std::size_t whole(const Json& of, const char* key, const std::string& where,
                      std::optional<std::size_t> otherwise = {}) const
    {
        const auto at = of.find(key);
        if (at == of.end() && otherwise) return *otherwise;
        if (at == of.end() || !at->is_number_unsigned() || at->get<std::uint64_t>() > 0xffffffffu)
            refuse_gltf(path, where + "/" + key, "a whole number below 2^32",
                        at == of.end() ? "nothing" : described(*at));
        return at->get<std::size_t>();
    }

    void check_required() const
    {
        const auto at = document.find("extensionsRequired");
        if (at == document.end()) return;
        for (const Json& name : *at) {
            const bool known = name.is_string() &&
                               std::any_of(std::begin(allowed_required), std::end(allowed_required),
                                           [&](const char* one) { return name == one; });
            if (known) continue;
            if (name.is_string() && name.get<std::string>().find("spz") != std::string::npos)
                refuse_spz("/extensionsRequired", name.get<std::string>());
            refuse_gltf(path, "/extensionsRequired", "extensions that are read", described(name));
        }
    }

    [[noreturn]] void refuse_spz(const std::string& where, const std::string& name) const
    {
        refuse_gltf(path, where, "splats as plain accessors",
                    "splats compressed as SPZ (" + name +
                        "); unpack them with the program that "
                        "wrote the file, or ask it for .spz");
    }

    void walk_scene()
    {
        const auto scenes = document.find("scenes");
        if (scenes == document.end() || !scenes->is_array() || scenes->empty()) {
            // Without scenes, all nodes that are no one's children.
            for (const std::size_t root : roots()) walk(root, Affine(), "/nodes", 0);
            return;
        }
        const std::size_t chosen = whole(document, "scene", "", 0);
        const std::string where = fmt::format("/scenes/{}", chosen);
        for (const std::size_t node : indices(item("scenes", chosen, "/scene"), "nodes", where))
            walk(node, Affine(), where + "/nodes", 0);
    }

    std::vector<std::size_t> indices(const Json& of, const char* key,
                                     const std::string& where) const
    {
        std::vector<std::size_t> all;
        const auto at = of.find(key);
        if (at == of.end()) return all;
        if (!at->is_array()) refuse_gltf(path, where + "/" + key, "an array", described(*at));
        for (const Json& one : *at) {
            if (!one.is_number_unsigned())
                refuse_gltf(path, where + "/" + key, "whole numbers", described(one));
            all.push_back(one.get<std::size_t>());
        }
        return all;
    }

    std::vector<std::size_t> roots() const
    {
        const auto nodes = document.find("nodes");
        if (nodes == document.end() || !nodes->is_array()) return {};
        std::vector<char> child(nodes->size());
        for (std::size_t i = 0; i < nodes->size(); ++i)
            for (const std::size_t k :
                 indices(item("nodes", i, "/nodes"), "children", fmt::format("/nodes/{}", i)))
                if (k < child.size()) child[k] = 1;
        std::vector<std::size_t> all;
        for (std::size_t i = 0; i < child.size(); ++i)
            if (!child[i]) all.push_back(i);
        return all;
    }

    void walk(std::size_t index, const Affine& parent, const std::string& from, std::size_t depth)
    {
        if (depth > max_depth || ++walked > max_nodes)
            refuse_gltf(
                path, from,
                fmt::format("a tree of at most {} nodes and {} levels", max_nodes, max_depth),
                "more, or a cycle");
        const Json& node = item("nodes", index, from);
        const std::string where = fmt::format("/nodes/{}", index);
        const Affine own = parent * transform(node, where);
        if (node.contains("mesh")) add_mesh(whole(node, "mesh", where), own, where);
        for (const std::size_t child : indices(node, "children", where))
            walk(child, own, where + "/children", depth + 1);
    }

    template <std::size_t n>
    std::array<double, n> numbers(const Json& node, const char* key, const std::string& where,
                                  std::array<double, n> otherwise) const
    {
        const auto at = node.find(key);
        if (at == node.end()) return otherwise;
        if (!at->is_array() || at->size() != n)
            refuse_gltf(path, where + "/" + key, fmt::format("{} numbers", n), described(*at));
        for (std::size_t k = 0; k < n; ++k) {
            if (!(*at)[k].is_number())
                refuse_gltf(path, fmt::format("{}/{}/{}", where, key, k), "a number",
                            described((*at)[k]));
            otherwise[k] = (*at)[k].template get<double>();
        }
        return otherwise;
    }

    Affine transform(const Json& node, const std::string& where) const
    {
        if (node.contains("matrix")) {
            const auto m = numbers<16>(node, "matrix", where, {});
            return {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}},
                    {m[12], m[13], m[14]}};
        }
        const auto t = numbers<3>(node, "translation", where, {0, 0, 0}),
                   s = numbers<3>(node, "scale", where, {1, 1, 1});
        const auto q = numbers<4>(node, "rotation", where, {0, 0, 0, 1});  // x, y, z, w
        const Mat3<double> Q = rotation(unit(Quat<double>{q[3], q[0], q[1], q[2]}));
        return {{s[0] * Q.a, s[1] * Q.b, s[2] * Q.c}, {t[0], t[1], t[2]}};
    }

    void add_mesh(std::size_t index, const Affine& at, const std::string& from)
    {
        const Json& mesh = item("meshes", index, from + "/mesh");
        const std::string where = fmt::format("/meshes/{}/primitives", index);
        const auto primitives = mesh.find("primitives");
        if (primitives == mesh.end() || !primitives->is_array())
            refuse_gltf(path, where, "an array", "something else");
        for (std::size_t p = 0; p < primitives->size(); ++p) {
            const Json& primitive = (*primitives)[p];
            const std::string here = fmt::format("{}/{}", where, p);
            if (!primitive.is_object()) refuse_gltf(path, here, "an object", described(primitive));
            if (!is_splats(primitive)) {
                ++skipped;
                continue;
            }
            if (placed_parts.size() >= max_nodes)
                refuse_gltf(path, here, fmt::format("at most {} primitives", max_nodes), "more");
            const double volume = determinant(at.m);
            if (!std::isfinite(volume) || volume == 0)
                refuse_gltf(path, from, "a transform with an inverse",
                            fmt::format("one of determinant {}", volume));
            placed_parts.emplace_back(part(primitive, here), at);
            count += placed_parts.back().first.centre.count;
            check_count(placed_parts.back().first.degree);
        }
    }

    void check_count(int degree) const
    {
        const std::size_t each = sizeof(float) * (11 + 3 * std::size_t(harmonics(degree)));
        if (count > most_expansion * bytes.size() / each)
            refuse_gltf(path, "/nodes",
                        fmt::format("splats of at most {} times the file's size", most_expansion),
                        fmt::format("at least {} splats", count));
    }

    // Checks the extension's object, and notes what cannot be kept.
    void check_extension(const Json& primitive, const std::string& where)
    {
        for (const char* draft : spz_drafts)
            if (primitive["extensions"].contains(draft)) refuse_spz(where, draft);
        const Json& own = primitive["extensions"][splatting];
        const std::string here = where + "/extensions/" + splatting;
        if (!own.is_object()) refuse_gltf(path, here, "an object", described(own));
        if (own.contains("extensions") && own["extensions"].is_object())
            for (const auto& [name, value] : own["extensions"].items()) {
                if (name.find("spz") != std::string::npos) refuse_spz(here, name);
                refuse_gltf(path, here + "/extensions", "plain splats", "\"" + name + "\"");
            }
        if (own.value("kernel", Json("ellipse")) != "ellipse")
            refuse_gltf(path, here + "/kernel", "\"ellipse\"", described(own["kernel"]));
        if (own.value("colorSpace", Json("srgb_rec709_display")) != "srgb_rec709_display")
            note("its colours are linear; they are shown as if they were sRGB");
    }

    void note(const std::string& text)
    {
        if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
    }

    SplatPart part(const Json& primitive, const std::string& where)
    {
        check_extension(primitive, where);
        const std::size_t mode = whole(primitive, "mode", where, 4);
        if (mode != 0) refuse_gltf(path, where + "/mode", "points (0)", std::to_string(mode));
        const auto attributes = primitive.find("attributes");
        if (attributes == primitive.end() || !attributes->is_object())
            refuse_gltf(path, where + "/attributes", "an object", "something else");
        const std::string prefix = std::string(splatting) + ":";
        const auto named = [&](const std::string& name, const char* type, std::size_t columns,
                               bool floats = false) {
            const std::string here = where + "/attributes/" + name;
            const auto at = attributes->find(name);
            if (at == attributes->end() || !at->is_number_unsigned())
                refuse_gltf(path, here, "an accessor",
                            at == attributes->end() ? "none" : described(*at));
            return accessor(at->get<std::size_t>(), type, columns, floats, here);
        };
        SplatPart all;
        all.centre = named("POSITION", "VEC3", 3);
        all.rotation = named(prefix + "ROTATION", "VEC4", 4);
        all.scale = named(prefix + "SCALE", "VEC3", 3);
        all.opacity = named(prefix + "OPACITY", "SCALAR", 1);
        const auto sh_name = [&](int l, int n) {
            return fmt::format("{}SH_DEGREE_{}_COEF_{}", prefix, l, n);
        };
        while (all.degree < 4 && attributes->contains(sh_name(all.degree + 1, 0))) ++all.degree;
        if (all.degree > max_sh_degree) {
            note("harmonics above degree 3 are left out");
            all.degree = max_sh_degree;
        }
        for (int l = 0; l <= all.degree; ++l)
            for (int n = 0; n <= 2 * l; ++n)
                all.sh.push_back(named(sh_name(l, n), "VEC3", 3, true));
        std::vector<const Numbers*> others{&all.rotation, &all.scale, &all.opacity};
        for (const Numbers& one : all.sh) others.push_back(&one);
        for (const Numbers* one : others)
            if (one->count != all.centre.count)
                refuse_gltf(path, where + "/attributes",
                            fmt::format("{} elements each", all.centre.count),
                            std::to_string(one->count));
        for (std::size_t i = 0; i < all.scale.count && !all.logs; ++i) {
            const Vec3<double> s = all.scale.vector(bytes, i);
            all.logs = s.x < 0 || s.y < 0 || s.z < 0;
        }
        if (all.logs) {
            const Json asset = document.value("asset", Json());
            const Json generator = asset.is_object() ? asset.value("generator", Json()) : Json();
            note(fmt::format(
                "its half axes are negative in part: they are read as logarithms, as "
                "some programs wrote them (this file: {})",
                generator.is_string() ? generator.get<std::string>().substr(0, 60) : "unnamed"));
        }
        return all;
    }

    Numbers accessor(std::size_t index, const char* type, std::size_t columns, bool floats,
                     const std::string& from) const
    {
        const Json& a = item("accessors", index, from);
        const std::string where = fmt::format("/accessors/{}", index);
        if (a.value("type", Json()) != type)
            refuse_gltf(path, where + "/type", fmt::format("\"{}\" for {}", type, from),
                        described(a.value("type", Json())));
        if (a.contains("sparse")) refuse_gltf(path, where, "a plain accessor", "a sparse one");
        if (!a.contains("bufferView"))
            refuse_gltf(path, where, "numbers in the file", "an accessor without a view");
        Numbers n;
        const std::size_t component = whole(a, "componentType", where);
        n.normalised = a.value("normalized", Json(false)) == true;
        const std::size_t size = component == 5120 || component == 5121   ? 1
                                 : component == 5122 || component == 5123 ? 2
                                 : component == gltf_float                ? 4
                                                                          : 0;
        if (size == 0 || (floats && component != gltf_float))
            refuse_gltf(path, where + "/componentType",
                        floats ? "floats (5126)" : "floats, bytes or shorts",
                        std::to_string(component));
        n.component = int(component);
        n.count = whole(a, "count", where);
        const std::size_t view_index = whole(a, "bufferView", where);
        const Json& view = item("bufferViews", view_index, where + "/bufferView");
        const std::string there = fmt::format("/bufferViews/{}", view_index);
        if (view.contains("extensions"))
            refuse_gltf(path, there + "/extensions", "a plain view", described(view["extensions"]));
        if (whole(view, "buffer", there) != 0 || binary == 0)
            refuse_gltf(path, there + "/buffer", "the buffer inside the file", "another");
        const std::size_t from_byte = whole(view, "byteOffset", there, 0),
                          length = whole(view, "byteLength", there),
                          offset = whole(a, "byteOffset", where, 0), width = columns * size;
        n.stride = whole(view, "byteStride", there, width);
        if (n.stride < width)
            refuse_gltf(path, there + "/byteStride", fmt::format("at least {}", width),
                        std::to_string(n.stride));
        // All numbers are below 2^32: no overflow.
        const std::size_t end = offset + (n.count > 0 ? (n.count - 1) * n.stride + width : 0);
        if (from_byte + length > binary_size)
            refuse_gltf(path, there, fmt::format("the {} bytes of the buffer at most", binary_size),
                        fmt::format("an end at {}", from_byte + length));
        if (end > length)
            refuse_gltf(path, where, fmt::format("the {} bytes of its view at most", length),
                        fmt::format("{} elements that end at {}", n.count, end));
        n.first = binary + from_byte + offset;
        return n;
    }

    void add(const SplatPart& part, const Affine& at, SplatGather& gather) const
    {
        // glTF axes: right, up, back.
        const Affine turned = Affine{{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, {0, 0, 0}} * at;
        const SplatTransform transform(turned.m, turned.shift);
        // A window for each attribute: all are read from the first row to the last.
        const ByteWindow centres(bytes), rotations(bytes), scales(bytes), opacities(bytes);
        const std::vector<ByteWindow> coefficients(part.sh.size(), bytes);
        for (std::size_t i = 0; i < part.centre.count; ++i) {
            Vec3<double> s = part.scale.vector(scales, i);
            if (part.logs) s = {std::exp(s.x), std::exp(s.y), std::exp(s.z)};
            const auto turn = [&](std::size_t k) { return part.rotation.at(rotations, i, k); };
            const Quat<double> q{turn(3), turn(0), turn(1), turn(2)};
            RawSplat raw{transform.place(part.centre.vector(centres, i)), s, q,
                         part.opacity.at(opacities, i, 0)};
            if (const double square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
                std::isfinite(square) && square > 0 && std::isfinite(s.x + s.y + s.z)) {
                const Ellipsoid<double> e = transform.apply({unit(q), s});
                raw.scale = e.scale, raw.rotation = e.q;
            }
            const auto stored = [&](int k) {
                return k < harmonics(part.degree)
                           ? part.sh[std::size_t(k)].vector(coefficients[std::size_t(k)], i)
                           : Vec3<double>{0, 0, 0};
            };
            gather.add(raw, [&](int k) { return transform.coefficient(k, stored); });
        }
    }

    const ByteWindow bytes;
    const std::string& path;
    Json document;
    std::size_t binary = 0;  // offset of the buffer; 0: none
    std::size_t binary_size = 0, walked = 0, skipped = 0, count = 0;
    std::vector<std::pair<SplatPart, Affine>> placed_parts;
    std::vector<std::string> notes;
};

}  // namespace

bool begins_splat_glb(const std::string& start)
{
    if (start.size() < json_at || !start.starts_with("glTF")) return false;
    std::uint32_t size;
    std::memcpy(&size, start.data() + 12, sizeof size);
    if (size > start.size() - json_at) return false;
    const Json document = Json::parse(
        start.begin() + json_at, start.begin() + std::ptrdiff_t(json_at + size), nullptr, false);
    if (!document.is_object()) return false;
    const auto meshes = document.find("meshes");
    if (meshes == document.end() || !meshes->is_array()) return false;
    for (const Json& mesh : *meshes) {
        if (!mesh.is_object() || !mesh.contains("primitives")) continue;
        for (const Json& primitive : mesh["primitives"])
            if (primitive.is_object() && is_splats(primitive)) return true;
    }
    return false;
}

SplatFile parse_splat_glb(const std::string& bytes, const std::string& path)
{
    return parse_splat_glb(ByteWindow(bytes), path);
}

SplatFile parse_splat_glb(const ByteWindow& bytes, const std::string& path)
{
    return SplatGlbReader(bytes, path).read();
}

}  // namespace knead
