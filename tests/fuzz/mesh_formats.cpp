// Meshes: PLY, OBJ, GLB, STL, 3MF; and as bodies.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "host/base/json_reader.h"
#include "host/files/gltf.h"
#include "host/files/mesh_file.h"
#include "host/files/mesh_reader.h"
#include "host/files/stl.h"
#include "host/files/three_mf.h"
#include "host/scene/solid_mesh.h"
#include "tests/folder.h"
#include "tests/fuzz/formats.h"

namespace knead {
namespace {

Mesh octahedron(int category, float at)
{
    Mesh m;
    m.category = category;
    m.vertices = {{at + 1, 0, 0}, {at - 1, 0, 0}, {at, 1, 0}, {at, -1, 0}, {at, 0, 1}, {at, 0, -1}};
    m.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                   {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    finish_mesh(m, "a seed");
    return m;
}

std::string written(const std::string& ending, const std::vector<Mesh>& meshes)
{
    const Folder folder;
    write_mesh(folder / ("seed" + ending), meshes);
    return read_text(folder / ("seed" + ending), 1 << 20);
}

std::vector<std::string> pairs(const std::string& ending)
{
    return {written(ending, {octahedron(0, 0)}),
            written(ending, {octahedron(1, 0), octahedron(7, 1e-3f)})};
}

// As clay, of at most so many triangles: the time is for the readers.
void use_as_body(const FileMesh& mesh)
{
    if (mesh.triangles.size() > 2000) return;
    const MadeSolid made = SolidMesh::make(mesh.vertices, mesh.triangles, {0.8, 0, 0.6, 0});
    if ((made.solid == nullptr) == made.why.empty())
        throw std::logic_error("neither a body nor a reason");
    if (!made.solid) return;
    const SolidMesh& body = *made.solid;
    const Vec3<double> size = body.size();
    if (!(std::max({size.x, size.y, size.z}) < 1 + 1e-9) || !(body.volume() > 0))
        throw std::logic_error("a body without a size");
    for (const double at : {-0.4, 0.01, 0.3})
        if (!std::isfinite(body.depth({at, 0.5 * at, -at}, 0.1)))
            throw std::logic_error("a depth that is not finite");
}

// What `info` says of a mesh and `convert` does with it.
void use(const MeshFile& file)
{
    const std::vector<Mesh> meshes = float_meshes(file, "mesh");
    std::vector<const Mesh*> all;
    double sum = 0;
    for (const FileMesh& mesh : file.meshes) sum += volume(mesh);
    if (file.meshes.size() < 100)
        for (const FileMesh& mesh : file.meshes) use_as_body(mesh);
    for (const Mesh& mesh : meshes) {
        sum += volume(mesh) + components(mesh);
        all.push_back(&mesh);
    }
    must_pass("as STL", [&] { parse_stl(stl_bytes(all, "again"), "again"); });
    if (sum == 0.12345) throw std::logic_error("so that the sum is computed");
}

std::vector<std::string> ply_seeds()
{
    std::vector<std::string> all = pairs(".ply");
    all.push_back(
        "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty double z\nelement face 2\n"
        "property list uchar int vertex_index\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2\n4 0 1 2 3\n");
    all.push_back(
        std::string("ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty uchar x\n"
                    "property uchar y\nproperty uchar z\nelement face 1\n"
                    "property list uchar ushort vertex_indices\nend_header\n") +
        std::string("\1\0\0\0\1\0\0\0\1\3\0\0\0\1\0\2", 16));
    return all;
}
void read_ply_mesh(const std::string& bytes)
{
    const PlyFile header = parse_ply_header(bytes.substr(0, 1 << 20), "mesh.ply");
    const bool found = header.find("face") != nullptr;
    const PlyFile ply = parse_ply(bytes, "mesh.ply");
    if (found != (ply.find("face") != nullptr)) throw std::logic_error("two heads of one file");
    use({{to_mesh(ply, "mesh.ply")}, {}, 0});
}

std::vector<std::string> obj_seeds()
{
    std::vector<std::string> all = pairs(".obj");
    all.push_back(
        "# by hand\r\nmtllib a.mtl\r\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nv 0 0 1\nvt 0 0\n"
        "vn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf -1 -2 -3\nf 1 2 3 4\n");
    return all;
}
void read_obj_mesh(const std::string& bytes) { use(parse_obj(bytes, "mesh.obj")); }

// With the lengths of its file and of its two chunks put right, where it has two.
std::string with_lengths(std::string glb)
{
    const std::size_t head = 20, binary = glb.find(std::string("BIN\0", 4), head);
    if (binary == std::string::npos || binary < head + 4) return glb;
    const auto put = [&](std::size_t at, std::size_t value) {
        const auto word = std::uint32_t(value);
        std::memcpy(glb.data() + at, &word, sizeof word);
    };
    std::size_t begin = binary - 4;  // of the second chunk
    const std::size_t lacks = (4 - begin % 4) % 4;
    glb.insert(begin, lacks, ' ');
    begin += lacks;
    put(8, glb.size()), put(12, begin - head), put(begin, glb.size() - begin - 8);
    return glb;
}

std::vector<std::string> glb_seeds() { return pairs(".glb"); }
void read_glb_mesh(const std::string& bytes)
{
    const auto both = [](const std::string& glb) {
        try {
            parse_gltf(glb, "mesh.glb", GltfSkins::read);
        } catch (const InputError&) {
        }
        use(parse_glb(glb, "mesh.glb"));
    };
    try {
        both(bytes);
    } catch (const InputError&) {
        both(with_lengths(bytes));
    }
}

std::vector<std::string> stl_seeds()
{
    std::vector<std::string> all = pairs(".stl");
    all.push_back(
        "solid by hand\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex +1e0 0 0\n"
        "   vertex 0 1 0\n  endloop\n endfacet\nendsolid by hand\n");
    return all;
}
void read_stl_mesh(const std::string& bytes) { use({{parse_stl(bytes, "mesh.stl")}, {}, 0}); }

std::vector<std::string> three_mf_seeds() { return pairs(".3mf"); }
void read_three_mf_mesh(const std::string& bytes) { use(parse_3mf(bytes, "mesh.3mf")); }

}  // namespace

std::vector<FuzzFormat> mesh_formats()
{
    return {{"mesh-ply", ply_seeds, read_ply_mesh},
            {"mesh-obj", obj_seeds, read_obj_mesh},
            {"mesh-glb", glb_seeds, read_glb_mesh},
            {"mesh-stl", stl_seeds, read_stl_mesh},
            {"mesh-3mf", three_mf_seeds, read_three_mf_mesh}};
}

}  // namespace knead
