#include "host/files/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "host/base/json_reader.h"
#include "host/files/gltf_guard.h"

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace knead {
namespace {

tinygltf::Model load(const std::string& whole, const std::string& path, GltfSkins skins)
{
    const std::string bytes = guarded_glb(whole, path, skins);
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

    double number(std::size_t row, int column) const
    {
        const unsigned char* at = first + row * stride + std::size_t(column) * size_of(component);
        const auto as = [&](auto stored) {
            std::memcpy(&stored, at, sizeof stored);
            return double(stored);
        };
        switch (component) {
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                return as(std::uint8_t{});
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                return as(std::uint16_t{});
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                return as(std::uint32_t{});
            default:
                return as(float{});
        }
    }
};

// Allowed storage types of an attribute, and their description for errors.
struct Form {
    int type;
    std::vector<int> components;
    const char* said;
};
const Form positions{TINYGLTF_TYPE_VEC3, {TINYGLTF_COMPONENT_TYPE_FLOAT}, "VEC3 of floats"};
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
        : path(file), model(load(bytes, file, skins)), most(64 * bytes.size())
    {
    }

    Gltf read(GltfSkins skins)
    {
        Gltf all;
        check_work(skins);
        for (std::size_t m = 0; m < model.meshes.size(); ++m)
            for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
                const std::string where = fmt::format("/meshes/{}/primitives/{}", m, p);
                const tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
                all.parts.push_back(part(primitive, where));
                all.parts.back().mesh = model.meshes[m].name;
                if (const tinygltf::Value& of = model.meshes[m].extras; of.Has("category"))
                    all.parts.back().category = of.Get("category").GetNumberAsInt();
                if (skins == GltfSkins::read) hang(all.parts.back(), primitive, where);
            }
        for (std::size_t s = 0; s < model.skins.size(); ++s)
            all.skins.push_back(skin(model.skins[s], fmt::format("/skins/{}", s)));
        all.transform = transform();
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

    // Checks the total size before any number is read. Repeated references to an accessor count
    // each time.
    void check_work(GltfSkins skins) const
    {
        std::size_t wanted = 0;
        for (const tinygltf::Mesh& mesh : model.meshes)
            for (const tinygltf::Primitive& p : mesh.primitives) {
                const int corner_list = p.indices >= 0 ? p.indices : attribute(p, "POSITION");
                wanted += bytes_of(attribute(p, "POSITION")) + bytes_of(corner_list);
                if (skins == GltfSkins::read)
                    wanted +=
                        bytes_of(attribute(p, "JOINTS_0")) + bytes_of(attribute(p, "WEIGHTS_0"));
            }
        for (const tinygltf::Skin& s : model.skins) wanted += bytes_of(s.inverseBindMatrices);
        if (wanted > most)
            refuse_gltf(path, "/meshes",
                        fmt::format("at most {} bytes of numbers, 64 times the file", most),
                        std::to_string(wanted));
    }

    std::string transform() const
    {
        for (std::size_t i = 0; i < model.nodes.size(); ++i) {
            const tinygltf::Node& n = model.nodes[i];
            const std::pair<const char*, bool> kinds[] = {{"matrix", !n.matrix.empty()},
                                                          {"translation", !n.translation.empty()},
                                                          {"rotation", !n.rotation.empty()},
                                                          {"scale", !n.scale.empty()}};
            for (const auto& [name, there] : kinds)
                if (there) return fmt::format("/nodes/{}/{}", i, name);
        }
        return "";
    }

    // Returns the layout of an accessor of one of the form's types; `asked` names the referrer for
    // errors.
    Rows rows(int index, const Form& form, const std::string& what)
    {
        const std::string where = fmt::format("/accessors/{} (of {})", index, what);
        const auto fail = [&](const std::string& expected, const std::string& found) {
            refuse_gltf(path, where, expected, found);
        };
        const auto& all = model.accessors;
        if (index < 0 || std::size_t(index) >= all.size())
            refuse_gltf(path, what, fmt::format("one of {} accessors", all.size()),
                        index < 0 ? "none" : std::to_string(index));
        const tinygltf::Accessor& a = all[std::size_t(index)];
        const auto& types = form.components;
        if (a.sparse.isSparse) fail("a plain accessor", "a sparse one");
        const auto columns = std::size_t(tinygltf::GetNumComponentsInType(std::uint32_t(a.type)));
        if (a.type != form.type ||
            std::find(types.begin(), types.end(), a.componentType) == types.end())
            fail(form.said, fmt::format("{} of type {}", columns, a.componentType));
        const std::size_t width = columns * size_of(a.componentType);
        const tinygltf::BufferView& view = view_of(a, where);
        const std::size_t stride = view.byteStride ? view.byteStride : width;
        if (stride < width)
            fail(fmt::format("a stride of at least {}", width), std::to_string(stride));
        // All numbers are below 2^32 here: no overflow.
        const std::size_t end = a.byteOffset + (a.count ? (a.count - 1) * stride + width : 0);
        if (end > view.byteLength)
            fail(fmt::format("the {} bytes of its view at most", view.byteLength),
                 fmt::format("{} elements that end at {}", a.count, end));
        return {model.buffers[0].data.data() + view.byteOffset + a.byteOffset, a.count, stride,
                a.componentType};
    }

    // Returns the view of an accessor, checked to lie inside the buffer.
    const tinygltf::BufferView& view_of(const tinygltf::Accessor& a, const std::string& where) const
    {
        if (a.bufferView < 0 || std::size_t(a.bufferView) >= model.bufferViews.size())
            refuse_gltf(path, where, fmt::format("one of {} views", model.bufferViews.size()),
                        a.bufferView < 0 ? "none" : std::to_string(a.bufferView));
        const tinygltf::BufferView& view = model.bufferViews[std::size_t(a.bufferView)];
        const std::string there = fmt::format("/bufferViews/{}", a.bufferView);
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
        const Rows all = rows(index, form, what);
        for (std::size_t i = 0; i < all.count; ++i) {
            std::array<double, N> numbers;
            for (std::size_t k = 0; k < N; ++k) {
                numbers[k] = all.number(i, int(k));
                if (!std::isfinite(numbers[k]))
                    refuse_gltf(path,
                                fmt::format("/accessors/{} (of {}): element {}", index, what, i),
                                "finite numbers", std::to_string(numbers[k]));
            }
            take(numbers);
        }
        return all.count;
    }

    int attribute(const tinygltf::Primitive& primitive, const char* name) const
    {
        const auto at = primitive.attributes.find(name);
        return at == primitive.attributes.end() ? -1 : at->second;
    }

    GltfPart part(const tinygltf::Primitive& primitive, const std::string& where)
    {
        GltfPart out;
        if (primitive.mode != TINYGLTF_MODE_TRIANGLES)
            refuse_gltf(path, where + "/mode", "triangles (4)", std::to_string(primitive.mode));
        const std::size_t count =
            each<3>(attribute(primitive, "POSITION"), positions, where + "/attributes/POSITION",
                    [&](const std::array<double, 3>& v) {
                        out.vertices.push_back({float(v[0]), float(v[1]), float(v[2])});
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
    const tinygltf::Model model;
    const std::size_t most;  // limit for all numbers together [bytes]
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
