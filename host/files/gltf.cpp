#include "host/files/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "cuda/math/rotation.h"
#include "host/base/json_reader.h"
#include "host/files/gltf_guard.h"
#include "host/files/image.h"
#include "host/files/mesh_reader.h"

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace knead {
namespace {

tinygltf::Model load(const std::string& bytes, const std::string& path)
{
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string said, warned;
    bool read = false;
    try {
        read = reader.LoadBinaryFromMemory(&model, &said, &warned,
                                           reinterpret_cast<const unsigned char*>(bytes.data()),
                                           unsigned(bytes.size()));
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        said = e.what();
    }
    // tinygltf reports some faults but succeeds: rejected, too.
    if (read && said.empty()) return model;
    std::replace(said.begin(), said.end(), '\n', ' ');
    while (!said.empty() && said.back() == ' ') said.pop_back();
    refuse_gltf(path, "/", "glTF 2.0", said.empty() ? "another format" : said.substr(0, 300));
}

std::size_t size_of(int component)
{
    return std::size_t(tinygltf::GetComponentSizeInBytes(std::uint32_t(component)));
}

// Memory layout of the elements of an accessor.
struct Rows {
    const unsigned char* first;
    std::size_t count, stride;
    int component;  // component type
    bool normalised = false;

    // `first` may be null: zeros.
    double number(std::size_t row, int column) const
    {
        if (!first) return 0;
        const unsigned char* at = first + row * stride + std::size_t(column) * size_of(component);
        const auto as = [&](auto stored) {
            std::memcpy(&stored, at, sizeof stored);
            using T = decltype(stored);
            if (!normalised) return double(stored);
            return std::max(double(stored) / double(std::numeric_limits<T>::max()), -1.0);
        };
        switch (component) {
            case TINYGLTF_COMPONENT_TYPE_BYTE:
                return as(std::int8_t{});
            case TINYGLTF_COMPONENT_TYPE_SHORT:
                return as(std::int16_t{});
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                return as(std::uint8_t{});
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                return as(std::uint16_t{});
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                return as(std::uint32_t{});
            default: {
                float stored;
                std::memcpy(&stored, at, sizeof stored);
                return stored;
            }
        }
    }
};

// The elements of an accessor, some of which may be replaced: sparse ones.
struct Elements {
    Rows rows, replaced_by;
    std::vector<std::size_t> replaced;  // ascending

    // Calls visit(element, rows, row) in order.
    template <class Visit>
    void each(Visit&& visit) const
    {
        for (std::size_t i = 0, k = 0; i < rows.count; ++i)
            if (k < replaced.size() && replaced[k] == i)
                visit(i, replaced_by, k++);
            else
                visit(i, rows, i);
    }
};

// Affine: columns of the matrix, and what is added.
struct Placement {
    Vec3<double> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, by{};

    Vec3<double> turned(Vec3<double> v) const { return v.x * x + v.y * y + v.z * z; }
    Vec3<double> operator()(Vec3<double> v) const { return turned(v) + by; }
    bool mirrors() const { return dot(x, cross(y, z)) < 0; }
};
Placement operator*(const Placement& a, const Placement& b)
{
    return {a.turned(b.x), a.turned(b.y), a.turned(b.z), a(b.by)};
}
// Translation, rotation (x, y, z, w) and scale.
Placement placement(Vec3<double> by, const std::array<double, 4>& q, Vec3<double> scale)
{
    const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double s = size > 0 ? 1 / size : 0;
    const Quat<double> turn =
        size > 0 ? Quat<double>{s * q[3], s * q[0], s * q[1], s * q[2]} : Quat<double>{1, 0, 0, 0};
    return {scale.x * rotate(turn, Vec3<double>{1, 0, 0}),
            scale.y * rotate(turn, Vec3<double>{0, 1, 0}),
            scale.z * rotate(turn, Vec3<double>{0, 0, 1}), by};
}

constexpr std::size_t most_places = 1 << 16;  // of primitives
constexpr std::size_t most_nodes_seen = 1 << 20;
constexpr int deepest_node = 256;

// Allowed storage types of an attribute, and their description for errors.
struct Form {
    int type;
    std::vector<int> components;
    const char* said;
};
const Form stored_positions{TINYGLTF_TYPE_VEC3, {TINYGLTF_COMPONENT_TYPE_FLOAT}, "VEC3 of floats"};
// With those of KHR_mesh_quantization.
const Form positions{TINYGLTF_TYPE_VEC3,
                     {TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_COMPONENT_TYPE_BYTE,
                      TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_SHORT,
                      TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},
                     "VEC3 of floats, bytes or shorts"};
const std::vector<int> colour_components{TINYGLTF_COMPONENT_TYPE_FLOAT,
                                         TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE,
                                         TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT};
const Form colours{TINYGLTF_TYPE_VEC3, colour_components,
                   "VEC3 or VEC4 of floats, unsigned bytes or shorts"};
const Form colours_with_alpha{TINYGLTF_TYPE_VEC4, colour_components, colours.said};
const Form rotations{
    TINYGLTF_TYPE_VEC4,
    {TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_COMPONENT_TYPE_BYTE, TINYGLTF_COMPONENT_TYPE_SHORT},
    "VEC4 of floats, bytes or shorts"};
const Form texture_places{TINYGLTF_TYPE_VEC2, colour_components,
                          "VEC2 of floats, unsigned bytes or shorts"};
const Form sparse_indices{
    TINYGLTF_TYPE_SCALAR,
    {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
     TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT},
    "unsigned bytes, shorts or ints"};
const Form triangles{TINYGLTF_TYPE_SCALAR,
                     {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                      TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT},
                     "SCALAR of unsigned bytes, shorts or ints"};
const Form joints{TINYGLTF_TYPE_VEC4,
                  {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},
                  "VEC4 of unsigned bytes or shorts"};
const Form weights{TINYGLTF_TYPE_VEC4,
                   {TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE,
                    TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},
                   "VEC4 of floats, unsigned bytes or shorts"};
const Form matrices{TINYGLTF_TYPE_MAT4, {TINYGLTF_COMPONENT_TYPE_FLOAT}, "MAT4 of floats"};

class Reader {
  public:
    Reader(const std::string& bytes, const std::string& file, GltfSkins skins)
        : path(file), most(64 * bytes.size())
    {
        GuardedGlb guarded = guarded_glb(bytes, file, skins);
        model = load(guarded.bytes, file);
        document = std::move(guarded.document);
    }

    Gltf read(GltfSkins skins)
    {
        Gltf all;
        stored = skins == GltfSkins::read;
        if (stored || model.nodes.empty())
            for (std::size_t m = 0; m < model.meshes.size(); ++m) places.push_back({m, {}});
        else
            walk();
        check_work(skins);
        for (const auto& [m, placed] : places)
            for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
                const std::string where = fmt::format("/meshes/{}/primitives/{}", m, p);
                const tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
                if (!stored && primitive.mode >= TINYGLTF_MODE_POINTS &&
                    primitive.mode < TINYGLTF_MODE_TRIANGLES) {
                    ++thin;
                    continue;
                }
                all.parts.push_back(part(primitive, where));
                all.parts.back().mesh = model.meshes[m].name;
                if (const tinygltf::Value& of = model.meshes[m].extras; of.Has("category"))
                    all.parts.back().category = of.Get("category").GetNumberAsInt();
                if (stored)
                    hang(all.parts.back(), primitive, where);
                else
                    place(all.parts.back(), placed),
                        paint(all.parts.back(), primitive, where, m, p);
            }
        if (thin)
            all.notes.push_back(fmt::format("{} primitives of points or lines left out", thin));
        if (textures_left_out)
            all.notes.push_back(fmt::format("{} textures left out: only PNG in the file is read",
                                            textures_left_out));
        if (sampled_at_vertices)
            all.notes.push_back("colours of textures are those at the vertices");
        for (std::size_t s = 0; s < model.skins.size(); ++s)
            all.skins.push_back(skin(model.skins[s], fmt::format("/skins/{}", s)));
        return all;
    }

  private:
    // Size of an accessor's numbers [bytes]; 0 if it is missing or longer than the buffer, which is
    // rejected when it is read.
    std::size_t bytes_of(int index) const
    {
        if (index < 0 || std::size_t(index) >= model.accessors.size()) return 0;
        const tinygltf::Accessor& a = model.accessors[std::size_t(index)];
        if (model.buffers.empty() || a.count > model.buffers[0].data.size()) return 0;
        const int columns = tinygltf::GetNumComponentsInType(std::uint32_t(a.type));
        return a.count * std::size_t(std::max(columns, 1)) * sizeof(double);
    }

    struct MeshPlace {
        std::size_t mesh;
        Placement placed;
    };

    void add_place(int mesh, const Placement& placed, const std::string& where)
    {
        if (std::size_t(mesh) >= model.meshes.size())
            refuse_gltf(path, where + "/mesh", fmt::format("one of {} meshes", model.meshes.size()),
                        std::to_string(mesh));
        placed_parts += std::max<std::size_t>(model.meshes[std::size_t(mesh)].primitives.size(), 1);
        if (placed_parts > most_places)
            refuse_gltf(path, "/nodes", fmt::format("at most {} primitives in all", most_places),
                        "more");
        places.push_back({std::size_t(mesh), placed});
    }

    // The places of meshes in the default scene: that which the file names, else the first, else
    // all nodes that are no child.
    void walk()
    {
        std::vector<int> roots;
        if (!model.scenes.empty()) {
            const int scene = std::max(model.defaultScene, 0);
            if (std::size_t(scene) >= model.scenes.size())
                refuse_gltf(path, "/scene", fmt::format("one of {} scenes", model.scenes.size()),
                            std::to_string(scene));
            roots = model.scenes[std::size_t(scene)].nodes;
        } else {
            std::vector<char> child(model.nodes.size());
            for (const tinygltf::Node& n : model.nodes)
                for (const int c : n.children)
                    if (std::size_t(c) < child.size()) child[std::size_t(c)] = 1;
            for (std::size_t i = 0; i < child.size(); ++i)
                if (!child[i]) roots.push_back(int(i));
        }
        for (const int root : roots) walk(root, {}, 0);
    }

    void walk(int index, const Placement& above, int depth)
    {
        const std::string where = fmt::format("/nodes/{}", index);
        if (std::size_t(index) >= model.nodes.size())
            refuse_gltf(path, where, fmt::format("one of {} nodes", model.nodes.size()),
                        std::to_string(index));
        if (depth > deepest_node || ++nodes_seen > most_nodes_seen)
            refuse_gltf(path, where,
                        fmt::format("a tree of nodes of at most {} levels", deepest_node),
                        "more, or a circle");
        const tinygltf::Node& n = model.nodes[std::size_t(index)];
        const Placement here = above * local(n, where);
        if (n.mesh >= 0) {
            if (const Json* rows = instances(index))
                add_instances(*rows, n.mesh, here, where);
            else
                add_place(n.mesh, n.skin >= 0 ? Placement{} : here, where);
        }
        for (const int c : n.children) walk(c, here, depth + 1);
    }

    Placement local(const tinygltf::Node& n, const std::string& where) const
    {
        const auto check = [&](const std::vector<double>& v, const char* name, std::size_t count) {
            const bool finite = std::ranges::all_of(v, [](double x) { return std::isfinite(x); });
            if (!v.empty() && (v.size() != count || !finite))
                refuse_gltf(path, fmt::format("{}/{}", where, name),
                            fmt::format("{} finite numbers", count), std::to_string(v.size()));
        };
        check(n.matrix, "matrix", 16), check(n.translation, "translation", 3);
        check(n.rotation, "rotation", 4), check(n.scale, "scale", 3);
        if (const auto& m = n.matrix; !m.empty())
            return {
                {m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
        const auto three = [](const std::vector<double>& v, double otherwise) {
            return v.empty() ? Vec3<double>{otherwise, otherwise, otherwise}
                             : Vec3<double>{v[0], v[1], v[2]};
        };
        std::array<double, 4> q{0, 0, 0, 1};
        if (!n.rotation.empty()) std::ranges::copy(n.rotation, q.begin());
        return placement(three(n.translation, 0), q, three(n.scale, 1));
    }

    // Attributes of EXT_mesh_gpu_instancing; nullptr: none.
    const Json* instances(int node) const
    {
        const Json* at = &document["nodes"][std::size_t(node)];
        for (const char* key : {"extensions", "EXT_mesh_gpu_instancing", "attributes"}) {
            const auto found = at->find(key);
            if (found == at->end() || !found->is_object()) return nullptr;
            at = &*found;
        }
        return at;
    }

    static int index_in(const Json& object, const char* key)
    {
        const auto at = object.find(key);
        if (at == object.end() || !at->is_number_unsigned()) return -1;
        return int(std::min<std::uint64_t>(at->get<std::uint64_t>(), 0x7fffffff));
    }

    void add_instances(const Json& rows, int mesh, const Placement& here, const std::string& where)
    {
        std::vector<Vec3<double>> by, scale;
        std::vector<std::array<double, 4>> turn;
        const std::string at = where + "/extensions/EXT_mesh_gpu_instancing/attributes/";
        std::size_t count = 0;
        const auto counted = [&](const char* key, std::size_t found) {
            if (count > 0 && found != count)
                refuse_gltf(path, at + key, fmt::format("one for each of {} instances", count),
                            std::to_string(found));
            count = found;
        };
        const auto check_size = [&](int accessor) {  // before any is read
            if (accessor >= 0 && std::size_t(accessor) < model.accessors.size() &&
                model.accessors[std::size_t(accessor)].count > most_places)
                refuse_gltf(path, where, fmt::format("at most {} instances", most_places), "more");
        };
        if (const int i = index_in(rows, "TRANSLATION"); i >= 0) {
            check_size(i);
            counted("TRANSLATION",
                    each<3>(i, stored_positions, at + "TRANSLATION", [&](const auto& v) {
                        by.push_back({v[0], v[1], v[2]});
                    }));
        }
        if (const int i = index_in(rows, "ROTATION"); i >= 0) {
            check_size(i);
            counted("ROTATION", each<4>(i, rotations, at + "ROTATION",
                                        [&](const auto& v) { turn.push_back(v); }));
        }
        if (const int i = index_in(rows, "SCALE"); i >= 0) {
            check_size(i);
            counted("SCALE", each<3>(i, stored_positions, at + "SCALE", [&](const auto& v) {
                        scale.push_back({v[0], v[1], v[2]});
                    }));
        }
        for (std::size_t i = 0; i < count; ++i)
            add_place(mesh,
                      here * placement(by.empty() ? Vec3<double>{} : by[i],
                                       turn.empty() ? std::array<double, 4>{0, 0, 0, 1} : turn[i],
                                       scale.empty() ? Vec3<double>{1, 1, 1} : scale[i]),
                      where);
    }

    static void place(GltfPart& part, const Placement& placed)
    {
        for (Vec3<double>& v : part.vertices) v = placed(v);
        if (placed.mirrors())
            for (Int3& t : part.triangles) std::swap(t.y, t.z);
    }

    // A section's element; nullptr: there is none.
    const Json* element(const char* section, int index) const
    {
        const auto all = document.find(section);
        if (index < 0 || all == document.end() || !all->is_array() ||
            std::size_t(index) >= all->size() || !(*all)[std::size_t(index)].is_object())
            return nullptr;
        return &(*all)[std::size_t(index)];
    }
    static const Json* object_in(const Json* of, const char* key)
    {
        if (!of) return nullptr;
        const auto at = of->find(key);
        return at != of->end() && at->is_object() ? &*at : nullptr;
    }

    // The picture of a texture; nullptr: not a PNG in the file's buffer. Each is read once.
    const Image* picture(const Json* texture)
    {
        const int number = texture ? index_in(*texture, "source") : -1;
        const Json* image = element("images", number);
        if (!image) return nullptr;
        if (const auto known = pictures.find(number); known != pictures.end())
            return known->second ? &*known->second : nullptr;
        std::optional<Image>& made = pictures[number];
        const int view_index = index_in(*image, "bufferView");
        if (view_index < 0) return nullptr;
        const std::string where = fmt::format("/images/{}", number);
        const tinygltf::BufferView& view = view_of(view_index, where);
        const std::string bytes(
            reinterpret_cast<const char*>(model.buffers[0].data.data()) + view.byteOffset,
            view.byteLength);
        if (!bytes.starts_with("\x89PNG")) return nullptr;
        made = decoded_png(bytes, path + ": " + where);
        pixels += std::size_t(made->width) * std::size_t(made->height);
        if (pixels > max_picture_pixels)
            refuse_gltf(path, where,
                        fmt::format("at most {} pixels of all pictures", max_picture_pixels),
                        std::to_string(pixels));
        return made ? &*made : nullptr;
    }

    // Where a coordinate of a texture lies in it, 0 to 1.
    static double wrapped(double at, int mode)
    {
        constexpr int clamps = 33071, mirrors = 33648;
        if (mode == clamps) return std::clamp(at, 0.0, 1.0);
        if (mode == mirrors) {
            const double two = at - 2 * std::floor(at / 2);
            return two > 1 ? 2 - two : two;
        }
        return at - std::floor(at);
    }

    // The nearest pixel, linear; v points downwards.
    static Vec3<double> sampled(const Image& image, double u, double v)
    {
        const auto nearest = [](double at, int size) {
            return std::clamp(int(at * size), 0, size - 1);
        };
        const std::size_t at =
            3 * (std::size_t(nearest(v, image.height)) * std::size_t(image.width) +
                 std::size_t(nearest(u, image.width)));
        const Vec3<float> c = linear_colour(
            {image.rgb[at] / 255.0, image.rgb[at + 1] / 255.0, image.rgb[at + 2] / 255.0});
        return cast<double>(c);
    }

    // Colours of the vertices, of the material and of its texture at the vertices, multiplied:
    // linear.
    void paint(GltfPart& part, const tinygltf::Primitive& primitive, const std::string& where,
               std::size_t mesh, std::size_t number)
    {
        const Json& of = document["meshes"][mesh]["primitives"][number];
        const Json* pbr =
            object_in(element("materials", index_in(of, "material")), "pbrMetallicRoughness");
        std::vector<Vec3<double>> all;
        const auto multiply = [&](std::size_t i, Vec3<double> c) {
            if (all.empty()) all.assign(part.vertices.size(), {1, 1, 1});
            if (i < all.size()) all[i] = {all[i].x * c.x, all[i].y * c.y, all[i].z * c.z};
        };
        const auto check_count = [&](const std::string& what, std::size_t count) {
            if (count != part.vertices.size())
                refuse_gltf(path, what,
                            fmt::format("one for each of {} vertices", part.vertices.size()),
                            std::to_string(count));
        };
        if (const int vertex = attribute(primitive, "COLOR_0"); vertex >= 0) {
            const std::string what = where + "/attributes/COLOR_0";
            const bool four = std::size_t(vertex) < model.accessors.size() &&
                              model.accessors[std::size_t(vertex)].type == TINYGLTF_TYPE_VEC4;
            std::size_t i = 0;
            const auto take = [&](const auto& v) { multiply(i++, {v[0], v[1], v[2]}); };
            check_count(what, four ? each<4>(vertex, colours_with_alpha, what, take)
                                   : each<3>(vertex, colours, what, take));
        }
        if (pbr && pbr->contains("baseColorFactor")) {
            const Json& factor = (*pbr)["baseColorFactor"];
            const bool good =
                factor.is_array() && factor.size() == 4 &&
                std::ranges::all_of(factor, [](const Json& n) { return n.is_number(); });
            for (std::size_t i = 0; good && i < part.vertices.size(); ++i)
                multiply(
                    i, {factor[0].get<double>(), factor[1].get<double>(), factor[2].get<double>()});
        }
        if (const Json* texture = object_in(pbr, "baseColorTexture")) {
            const Json* named = element("textures", index_in(*texture, "index"));
            const std::string set =
                fmt::format("TEXCOORD_{}", std::max(index_in(*texture, "texCoord"), 0));
            const Image* image = picture(named);
            if (!image || attribute(primitive, set.c_str()) < 0) {
                ++textures_left_out;
            } else {
                const Json* sampler = element("samplers", index_in(*named, "sampler"));
                const int wrap_u = sampler ? index_in(*sampler, "wrapS") : -1,
                          wrap_v = sampler ? index_in(*sampler, "wrapT") : -1;
                const std::string what = where + "/attributes/" + set;
                std::size_t i = 0;
                check_count(what, each<2>(attribute(primitive, set.c_str()), texture_places, what,
                                          [&](const auto& uv) {
                                              multiply(i++, sampled(*image, wrapped(uv[0], wrap_u),
                                                                    wrapped(uv[1], wrap_v)));
                                          }));
                sampled_at_vertices = true;
            }
        }
        for (const Vec3<double> c : all)
            part.colours.push_back({float(std::clamp(c.x, 0.0, 1.0)),
                                    float(std::clamp(c.y, 0.0, 1.0)),
                                    float(std::clamp(c.z, 0.0, 1.0))});
    }

    // Checks the total size before any number is read. Repeated references to an accessor count
    // each time.
    void check_work(GltfSkins skins) const
    {
        std::size_t wanted = 0;
        for (const MeshPlace& at : places)
            for (const tinygltf::Primitive& p : model.meshes[at.mesh].primitives) {
                const int corner_list = p.indices >= 0 ? p.indices : attribute(p, "POSITION");
                wanted += bytes_of(attribute(p, "POSITION")) + bytes_of(corner_list);
                if (skins == GltfSkins::ignored)
                    wanted += 2 * bytes_of(attribute(p, "COLOR_0")) +
                              bytes_of(attribute(p, "TEXCOORD_0"));
                else
                    wanted +=
                        bytes_of(attribute(p, "JOINTS_0")) + bytes_of(attribute(p, "WEIGHTS_0"));
            }
        for (const tinygltf::Skin& s : model.skins) wanted += bytes_of(s.inverseBindMatrices);
        if (wanted > most)
            refuse_gltf(path, "/meshes",
                        fmt::format("at most {} bytes of numbers, 64 times the file", most),
                        std::to_string(wanted));
    }

    // Returns the layout of an accessor of one of the form's types; `what` names the referrer for
    // errors.
    Elements elements(int index, const Form& form, const std::string& what)
    {
        const std::string where = fmt::format("/accessors/{} (of {})", index, what);
        const auto& all = model.accessors;
        if (index < 0 || std::size_t(index) >= all.size())
            refuse_gltf(path, what, fmt::format("one of {} accessors", all.size()),
                        index < 0 ? "none" : std::to_string(index));
        const tinygltf::Accessor& a = all[std::size_t(index)];
        const auto& types = form.components;
        const auto columns = std::size_t(tinygltf::GetNumComponentsInType(std::uint32_t(a.type)));
        if (a.type != form.type ||
            std::find(types.begin(), types.end(), a.componentType) == types.end())
            refuse_gltf(path, where, form.said,
                        fmt::format("{} of type {}", columns, a.componentType));
        const std::size_t width = columns * size_of(a.componentType);
        Elements found{{nullptr, a.count, width, a.componentType, a.normalized}, {}, {}};
        if (a.bufferView >= 0 || !a.sparse.isSparse)
            found.rows = rows(a.bufferView, a.byteOffset, a.count, width, a.componentType, where);
        else if (model.buffers.empty() || a.count > model.buffers[0].data.size())
            refuse_gltf(path, where, "no more elements than the buffer has bytes",
                        std::to_string(a.count));
        found.rows.normalised = a.normalized;
        if (!a.sparse.isSparse) return found;
        const auto count = std::size_t(std::max(a.sparse.count, 0));
        const std::string sparse = where + "/sparse";
        const auto& of = a.sparse.indices;
        const auto& known = sparse_indices.components;
        if (std::find(known.begin(), known.end(), of.componentType) == known.end())
            refuse_gltf(path, sparse + "/indices", sparse_indices.said,
                        fmt::format("type {}", of.componentType));
        const Rows indices = rows(of.bufferView, std::size_t(std::max(of.byteOffset, 0)), count,
                                  size_of(of.componentType), of.componentType, sparse + "/indices");
        found.replaced_by =
            rows(a.sparse.values.bufferView, std::size_t(std::max(a.sparse.values.byteOffset, 0)),
                 count, width, a.componentType, sparse + "/values");
        found.replaced_by.normalised = a.normalized;
        for (std::size_t i = 0; i < count; ++i) {
            const auto one = std::size_t(indices.number(i, 0));
            if (one >= a.count || (i > 0 && one <= found.replaced.back()))
                refuse_gltf(path, fmt::format("{}/indices: element {}", sparse, i),
                            fmt::format("ascending numbers below {}", a.count),
                            std::to_string(one));
            found.replaced.push_back(one);
        }
        return found;
    }

    Rows rows(int view_index, std::size_t offset, std::size_t count, std::size_t width,
              int component, const std::string& where) const
    {
        const auto fail = [&](const std::string& expected, const std::string& found) {
            refuse_gltf(path, where, expected, found);
        };
        const tinygltf::BufferView& view = view_of(view_index, where);
        const std::size_t stride = view.byteStride ? view.byteStride : width;
        if (stride < width)
            fail(fmt::format("a stride of at least {}", width), std::to_string(stride));
        // All numbers are below 2^32 here: no overflow.
        const std::size_t end = offset + (count ? (count - 1) * stride + width : 0);
        if (end > view.byteLength)
            fail(fmt::format("the {} bytes of its view at most", view.byteLength),
                 fmt::format("{} elements that end at {}", count, end));
        return {model.buffers[0].data.data() + view.byteOffset + offset, count, stride, component};
    }

    // Returns the view of an accessor, checked to lie inside the buffer.
    const tinygltf::BufferView& view_of(int index, const std::string& where) const
    {
        if (index < 0 || std::size_t(index) >= model.bufferViews.size())
            refuse_gltf(path, where, fmt::format("one of {} views", model.bufferViews.size()),
                        index < 0 ? "none" : std::to_string(index));
        const tinygltf::BufferView& view = model.bufferViews[std::size_t(index)];
        const std::string there = fmt::format("/bufferViews/{}", index);
        if (view.buffer != 0 || model.buffers.empty())
            refuse_gltf(path, there, "the file's buffer", std::to_string(view.buffer));
        const std::size_t size = model.buffers[0].data.size();
        if (view.byteOffset + view.byteLength > size)
            refuse_gltf(path, there, fmt::format("the {} bytes of the buffer at most", size),
                        fmt::format("an end at {}", view.byteOffset + view.byteLength));
        return view;
    }

    // Calls take(N numbers) for each element.
    template <std::size_t N, class Take>
    std::size_t each(int index, const Form& form, const std::string& what, Take&& take)
    {
        const Elements all = elements(index, form, what);
        all.each([&](std::size_t i, const Rows& in, std::size_t row) {
            std::array<double, N> numbers;
            for (std::size_t k = 0; k < N; ++k) {
                numbers[k] = in.number(row, int(k));
                if (!std::isfinite(numbers[k]))
                    refuse_gltf(path,
                                fmt::format("/accessors/{} (of {}): element {}", index, what, i),
                                "finite numbers", std::to_string(numbers[k]));
            }
            take(numbers);
        });
        return all.rows.count;
    }

    int attribute(const tinygltf::Primitive& primitive, const char* name) const
    {
        const auto at = primitive.attributes.find(name);
        return at == primitive.attributes.end() ? -1 : at->second;
    }

    GltfPart part(const tinygltf::Primitive& primitive, const std::string& where)
    {
        GltfPart out;
        const int mode = primitive.mode;
        const bool strip = mode == TINYGLTF_MODE_TRIANGLE_STRIP,
                   fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
        if (mode != TINYGLTF_MODE_TRIANGLES && !strip && !fan)
            refuse_gltf(path, where + "/mode", "triangles (4)", std::to_string(mode));
        const std::size_t count =
            each<3>(attribute(primitive, "POSITION"), stored ? stored_positions : positions,
                    where + "/attributes/POSITION", [&](const std::array<double, 3>& v) {
                        out.vertices.push_back({v[0], v[1], v[2]});
                    });
        const std::string named = where + "/indices";
        std::vector<int> all;
        const auto add = [&](double v) {
            if (v >= double(count))
                refuse_gltf(path, fmt::format("{}: element {}", named, all.size()),
                            fmt::format("a vertex below {}", count), fmt::format("{}", v));
            all.push_back(int(v));
        };
        if (primitive.indices >= 0)
            each<1>(primitive.indices, triangles, named, [&](const auto& v) { add(v[0]); });
        else
            for (std::size_t i = 0; i < count; ++i) add(double(i));
        if (strip || fan) {
            for (std::size_t i = 0; i + 2 < all.size(); ++i) {
                const std::size_t odd = i % 2;
                out.triangles.push_back(strip ? Int3{all[i], all[i + 1 + odd], all[i + 2 - odd]}
                                              : Int3{all[i + 1], all[i + 2], all[0]});
            }
            return out;
        }
        if (all.size() % 3 != 0)
            refuse_gltf(path, where, "three corners a triangle", std::to_string(all.size()));
        for (std::size_t i = 0; i < all.size(); i += 3)
            out.triangles.push_back({all[i], all[i + 1], all[i + 2]});
        return out;
    }

    // Reads the joints and weights of a part, if present.
    void hang(GltfPart& to, const tinygltf::Primitive& primitive, const std::string& where)
    {
        if (attribute(primitive, "JOINTS_0") < 0 && attribute(primitive, "WEIGHTS_0") < 0) return;
        const std::string at[] = {where + "/attributes/JOINTS_0", where + "/attributes/WEIGHTS_0"};
        each<4>(attribute(primitive, "JOINTS_0"), joints, at[0], [&](const auto& v) {
            to.joints.push_back({int(v[0]), int(v[1]), int(v[2]), int(v[3])});
        });
        each<4>(attribute(primitive, "WEIGHTS_0"), weights, at[1],
                [&](const auto& v) { to.weights.push_back(v); });
        const std::size_t found[] = {to.joints.size(), to.weights.size()};
        for (int k = 0; k < 2; ++k)
            if (found[k] != to.vertices.size())
                refuse_gltf(path, at[k],
                            fmt::format("one for each of {} vertices", to.vertices.size()),
                            std::to_string(found[k]));
    }

    GltfSkin skin(const tinygltf::Skin& given, const std::string& where)
    {
        GltfSkin out;
        for (std::size_t i = 0; i < given.joints.size(); ++i) {
            const auto node = std::size_t(given.joints[i]);
            if (node >= model.nodes.size())
                refuse_gltf(path, fmt::format("{}/joints/{}", where, i),
                            fmt::format("one of {} nodes", model.nodes.size()),
                            std::to_string(node));
            out.joints.push_back(model.nodes[node].name);
        }
        const std::string matrix = where + "/inverseBindMatrices";
        each<16>(given.inverseBindMatrices, matrices, matrix,
                 [&](const auto& m) { out.inverse_bind.push_back(m); });
        if (out.inverse_bind.size() != out.joints.size())
            refuse_gltf(path, matrix, fmt::format("one for each of {} joints", out.joints.size()),
                        std::to_string(out.inverse_bind.size()));
        return out;
    }

    const std::string& path;
    tinygltf::Model model;
    Json document;
    const std::size_t most;  // limit for all numbers together [bytes]
    bool stored = false;     // not placed by nodes
    std::vector<MeshPlace> places;
    std::size_t placed_parts = 0, nodes_seen = 0, thin = 0;
    std::size_t textures_left_out = 0, pixels = 0;
    bool sampled_at_vertices = false;
    std::map<int, std::optional<Image>> pictures;
};

}  // namespace

Gltf parse_gltf(const std::string& bytes, const std::string& path, GltfSkins skins)
{
    return Reader(bytes, path, skins).read(skins);
}

Gltf read_gltf(const std::string& path, GltfSkins skins)
{
    return parse_gltf(read_text(path, max_file_bytes), path, skins);
}

}  // namespace knead
