#include "host/files/mesh_reader.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/files/gltf.h"
#include "host/files/stl.h"

namespace knead {
namespace {

// Splits a polygon into a fan around its first corner.
template <class At>
void add_fan(Mesh& mesh, std::size_t corners, At&& at)
{
    for (std::size_t k = 2; k < corners; ++k) mesh.triangles.push_back({at(0), at(k - 1), at(k)});
}

std::vector<std::string_view> words(std::string_view line)
{
    std::vector<std::string_view> all;
    for (std::size_t i = line.find_first_not_of(" \t\r"); i < line.size();
         i = line.find_first_not_of(" \t\r", i)) {
        const std::size_t end = std::min(line.find_first_of(" \t\r", i), line.size());
        all.push_back(line.substr(i, end - i));
        i = end;
    }
    return all;
}

// The OBJ line being parsed.
struct ObjLine {
    const std::string& path;
    std::size_t number;

    [[noreturn]] void fail(const char* expected, std::string_view found) const
    {
        throw InputError(fmt::format("{}: line {}: expected {}, found \"{}\"", path, number,
                                     expected, found.substr(0, 60)));
    }
    float coordinate(std::string_view word) const
    {
        float value = 0;
        const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (problem != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
            fail("a finite number", word);
        return value;
    }
    // "7", "7/1", "7//3" or "-1": counted from 1, or backwards from the last vertex read.
    int corner(std::string_view word, std::size_t vertices) const
    {
        long value = 0;
        const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
        const bool ends = end == word.data() + word.size() || *end == '/';
        const long index = value > 0 ? value - 1 : long(vertices) + value;
        if (problem != std::errc() || !ends || value == 0 || index < 0 || index >= long(vertices))
            fail("the number of a vertex above this line", word);
        return int(index);
    }
};

}  // namespace

void finish_mesh(Mesh& mesh, const std::string& path)
{
    if (mesh.triangles.empty()) throw InputError(path + ": expected triangles, found none");
    if (mesh.vertices.size() > std::size_t(std::numeric_limits<int>::max()))
        throw InputError(path + ": expected fewer than 2^31 vertices");
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!std::isfinite(dot(mesh.vertices[i], mesh.vertices[i])))
            throw InputError(fmt::format("{}: vertex {}: expected finite numbers", path, i));
    mesh.normals.assign(mesh.vertices.size(), {0, 0, 0});
    const int count = int(mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Int3 t = mesh.triangles[i];
        const auto valid = [&](int v) { return v >= 0 && v < count; };
        if (!valid(t.x) || !valid(t.y) || !valid(t.z))
            throw InputError(
                fmt::format("{}: triangle {}: expected vertices from 0 to {}, found {} {} {}", path,
                            i, count - 1, t.x, t.y, t.z));
        const Vec3<float> a = mesh.vertices[std::size_t(t.x)];
        const Vec3<float> area =
            cross(mesh.vertices[std::size_t(t.y)] - a, mesh.vertices[std::size_t(t.z)] - a);
        for (int v : {t.x, t.y, t.z})
            mesh.normals[std::size_t(v)] = mesh.normals[std::size_t(v)] + area;
    }
    for (Vec3<float>& n : mesh.normals) {
        const float size = length(n);
        n = size > 0 && std::isfinite(size) ? (1 / size) * n : Vec3<float>{0, 1, 0};
    }
}

Mesh to_mesh(const PlyFile& ply, const std::string& path)
{
    const PlyElement* points = ply.find("vertex");
    const PlyElement* faces = ply.find("face");
    const PlyProperty* corners = nullptr;
    if (faces)
        for (const char* name : {"vertex_indices", "vertex_index"})
            if (!corners) corners = faces->find(name);
    if (!points || !corners || !corners->list)
        throw InputError(path + ": expected vertices and faces with vertex_indices");
    Mesh mesh;
    const PlyProperty* axis[3];
    const char* names[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
        axis[k] = points->find(names[k]);
        if (!axis[k] || axis[k]->list)
            throw InputError(
                fmt::format("{}: expected the vertex property \"{}\"", path, names[k]));
    }
    for (std::size_t i = 0; i < points->rows; ++i)
        mesh.vertices.push_back(
            {float(axis[0]->values[i]), float(axis[1]->values[i]), float(axis[2]->values[i])});
    for (std::size_t f = 0; f < faces->rows; ++f) {
        const double* row = corners->values.data() + corners->start[f];
        add_fan(mesh, corners->start[f + 1] - corners->start[f], [&](std::size_t k) {
            const bool fits = row[k] >= 0 && row[k] < double(points->rows);
            return fits ? int(row[k]) : -1;
        });
    }
    finish_mesh(mesh, path);
    return mesh;
}

Mesh parse_obj(const std::string& text, const std::string& path)
{
    Mesh mesh;
    ObjLine line{path, 0};
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view whole(text.data() + at, end - at);
        const std::vector<std::string_view> w = words(whole);
        at = end + 1, ++line.number;
        if (w.empty()) continue;
        if (w[0] == "v") {
            if (w.size() < 4) line.fail("three coordinates", whole);
            mesh.vertices.push_back(
                {line.coordinate(w[1]), line.coordinate(w[2]), line.coordinate(w[3])});
        } else if (w[0] == "f") {
            if (w.size() < 4) line.fail("at least three corners", whole);
            add_fan(mesh, w.size() - 1,
                    [&](std::size_t k) { return line.corner(w[k + 1], mesh.vertices.size()); });
        }
    }
    finish_mesh(mesh, path);
    return mesh;
}

namespace {

// Returns 7 for "category 7", the name that write_mesh() writes; 0 for any other name.
int category_of(const std::string& name)
{
    constexpr std::string_view before = "category ";
    if (!name.starts_with(before)) return 0;
    const char *const first = name.data() + before.size(), *const end = name.data() + name.size();
    int category = 0;
    const auto [at, problem] = std::from_chars(first, end, category);
    const bool plain = problem == std::errc() && at == end && category >= 0 && category < 256 &&
                       (*first != '0' || end == first + 1);
    return plain ? category : 0;
}

}  // namespace

std::vector<Mesh> parse_glb(const std::string& bytes, const std::string& path)
{
    Gltf gltf = parse_gltf(bytes, path, GltfSkins::ignored);
    if (!gltf.transform.empty())
        throw InputError(fmt::format("{}: {}: expected no transform (apply it first), found one",
                                     path, gltf.transform));
    if (gltf.parts.empty()) throw InputError(path + ": /meshes: expected at least one, found none");
    std::vector<Mesh> all;
    for (GltfPart& part : gltf.parts) {
        Mesh mesh;
        mesh.category = part.category.value_or(category_of(part.mesh));
        mesh.vertices = std::move(part.vertices), mesh.triangles = std::move(part.triangles);
        finish_mesh(mesh, path);
        all.push_back(std::move(mesh));
    }
    return all;
}

std::vector<Mesh> read_mesh(const std::string& path)
{
    const std::string form = ending(path);
    if (form == ".ply") return {to_mesh(read_ply(path), path)};
    if (form == ".obj") return {parse_obj(read_text(path, max_file_bytes), path)};
    if (form == ".glb") return parse_glb(read_text(path, max_file_bytes), path);
    if (form == ".stl") return {parse_stl(read_text(path, max_file_bytes), path)};
    throw InputError(path + ": expected a mesh ending in .ply, .obj, .glb or .stl");
}

}  // namespace knead
