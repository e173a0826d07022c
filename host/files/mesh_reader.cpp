#include "host/files/mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/base/text_number.h"
#include "host/files/gltf.h"
#include "host/files/stl.h"
#include "host/files/three_mf.h"

namespace knead {
namespace {

// Splits a polygon into a fan around its first corner.
template <class At>
void add_fan(FileMesh& mesh, std::size_t corners, At&& at)
{
    for (std::size_t k = 2; k < corners; ++k) mesh.triangles.push_back({at(0), at(k - 1), at(k)});
}

void add_words(std::vector<std::string_view>& all, std::string_view line)
{
    for (std::size_t i = line.find_first_not_of(" \t"); i < line.size();
         i = line.find_first_not_of(" \t", i)) {
        const std::size_t end = std::min(line.find_first_of(" \t", i), line.size());
        all.push_back(line.substr(i, end - i));
        i = end;
    }
}

// Reads an OBJ line by line. Faces may name vertices of later lines.
class ObjText {
  public:
    ObjText(const std::string& of, const std::string& from) : text(of), path(from) {}

    MeshFile parse()
    {
        for (std::size_t at = text_begin(text, path); at < text.size();) {
            words.clear();
            take_line(at);
            if (words.empty()) continue;
            if (words[0] == "v")
                take_vertex();
            else if (words[0] == "f")
                take_face();
            else if (words[0] == "l" || words[0] == "p")
                ++thin;
            else if (words[0] == "usemtl")
                materials = true;
        }
        if (farthest >= mesh.vertices.size() && farthest_line > 0) {
            number = farthest_line;
            fail(fmt::format("the number of one of {} vertices", mesh.vertices.size()),
                 std::to_string(farthest + 1));
        }
        check_mesh(mesh, path);
        take_colours();
        MeshFile file;
        file.meshes.push_back(std::move(mesh));
        if (thin) file.notes.push_back(fmt::format("{} lines and points left out", thin));
        if (materials && file.meshes[0].colours.empty())
            file.notes.push_back("colours of its materials left out");
        return file;
    }

  private:
    [[noreturn]] void fail(const std::string& expected, std::string_view found,
                           std::string_view why = {}) const
    {
        throw InputError(fmt::format("{}: line {}: expected {}, found \"{}\"{}", path, number,
                                     expected, found.substr(0, 60), in_brackets(why)));
    }

    // The words of a line and of those that continue it, without comments.
    void take_line(std::size_t& at)
    {
        for (bool ends = false; !ends && at < text.size();) {
            std::string_view line = next_line(text, at);
            ++number;
            if (words.empty()) whole = line;
            std::size_t comment = line.find('#');  // not that of "1.#IND"
            while (comment != line.npos && comment > 0 && line[comment - 1] == '.')
                comment = line.find('#', comment + 1);
            line = line.substr(0, comment);
            ends = !line.ends_with('\\');
            if (!ends) line.remove_suffix(1);
            add_words(words, line);
        }
    }

    double coordinate(std::string_view word) const
    {
        const TextNumber found = finite_text_number(word);
        if (!found.fault.empty()) fail("a finite number", word, found.fault);
        return found.value;
    }

    // x y z, and of these: a weight, or red green blue, or both with alpha.
    void take_vertex()
    {
        if (words.size() < 4) fail("three coordinates", whole);
        mesh.vertices.push_back({coordinate(words[1]), coordinate(words[2]), coordinate(words[3])});
        for (std::size_t k = 4; k < words.size(); ++k) coordinate(words[k]);
        if (words.size() < 7) return;
        colours.push_back({coordinate(words[4]), coordinate(words[5]), coordinate(words[6])});
        for (const double c : {colours.back().x, colours.back().y, colours.back().z})
            brightest = std::max(brightest, c);
    }

    // "7", "7/1", "7//3" or "-1": counted from 1, or backwards from the last vertex read.
    int corner(std::string_view word)
    {
        long value = 0;
        std::string_view index = word.substr(0, word.find('/'));
        if (index.starts_with('+')) index.remove_prefix(1);
        const char* const end = index.data() + index.size();
        const auto [at, problem] = std::from_chars(index.data(), end, value);
        const long found = value > 0 ? value - 1 : long(mesh.vertices.size()) + value;
        if (problem != std::errc() || at != end || value == 0 || found < 0 ||
            found >= std::numeric_limits<int>::max())
            fail("the number of a vertex", word);
        if (std::size_t(found) >= farthest) farthest = std::size_t(found), farthest_line = number;
        return int(found);
    }

    void take_face()
    {
        if (words.size() < 4) fail("at least three corners", whole);
        corners.clear();
        for (std::size_t k = 1; k < words.size(); ++k) corners.push_back(corner(words[k]));
        add_fan(mesh, corners.size(), [&](std::size_t k) { return corners[k]; });
    }

    void take_colours()
    {
        if (colours.size() != mesh.vertices.size()) return;
        const double most = brightest > 1 ? 255 : 1;
        for (const Vec3<double> c : colours) mesh.colours.push_back(linear_colour((1 / most) * c));
    }

    const std::string &text, &path;
    std::size_t number = 0;                       // of the line
    std::size_t farthest = 0, farthest_line = 0;  // the highest vertex that a face names
    std::size_t thin = 0;                         // lines and points
    bool materials = false;
    double brightest = 0;
    std::string_view whole;  // the line
    std::vector<std::string_view> words;
    std::vector<int> corners;
    std::vector<Vec3<double>> colours;  // sRGB
    FileMesh mesh;
};

}  // namespace

Vec3<float> linear_colour(Vec3<double> srgb)
{
    const auto linear = [](double s) {
        s = std::clamp(s, 0.0, 1.0);
        return float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    };
    return {linear(srgb.x), linear(srgb.y), linear(srgb.z)};
}

namespace {

// Of a FileMesh or a Mesh.
template <class M>
void check(const M& mesh, const std::string& path)
{
    if (mesh.triangles.empty()) throw InputError(path + ": expected triangles, found none");
    if (mesh.vertices.size() > std::size_t(std::numeric_limits<int>::max()))
        throw InputError(path + ": expected fewer than 2^31 vertices");
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!std::isfinite(dot(mesh.vertices[i], mesh.vertices[i])))
            throw InputError(fmt::format("{}: vertex {}: expected finite numbers", path, i));
    const int count = int(mesh.vertices.size());
    const auto valid = [&](int v) { return v >= 0 && v < count; };
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (const Int3 t = mesh.triangles[i]; !valid(t.x) || !valid(t.y) || !valid(t.z))
            throw InputError(
                fmt::format("{}: triangle {}: expected vertices from 0 to {}, found {} {} {}", path,
                            i, count - 1, t.x, t.y, t.z));
}

}  // namespace

void check_mesh(const FileMesh& mesh, const std::string& path) { check(mesh, path); }

void finish_mesh(Mesh& mesh, const std::string& path)
{
    check(mesh, path);
    mesh.normals.assign(mesh.vertices.size(), {0, 0, 0});
    for (const Int3 t : mesh.triangles) {
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

namespace {

// Colours of the vertices, where they have any: integers are parts of their type's largest.
std::vector<Vec3<float>> ply_colours(const PlyElement& points)
{
    for (const std::string before : {"", "diffuse_"}) {
        const PlyProperty* channel[3];
        const char* names[] = {"red", "green", "blue"};
        bool all = true;
        for (int k = 0; k < 3; ++k) {
            channel[k] = points.find(before + names[k]);
            all = all && channel[k] && !channel[k]->list;
        }
        if (!all) continue;
        const PlyType type = channel[0]->type;
        const double most = type <= PlyType::u8 ? 255 : type <= PlyType::u64 ? 65535 : 1;
        std::vector<Vec3<float>> colours;
        for (std::size_t i = 0; i < points.rows; ++i)
            colours.push_back(
                linear_colour({channel[0]->values[i] / most, channel[1]->values[i] / most,
                               channel[2]->values[i] / most}));
        return colours;
    }
    return {};
}

const PlyProperty* corner_list(const PlyElement* element)
{
    if (element)
        for (const char* name : {"vertex_indices", "vertex_index"})
            if (const PlyProperty* found = element->find(name); found && found->list) return found;
    return nullptr;
}

// Each list is several strips, with -1 between them; every second triangle is turned.
void add_strips(FileMesh& mesh, const std::vector<int>& corners)
{
    for (std::size_t k = 0, from = 0; k < corners.size(); ++k) {
        if (corners[k] < 0) from = k + 1;
        if (corners[k] < 0 || k < from + 2) continue;
        const bool even = (k - from) % 2 == 0;
        mesh.triangles.push_back(
            {corners[k - 2], corners[k - (even ? 1 : 0)], corners[k - (even ? 0 : 1)]});
    }
}

}  // namespace

FileMesh to_mesh(const PlyFile& ply, const std::string& path)
{
    const PlyElement *points = ply.find("vertex"), *faces = ply.find("face"),
                     *strips = ply.find("tristrips");
    const PlyProperty *of_faces = corner_list(faces), *of_strips = corner_list(strips);
    if (!points || (!of_faces && !of_strips))
        throw InputError(path + ": expected vertices and faces with vertex_indices");
    FileMesh mesh;
    const PlyProperty* axis[3];
    const char* names[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
        axis[k] = points->find(names[k]);
        if (!axis[k] || axis[k]->list)
            throw InputError(
                fmt::format("{}: expected the vertex property \"{}\"", path, names[k]));
    }
    for (std::size_t i = 0; i < points->rows; ++i)
        mesh.vertices.push_back({axis[0]->values[i], axis[1]->values[i], axis[2]->values[i]});
    const int none = std::numeric_limits<int>::max();  // which check_mesh() refuses
    const auto index = [&](double v) { return v >= 0 && v < double(points->rows) ? int(v) : none; };
    for (std::size_t f = 0; of_faces && f < faces->rows; ++f) {
        const double* row = of_faces->values.data() + of_faces->start[f];
        add_fan(mesh, of_faces->start[f + 1] - of_faces->start[f],
                [&](std::size_t k) { return index(row[k]); });
    }
    for (std::size_t s = 0; of_strips && s < strips->rows; ++s) {
        std::vector<int> corners;
        for (std::size_t k = of_strips->start[s]; k < of_strips->start[s + 1]; ++k)
            corners.push_back(of_strips->values[k] == -1 ? -1 : index(of_strips->values[k]));
        add_strips(mesh, corners);
    }
    check_mesh(mesh, path);
    mesh.colours = ply_colours(*points);
    return mesh;
}

MeshFile parse_obj(const std::string& text, const std::string& path)
{
    return ObjText(text, path).parse();
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

MeshFile parse_glb(const std::string& bytes, const std::string& path)
{
    Gltf gltf = parse_gltf(bytes, path, GltfSkins::ignored);
    if (gltf.parts.empty())
        throw InputError(path + ": expected triangles of its default scene, found none");
    MeshFile file;
    file.notes = std::move(gltf.notes);
    for (GltfPart& part : gltf.parts) {
        FileMesh mesh;
        mesh.name = part.mesh;
        mesh.category = part.category.value_or(category_of(part.mesh));
        mesh.vertices = std::move(part.vertices), mesh.triangles = std::move(part.triangles);
        mesh.colours = std::move(part.colours);
        check_mesh(mesh, path);
        file.meshes.push_back(std::move(mesh));
    }
    return file;
}

MeshFile read_mesh_file(const std::string& path)
{
    const std::string form = ending(path);
    const auto alone = [](FileMesh mesh) {
        MeshFile file;
        file.meshes.push_back(std::move(mesh));
        return file;
    };
    if (form == ".ply") return alone(to_mesh(read_ply(path), path));
    if (form == ".obj") return parse_obj(read_text(path, max_file_bytes), path);
    if (form == ".glb") return parse_glb(read_text(path, max_file_bytes), path);
    if (form == ".stl") return alone(parse_stl(read_text(path, max_file_bytes), path));
    if (form == ".3mf") return parse_3mf(read_text(path, max_file_bytes), path);
    throw InputError(path + ": expected a mesh ending in .ply, .obj, .glb, .stl or .3mf");
}

std::vector<Mesh> float_meshes(const MeshFile& file, const std::string& path, Vec3<double> origin)
{
    std::vector<Mesh> all;
    for (const FileMesh& from : file.meshes) {
        Mesh mesh;
        mesh.category = from.category;
        mesh.vertices.reserve(from.vertices.size());
        for (const Vec3<double> v : from.vertices) mesh.vertices.push_back(cast<float>(v - origin));
        mesh.triangles = from.triangles, mesh.colours = from.colours;
        finish_mesh(mesh, path);
        all.push_back(std::move(mesh));
    }
    return all;
}

std::vector<Mesh> read_mesh(const std::string& path)
{
    return float_meshes(read_mesh_file(path), path);
}

Box3<double> box_of(const std::vector<FileMesh>& meshes)
{
    Box3<double> box = empty_box<double>();
    for (const FileMesh& mesh : meshes)
        for (const Vec3<double> v : mesh.vertices) grow(box, v);
    return box;
}

double volume(const FileMesh& mesh)
{
    // About the origin, or a vertex where that is far: differences of large numbers otherwise.
    const Box3<double> box = box_of({mesh});
    const Vec3<double> far = greater(box.high, -1.0 * box.low);
    Vec3<double> o{};
    if (std::max({far.x, far.y, far.z}) > 100 * longest_edge(box)) o = mesh.vertices.at(0);
    double six = 0;
    const auto at = [&](int v) { return mesh.vertices[std::size_t(v)] - o; };
    for (const Int3 t : mesh.triangles) six += dot(at(t.x), cross(at(t.y), at(t.z)));
    return six / 6;
}

}  // namespace knead
