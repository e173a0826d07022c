// Writes meshes as GLB (glTF 2.0), OBJ, PLY, STL and 3MF, atomically.
#include "host/files/mesh_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/files/glb.h"
#include "host/files/stl.h"
#include "host/files/three_mf.h"

namespace knead {

namespace {

static_assert(std::endian::native == std::endian::little, "this PLY is little-endian");

[[noreturn]] void fail(const std::string& path, const std::string& reason)
{
    throw OutputError(path + ": " + reason);
}

template <class T>
void append(std::string& bytes, const T& value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
void append_all(std::string& bytes, const std::vector<T>& values)
{
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

// Shortest decimal digits that read back as the same number, independent of the locale.
template <class T>
void append_digits(std::string& text, T value)
{
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    text.append(digits, end);
}
void append_digits(std::string& text, Vec3<float> v)
{
    for (const float s : {v.x, v.y, v.z}) text += ' ', append_digits(text, s);
}

// sRGB encoding of a linear channel; OBJ and PLY store display colours.  IEC 61966-2-1
float encoded(float s)
{
    return s <= 0.0031308f ? 12.92f * s : 1.055f * std::pow(s, 1 / 2.4f) - 0.055f;
}
Vec3<float> shown_colour(const Mesh& mesh, std::size_t vertex)
{
    const Vec3<float> c =
        mesh.colours.empty() ? category_colour(mesh.category) : mesh.colours[vertex];
    return {encoded(c.x), encoded(c.y), encoded(c.z)};
}

void check(const std::string& path, const Mesh& mesh)
{
    const std::string which = "the mesh of category " + std::to_string(mesh.category);
    if (mesh.normals.size() != mesh.vertices.size())
        fail(path, which + " has " + std::to_string(mesh.vertices.size()) + " vertices but " +
                       std::to_string(mesh.normals.size()) + " normals");
    const auto finite = [](Vec3<float> v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size())
        fail(path, which + " has " + std::to_string(mesh.vertices.size()) + " vertices but " +
                       std::to_string(mesh.colours.size()) + " colours");
    if (!std::all_of(mesh.vertices.begin(), mesh.vertices.end(), finite) ||
        !std::all_of(mesh.normals.begin(), mesh.normals.end(), finite))
        fail(path, which + " has a vertex or normal that is not finite");
    if (!std::all_of(mesh.colours.begin(), mesh.colours.end(), finite))
        fail(path, which + " has a colour that is not finite");
    const auto known = [&](int v) { return v >= 0 && std::size_t(v) < mesh.vertices.size(); };
    for (const Int3 t : mesh.triangles)
        if (!known(t.x) || !known(t.y) || !known(t.z))
            fail(path, which + " has a triangle with a vertex that is not there");
}

std::string plain_name(const Mesh& mesh) { return "category " + std::to_string(mesh.category); }

struct NamedMesh {
    const Mesh* mesh;
    std::string name;
};

// An OBJ name ends at white space.
std::string without_spaces(std::string name)
{
    for (char& c : name)
        if (static_cast<unsigned char>(c) <= ' ' || c == '\x7f') c = '_';
    return name;
}

// Adds a node per category. The vertices carry the colour, over a matt white material. A name that
// is not "category N" has the category beside it, for read_mesh().
void add_mesh(Glb& glb, const Mesh& mesh, const std::string& name)
{
    nlohmann::json& gltf = glb.gltf;
    const auto vectors = [&](const std::vector<Vec3<float>>& values) {
        return add_accessor(glb, values, gltf_float, "VEC3", values.size(), gltf_vertices);
    };
    const int position = vectors(mesh.vertices);
    Box3<float> box{mesh.vertices[0], mesh.vertices[0]};
    for (const Vec3<float> v : mesh.vertices) grow(box, v);
    gltf["accessors"][position]["min"] = {box.low.x, box.low.y, box.low.z};
    gltf["accessors"][position]["max"] = {box.high.x, box.high.y, box.high.z};
    const int normal = vectors(mesh.normals);
    const int colour =
        mesh.colours.empty()
            ? vectors(std::vector(mesh.vertices.size(), category_colour(mesh.category)))
            : vectors(mesh.colours);
    const int indices = add_accessor(glb, mesh.triangles, gltf_index, "SCALAR",
                                     3 * mesh.triangles.size(), gltf_indices);
    const nlohmann::json primitive = {
        {"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"COLOR_0", colour}}},
        {"indices", indices},
        {"material", 0}};
    gltf["nodes"].push_back({{"mesh", gltf["nodes"].size()}, {"name", name}});
    gltf["meshes"].push_back({{"name", name}, {"primitives", nlohmann::json::array({primitive})}});
    if (name != plain_name(mesh)) gltf["meshes"].back()["extras"] = {{"category", mesh.category}};
    gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size() - 1);
}

std::string glb(const std::string& path, const std::vector<NamedMesh>& meshes)
{
    Glb glb;
    glb.gltf = {{"asset", {{"version", "2.0"}, {"generator", "knead"}}},
                {"scene", 0},
                {"scenes", nlohmann::json::array({{{"name", "clay"}}})}};
    for (const NamedMesh& one : meshes) add_mesh(glb, *one.mesh, one.name);
    if (!meshes.empty())
        glb.gltf["materials"].push_back(
            {{"name", "clay"},
             {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.8}}}});
    return glb_bytes(std::move(glb), path, "try .ply");
}

std::string obj(const std::vector<NamedMesh>& meshes, const std::string& unit)
{
    std::string text = "# knead; " + unit + "; vertex colours in sRGB\n";
    std::size_t before = 1;  // OBJ indices start at 1 and continue through all objects
    for (const auto& [mesh, name] : meshes) {
        text += "o " + without_spaces(name) + '\n';
        for (std::size_t v = 0; v < mesh->vertices.size(); ++v) {
            text += 'v', append_digits(text, mesh->vertices[v]);
            append_digits(text, shown_colour(*mesh, v)), text += '\n';
        }
        for (const Vec3<float> n : mesh->normals)
            text += "vn", append_digits(text, n), text += '\n';
        for (const Int3 t : mesh->triangles) {
            text += 'f';
            for (const int v : {t.x, t.y, t.z}) {
                const std::string at = std::to_string(before + std::size_t(v));
                text += ' ', text += at, text += "//", text += at;
            }
            text += '\n';
        }
        before += mesh->vertices.size();
    }
    return text;
}

std::string ply(const std::string& path, const std::vector<NamedMesh>& meshes,
                const std::string& unit)
{
    std::size_t vertices = 0, triangles = 0;
    for (const auto& [mesh, name] : meshes)
        vertices += mesh->vertices.size(), triangles += mesh->triangles.size();
    if (vertices > INT32_MAX) fail(path, "a PLY indexes at most 2^31 vertices");
    std::string bytes = "ply\nformat binary_little_endian 1.0\n";
    bytes += "comment knead; " + unit + "; sRGB\n";
    bytes += "element vertex " + std::to_string(vertices) + '\n';
    for (const char* const name : {"x", "y", "z", "nx", "ny", "nz"})
        bytes += std::string("property float ") + name + '\n';
    for (const char* const name : {"red", "green", "blue"})
        bytes += std::string("property uchar ") + name + '\n';
    bytes += "element face " + std::to_string(triangles) + '\n';
    bytes += "property list uchar int vertex_indices\nend_header\n";
    for (const auto& [mesh, name] : meshes) {
        const auto channel = [](float s) {
            return std::uint8_t(std::lround(255 * std::clamp(s, 0.0f, 1.0f)));
        };
        for (std::size_t v = 0; v < mesh->vertices.size(); ++v) {
            const Vec3<float> c = shown_colour(*mesh, v);
            append(bytes, mesh->vertices[v]), append(bytes, mesh->normals[v]);
            append(bytes, std::array<std::uint8_t, 3>{channel(c.x), channel(c.y), channel(c.z)});
        }
    }
    int before = 0;
    for (const auto& [mesh, name] : meshes) {
        for (const Int3 t : mesh->triangles)
            bytes += char(3), append(bytes, t + Int3{before, before, before});
        before += int(mesh->vertices.size());
    }
    return bytes;
}

}  // namespace

void write_mesh(const std::string& path, const std::vector<Mesh>& meshes, const MeshLabels& labels)
{
    if (!labels.names.empty() && labels.names.size() != meshes.size())
        throw std::invalid_argument("write_mesh(): expected a name per mesh");
    std::vector<NamedMesh> shown;  // glTF does not allow empty meshes
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        check(path, meshes[i]);
        if (meshes[i].triangles.empty()) continue;
        shown.push_back(
            {&meshes[i], labels.names.empty() ? plain_name(meshes[i]) : labels.names[i]});
    }
    const std::string form = ending(path);
    if (form == ".glb") {
        write_whole(path, glb(path, shown));
    } else if (form == ".obj") {
        write_whole(path, obj(shown, labels.unit));
    } else if (form == ".ply") {
        write_whole(path, ply(path, shown, labels.unit));
    } else if (form == ".stl") {
        std::vector<const Mesh*> all;
        for (const NamedMesh& one : shown) all.push_back(one.mesh);
        write_whole(path, stl_bytes(all, path, labels.unit));
    } else if (form == ".3mf") {
        std::vector<const Mesh*> all;
        std::vector<std::string> names;
        for (const NamedMesh& one : shown) all.push_back(one.mesh), names.push_back(one.name);
        write_whole(path, three_mf_bytes(all, names, labels.unit, path));
    } else {
        fail(path, "a mesh is written as .glb, .obj, .ply, .stl or .3mf");
    }
}

}  // namespace knead
