// What was written as GLB, OBJ and PLY is read again: GLB by another's reader, the others here.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

// A name of its own: whoever else reads glTF may bring the same implementation.
#define tinygltf tinygltf_of_mesh_file_test
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include "host/files/mesh_file.h"
#include "host/surface/mesh.h"
#include "tests/folder.h"
#include "tests/small_disk.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

// A tetrahedron with corners that need all digits of a float.
Mesh tetrahedron(int category, float shift)
{
    Mesh m;
    m.category = category;
    const float a = 1.0f / 3, b = 0.1f;
    m.vertices = {{shift, 0, 0}, {shift + a, 0, 0}, {shift, a, 1e-7f}, {shift, -b, a}};
    m.normals = {{-0.6f, 0, -0.8f}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    m.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return m;
}
std::vector<Mesh> pair_of_meshes() { return {tetrahedron(0, 0), tetrahedron(7, 2.1f)}; }

bool same(Vec3<float> a, Vec3<float> b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

std::string error_of(const std::string& path, const std::vector<Mesh>& meshes)
{
    try {
        write_mesh(path, meshes);
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return "";
}

std::string text_of(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

template <class T>
std::vector<T> accessor(const tinygltf::Model& model, int index, std::size_t each)
{
    const tinygltf::Accessor& a = model.accessors.at(std::size_t(index));
    const tinygltf::BufferView& view = model.bufferViews.at(std::size_t(a.bufferView));
    EXPECT_EQ(view.byteLength, a.count * each);
    std::vector<T> values(a.count * each / sizeof(T));
    std::memcpy(values.data(), model.buffers.at(0).data.data() + view.byteOffset, view.byteLength);
    return values;
}

TEST(MeshFile, GlbIsReadBackToTheBitByAnotherReader)
{
    const Folder place;
    const std::vector<Mesh> meshes = pair_of_meshes();
    write_mesh(place / "two.glb", meshes);
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string error, warning;
    ASSERT_TRUE(reader.LoadBinaryFromFile(&model, &error, &warning, place / "two.glb")) << error;
    EXPECT_EQ(error + warning, "");
    ASSERT_EQ(model.meshes.size(), 2u);
    ASSERT_EQ(model.scenes.at(0).nodes, (std::vector<int>{0, 1}));
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(model.nodes.at(k).mesh, int(k));
        EXPECT_EQ(model.meshes[k].name, "category " + std::to_string(meshes[k].category));
        const tinygltf::Primitive& part = model.meshes[k].primitives.at(0);
        const int position = part.attributes.at("POSITION");
        const auto x = accessor<Vec3<float>>(model, position, 12);
        const auto n = accessor<Vec3<float>>(model, part.attributes.at("NORMAL"), 12);
        const auto c = accessor<Vec3<float>>(model, part.attributes.at("COLOR_0"), 12);
        const auto t = accessor<Int3>(model, part.indices, 4);
        ASSERT_EQ(x.size(), 4u);
        ASSERT_EQ(t.size(), 4u);
        for (std::size_t v = 0; v < 4; ++v) {
            EXPECT_TRUE(same(x[v], meshes[k].vertices[v]));
            EXPECT_TRUE(same(n[v], meshes[k].normals[v]));
            EXPECT_TRUE(same(c[v], category_colour(meshes[k].category)));
            EXPECT_TRUE(t[v] == meshes[k].triangles[v]);
        }
        const tinygltf::Accessor& bounds = model.accessors[std::size_t(position)];
        EXPECT_EQ(bounds.minValues.at(1), double(-0.1f));
        EXPECT_EQ(bounds.maxValues.at(0), double(x[1].x));
    }
}

TEST(MeshFile, ObjIsReadBackToTheBit)
{
    const Folder place;
    const std::vector<Mesh> meshes = pair_of_meshes();
    write_mesh(place / "two.OBJ", meshes);
    std::ifstream file(place / "two.OBJ");
    std::vector<Vec3<float>> x, c, n;
    std::vector<int> corner;
    std::string objects;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        const auto number = [&] {
            std::string digits;
            words >> digits;
            return std::stof(digits);
        };
        const auto three = [&] {
            const float a = number(), b = number();
            return Vec3<float>{a, b, number()};
        };
        if (word == "v") x.push_back(three()), c.push_back(three());
        if (word == "vn") n.push_back(three());
        if (word == "o") objects += line + ';';
        for (std::string at; word == "f" && words >> at;) {
            const std::size_t slashes = at.find("//");
            ASSERT_NE(slashes, std::string::npos);
            ASSERT_EQ(at.substr(0, slashes), at.substr(slashes + 2));
            corner.push_back(std::stoi(at));
        }
    }
    EXPECT_EQ(objects, "o category_0;o category_7;");
    ASSERT_EQ(x.size(), 8u);
    ASSERT_EQ(n.size(), 8u);
    ASSERT_EQ(corner.size(), 24u);
    for (std::size_t v = 0; v < 8; ++v) {
        EXPECT_TRUE(same(x[v], meshes[v / 4].vertices[v % 4]));
        EXPECT_TRUE(same(n[v], meshes[v / 4].normals[v % 4]));
        EXPECT_GT(length(c[v]), 0.2f);
    }
    for (std::size_t t = 0; t < 8; ++t) {
        const int before = t < 4 ? 1 : 5;
        EXPECT_TRUE((Int3{corner[3 * t], corner[3 * t + 1], corner[3 * t + 2]} ==
                     meshes[t / 4].triangles[t % 4] + Int3{before, before, before}));
    }
}

TEST(MeshFile, NamesAndUnitAreThoseOfTheLabels)
{
    const Folder place;
    std::vector<Mesh> meshes = pair_of_meshes();
    meshes.insert(meshes.begin() + 1, Mesh{});  // without triangles: left out, with its name
    const MeshLabels labels{{"left block + \"ball\"", "none", "Töpfchen\n2"}, "millimetres"};
    for (const char* form : {".glb", ".obj", ".ply", ".stl"})
        write_mesh(place / ("two" + std::string(form)), meshes, labels);
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string error, warning;
    ASSERT_TRUE(reader.LoadBinaryFromFile(&model, &error, &warning, place / "two.glb")) << error;
    ASSERT_EQ(model.meshes.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(model.meshes[k].name, labels.names[2 * k]);
        EXPECT_EQ(model.nodes[k].name, labels.names[2 * k]);
        EXPECT_EQ(model.meshes[k].extras.Get("category").GetNumberAsInt(), k == 0 ? 0 : 7);
    }
    const std::string obj = text_of(place / "two.obj");
    EXPECT_EQ(
        obj.rfind("# knead; millimetres; vertex colours in sRGB\no left_block_+_\"ball\"\n", 0),
        0u);
    EXPECT_NE(obj.find("\no Töpfchen_2\n"), std::string::npos);
    EXPECT_EQ(obj.find("none"), std::string::npos);
    EXPECT_NE(text_of(place / "two.ply").find("\ncomment knead; millimetres; sRGB\n"),
              std::string::npos);
    EXPECT_EQ(text_of(place / "two.stl").rfind("knead; millimetres ", 0), 0u);
    EXPECT_THROW(write_mesh(place / "two.obj", meshes, {{"one"}, "metres"}), std::invalid_argument);
}

TEST(MeshFile, PlyIsReadBackToTheBit)
{
    const Folder place;
    const std::vector<Mesh> meshes = pair_of_meshes();
    write_mesh(place / "two.ply", meshes);
    const std::string bytes = text_of(place / "two.ply");
    const std::string end = "end_header\n";
    const std::size_t start = bytes.find(end);
    ASSERT_NE(start, std::string::npos);
    const std::string header = bytes.substr(0, start);
    EXPECT_EQ(header.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
    EXPECT_NE(header.find("element vertex 8\nproperty float x\nproperty float y\n"),
              std::string::npos);
    EXPECT_NE(header.find("element face 8\nproperty list uchar int vertex_indices\n"),
              std::string::npos);
    const char* at = bytes.data() + start + end.size();
    ASSERT_EQ(bytes.data() + bytes.size() - at, 8 * (24 + 3) + 8 * 13);
    for (std::size_t v = 0; v < 8; ++v, at += 27) {
        Vec3<float> two[2];
        std::memcpy(two, at, sizeof two);
        EXPECT_TRUE(same(two[0], meshes[v / 4].vertices[v % 4]));
        EXPECT_TRUE(same(two[1], meshes[v / 4].normals[v % 4]));
    }
    EXPECT_EQ(std::memcmp(bytes.data() + start + end.size() + 24, "\xc8\x64\x3c", 3), 0);
    for (std::size_t t = 0; t < 8; ++t, at += 13) {
        Int3 triangle;
        EXPECT_EQ(*at, 3);
        std::memcpy(&triangle, at + 1, sizeof triangle);
        const int before = t < 4 ? 0 : 4;
        EXPECT_TRUE(triangle == meshes[t / 4].triangles[t % 4] + Int3({before, before, before}));
    }
}

TEST(MeshFile, NoMeshesMakeAValidFileOfEachKind)
{
    const Folder place;
    Mesh empty;
    for (const std::vector<Mesh>& none : {std::vector<Mesh>{}, std::vector<Mesh>{empty}}) {
        write_mesh(place / "none.glb", none);
        write_mesh(place / "none.obj", none);
        write_mesh(place / "none.ply", none);
        tinygltf::TinyGLTF reader;
        tinygltf::Model model;
        std::string error, warning;
        EXPECT_TRUE(reader.LoadBinaryFromFile(&model, &error, &warning, place / "none.glb"));
        EXPECT_EQ(error, "");
        EXPECT_TRUE(model.meshes.empty());
        EXPECT_NE(text_of(place / "none.ply").find("element vertex 0\n"), std::string::npos);
    }
}

TEST(MeshFile, UnknownEndingIsNamedAndNothingIsWritten)
{
    const Folder place;
    for (const char* const name : {"clay.fbx", "clay", "folder.glb/clay", ".", ""}) {
        const std::string path = place / name;
        EXPECT_EQ(error_of(path, pair_of_meshes()),
                  path + ": a mesh is written as .glb, .obj, .ply, .stl or .3mf");
    }
    EXPECT_EQ(place.files(), 0);
}

TEST(MeshFile, PlaceThatCannotBeWrittenIsNamedWithTheReason)
{
    const Folder place;
    const std::string missing = place / "nowhere/clay.glb";
    EXPECT_EQ(error_of(missing, pair_of_meshes()),
              missing + ": cannot be written: No such file or directory");
    fs::create_directories(place.path() / "folder.ply" / "full");
    const std::string folder = place / "folder.ply";
    EXPECT_EQ(error_of(folder, pair_of_meshes()), folder + ": cannot be written: Is a directory");
    EXPECT_EQ(place.files(), 1);
    const std::string system = "/proc/clay.obj";
    EXPECT_EQ(error_of(system, pair_of_meshes()).rfind(system + ": cannot be written: ", 0), 0u);
}

TEST(MeshFile, ReadOnlyFolderIsNamedWithTheReason)
{
    if (geteuid() == 0) GTEST_SKIP() << "root may write into any folder";
    const Folder place;
    const std::string path = place / "clay.ply";
    fs::permissions(place.path(), fs::perms::owner_read | fs::perms::owner_exec);
    const std::string error = error_of(path, pair_of_meshes());
    fs::permissions(place.path(), fs::perms::owner_all);
    EXPECT_EQ(error, path + ": cannot be written: Permission denied");
}

TEST(MeshFile, DiskThatRunsFullLeavesTheOldFileAndNoHalfOne)
{
    const Folder place;
    const std::string path = place / "clay.ply";
    write_mesh(path, pair_of_meshes());
    const std::string old = text_of(path);
    Mesh large = tetrahedron(1, 0);
    large.triangles.resize(100000);
    std::string error;
    {
        const SmallDisk full(100000);
        error = error_of(path, {large});
    }
    EXPECT_EQ(error, path + ": cannot be written: File too large");
    EXPECT_EQ(text_of(path), old);
    EXPECT_EQ(place.files(), 1);
}

TEST(MeshFile, BrokenMeshIsRefusedBeforeAnythingIsWritten)
{
    const Folder place;
    const std::string path = place / "clay.glb";
    Mesh torn = tetrahedron(3, 0);
    torn.triangles[2].y = 4;
    EXPECT_EQ(error_of(path, {torn}),
              path + ": the mesh of category 3 has a triangle with a vertex that is not there");
    Mesh bare = tetrahedron(3, 0);
    bare.normals.pop_back();
    EXPECT_EQ(error_of(path, {bare}),
              path + ": the mesh of category 3 has 4 vertices but 3 normals");
    Mesh wild = tetrahedron(3, 0);
    wild.vertices[1].z = NAN;
    EXPECT_EQ(error_of(path, {wild}),
              path + ": the mesh of category 3 has a vertex or normal that is not finite");
    EXPECT_EQ(place.files(), 0);
}

}  // namespace
}  // namespace knead
