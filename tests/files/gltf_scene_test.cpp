// Scenes of glTF: where their meshes are, in which forms, and what files require.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/image.h"
#include "host/files/mesh_reader.h"
#include "tests/reason.h"

namespace knead {
namespace {

template <class T>
void append(std::string& bytes, T value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A tetrahedron of volume 1/6 in the box 0..1, on one node.
struct Tetrahedron {
    Json json;
    std::string binary;

    Tetrahedron()
    {
        for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f})
            append(binary, x);
        for (const int i : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})  // 48
            append(binary, std::uint16_t(i));
        json = parse_json(R"({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48},
                            {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
            "buffers": [{"byteLength": 72}]})",
                          "example");
    }
    Json& at(const std::string& pointer) { return json[Json::json_pointer(pointer)]; }
    // A view and an accessor of what was appended since the buffer had `from` bytes.
    int add(std::size_t from, int component, int count, const char* type)
    {
        at("/bufferViews")
            .push_back({{"buffer", 0}, {"byteOffset", from}, {"byteLength", binary.size() - from}});
        at("/accessors")
            .push_back({{"bufferView", at("/bufferViews").size() - 1},
                        {"componentType", component},
                        {"count", count},
                        {"type", type}});
        return int(at("/accessors").size()) - 1;
    }
    std::string bytes() const
    {
        Json all = json;
        std::string data = binary;
        data.resize((data.size() + 3) / 4 * 4);
        all["buffers"][0]["byteLength"] = data.size();
        std::string text = all.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string body;
        append(body, std::uint32_t(text.size())), body += "JSON" + text;
        append(body, std::uint32_t(data.size())), body += std::string("BIN\0", 4) + data;
        std::string file = "glTF";
        append(file, std::uint32_t(2)), append(file, std::uint32_t(12 + body.size()));
        return file + body;
    }
    MeshFile read() const { return parse_glb(bytes(), "x.glb"); }
    std::string refused() const
    {
        return reason<InputError>([&] { read(); });
    }
};

double volume(const MeshFile& file)
{
    double sum = 0;
    for (const FileMesh& mesh : file.meshes) sum += volume(mesh);
    return sum;
}
void expect_box(const MeshFile& file, Vec3<double> low, Vec3<double> high)
{
    const Box3<double> box = box_of(file.meshes);
    EXPECT_LT(length(box.low - low), 1e-6) << box.low.x << " " << box.low.y << " " << box.low.z;
    EXPECT_LT(length(box.high - high), 1e-6) << box.high.x << " " << box.high.y;
}
void expect_plain(const Tetrahedron& of)
{
    const MeshFile file = of.read();
    EXPECT_NEAR(volume(file), 1.0 / 6, 1e-6);
    expect_box(file, {0, 0, 0}, {1, 1, 1});
}

TEST(GltfScene, NodesThatChangeNothing)
{
    expect_plain({});
    Tetrahedron identity, parts, camera, unused, two, nowhere;
    identity.at("/nodes/0/matrix") = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    parts.at("/nodes/0/translation") = {0, 0, 0};
    parts.at("/nodes/0/rotation") = {0, 0, 0, 1};
    parts.at("/nodes/0/scale") = {1, 1, 1};
    camera.at("/nodes").push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
    camera.at("/scenes/0/nodes") = {0, 1};
    unused.at("/meshes").push_back(unused.at("/meshes/0"));
    two.at("/nodes").push_back({{"mesh", 0}, {"translation", {9, 0, 0}}});
    two.at("/scenes").push_back({{"nodes", {1}}});
    nowhere.json.erase("nodes"), nowhere.json.erase("scenes"), nowhere.json.erase("scene");
    for (const Tetrahedron& one : {identity, parts, camera, unused, two, nowhere})
        expect_plain(one);
    two.at("/scene") = 1;
    expect_box(two.read(), {9, 0, 0}, {10, 1, 1});
    two.json.erase("scene");
    expect_plain(two);
}

TEST(GltfScene, TransformsAreThoseOfAllNodesAbove)
{
    Tetrahedron moved, scaled, chain, mirrored;
    moved.at("/nodes/0/translation") = {0, 1, 0};
    EXPECT_NEAR(volume(moved.read()), 1.0 / 6, 1e-9);
    expect_box(moved.read(), {0, 1, 0}, {1, 2, 1});
    scaled.at("/nodes/0/scale") = {1, 2, 3};
    EXPECT_NEAR(volume(scaled.read()), 1, 1e-9);
    expect_box(scaled.read(), {0, 0, 0}, {1, 2, 3});
    // Turned a quarter about z, then doubled, then moved far away.
    const double s = std::sqrt(0.5);
    chain.at("/nodes/0/rotation") = {0, 0, s, s};
    chain.at("/nodes").push_back({{"scale", {2, 2, 2}}, {"children", {0}}});
    chain.at("/nodes").push_back({{"translation", {5e6, 0, 0}}, {"children", {1}}});
    chain.at("/scenes/0/nodes") = {2};
    EXPECT_NEAR(volume(chain.read()), 8.0 / 6, 1e-6);
    expect_box(chain.read(), {5e6 - 2, 0, 0}, {5e6, 2, 2});
    mirrored.at("/nodes/0/scale") = {-1, 1, 1};
    EXPECT_NEAR(volume(mirrored.read()), 1.0 / 6, 1e-9) << "outwards";
    expect_box(mirrored.read(), {-1, 0, 0}, {0, 1, 1});
    mirrored.at("/nodes/0/skin") = 0;
    expect_plain(mirrored);
}

TEST(GltfScene, InstancesAreSeveralMeshes)
{
    Tetrahedron twice, instanced;
    twice.at("/nodes").push_back({{"mesh", 0}, {"translation", {3, 0, 0}}});
    twice.at("/scenes/0/nodes") = {0, 1};
    EXPECT_NEAR(volume(twice.read()), 1.0 / 3, 1e-9);
    expect_box(twice.read(), {0, 0, 0}, {4, 1, 1});
    const std::size_t from = instanced.binary.size();
    for (const float x : {0.f, 0.f, 0.f, 3.f, 0.f, 0.f, 0.f, 5.f, 0.f}) append(instanced.binary, x);
    const int places = instanced.add(from, 5126, 3, "VEC3");
    const std::size_t turns = instanced.binary.size();
    for (const int q : {0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127})
        append(instanced.binary, std::int8_t(q));
    const int rotations = instanced.add(turns, 5120, 3, "VEC4");
    instanced.at("/accessors/" + std::to_string(rotations))["normalized"] = true;
    instanced.at("/nodes/0")["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", places}, {"ROTATION", rotations}};
    instanced.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    EXPECT_NEAR(volume(instanced.read()), 0.5, 1e-9);
    expect_box(instanced.read(), {0, 0, 0}, {4, 6, 1});
    instanced.at("/accessors/" + std::to_string(rotations))["count"] = 2;
    EXPECT_NE(instanced.refused().find("one for each of 3 instances"), std::string::npos);
}

TEST(GltfScene, QuantisedAndSparseAccessors)
{
    Tetrahedron shorts;
    const std::size_t from = shorts.binary.size();
    for (const int x : {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0})
        append(shorts.binary, std::uint16_t(x));
    const int position = shorts.add(from, 5123, 4, "VEC3");
    shorts.at("/bufferViews/2/byteStride") = 8;
    shorts.at("/meshes/0/primitives/0/attributes/POSITION") = position;
    shorts.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    expect_plain(shorts);
    // The same normalised, which the node undoes.
    shorts.at("/accessors/2/normalized") = true;
    shorts.at("/nodes/0/scale") = {65535, 65535, 65535};
    expect_plain(shorts);
    // Of no view, and of one: the vertices 1 and 3 are replaced.
    Tetrahedron sparse;
    const std::size_t at = sparse.binary.size();
    append(sparse.binary, std::uint16_t(1)), append(sparse.binary, std::uint16_t(3));
    sparse.add(at, 5123, 2, "SCALAR");
    const std::size_t values = sparse.binary.size();
    for (const float x : {2.f, 0.f, 0.f, 0.f, 0.f, 3.f}) append(sparse.binary, x);
    sparse.add(values, 5126, 2, "VEC3");
    const Json replaced = {{"count", 2},
                           {"indices", {{"bufferView", 2}, {"componentType", 5123}}},
                           {"values", {{"bufferView", 3}}}};
    sparse.at("/accessors/0/sparse") = replaced;
    EXPECT_NEAR(volume(sparse.read()), 1, 1e-9);
    expect_box(sparse.read(), {0, 0, 0}, {2, 1, 3});
    sparse.at("/accessors/0").erase("bufferView");
    expect_box(sparse.read(), {0, 0, 0}, {2, 0, 3});
    sparse.at("/accessors/0/count") = 4000000000u;
    EXPECT_NE(sparse.refused(), "");
}

TEST(GltfScene, StripsFansAndWhatHasNoTriangles)
{
    Tetrahedron strip, lines;
    strip.at("/meshes/0/primitives/0/mode") = 5;
    ASSERT_EQ(strip.read().meshes.at(0).triangles.size(), 10u);
    EXPECT_TRUE((strip.read().meshes[0].triangles[1] == Int3{2, 0, 1}));
    EXPECT_NEAR(volume(strip.read()), 0, 1e-12);
    strip.at("/meshes/0/primitives/0/mode") = 6;
    EXPECT_TRUE((strip.read().meshes[0].triangles[0] == Int3{2, 1, 0}));
    lines.at("/meshes/0/primitives").push_back({{"mode", 1}, {"attributes", {{"POSITION", 0}}}});
    expect_plain(lines);
    EXPECT_EQ(lines.read().notes.at(0), "1 primitives of points or lines left out");
    lines.at("/meshes/0/primitives").erase(0);
    EXPECT_NE(lines.refused().find("expected triangles"), std::string::npos);
}

TEST(GltfScene, ColoursOfVerticesAndMaterialsAreMultiplied)
{
    Tetrahedron of;
    EXPECT_TRUE(of.read().meshes[0].colours.empty());
    of.json["materials"] =
        Json::parse(R"([{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1]}}])");
    of.at("/meshes/0/primitives/0/material") = 0;
    ASSERT_EQ(of.read().meshes[0].colours.size(), 4u);
    EXPECT_FLOAT_EQ(of.read().meshes[0].colours[2].z, 0.25f);
    const std::size_t from = of.binary.size();
    for (int v = 0; v < 4; ++v)
        for (const int c : {51, 255, 102, 255}) append(of.binary, std::uint8_t(c));
    const int colour = of.add(from, 5121, 4, "VEC4");
    of.at("/accessors/2/normalized") = true;
    of.at("/meshes/0/primitives/0/attributes/COLOR_0") = colour;
    const Vec3<float> c = of.read().meshes[0].colours.at(3);
    EXPECT_NEAR(c.x, 0.2, 1e-6);
    EXPECT_NEAR(c.y, 0.5, 1e-6);
    EXPECT_NEAR(c.z, 0.1, 1e-6);
    of.at("/accessors/2/count") = 3;
    EXPECT_NE(of.refused().find("COLOR_0: expected one for each of 4 vertices"), std::string::npos);
}

TEST(GltfScene, TexturesColourTheVertices)
{
    Tetrahedron of;
    of.at("/meshes/0/primitives/0/material") = 0;
    of.json["materials"] = Json::parse(
        R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
                                      "baseColorFactor": [1, 1, 0.5, 1]}}])");
    of.json["textures"] = Json::parse(R"([{"source": 0, "sampler": 0}])");
    of.json["samplers"] = Json::parse(R"([{"wrapS": 33071}])");
    const std::size_t from = of.binary.size();
    for (const float uv : {0.1f, 0.5f, 0.9f, 0.5f, 7.f, 2.5f, -7.f, 0.5f}) append(of.binary, uv);
    of.at("/meshes/0/primitives/0/attributes/TEXCOORD_0") = of.add(from, 5126, 4, "VEC2");
    const std::size_t picture = of.binary.size();
    of.binary += png_bytes({2, 1, {255, 0, 0, 0, 255, 255}});
    of.add(picture, 5121, 1, "SCALAR");
    of.at("/accessors").erase(3);
    of.json["images"] = {{{"bufferView", 3}, {"mimeType", "image/png"}}};
    const MeshFile file = of.read();
    EXPECT_EQ(file.notes.at(0), "colours of textures are those at the vertices");
    const auto& c = file.meshes[0].colours;
    ASSERT_EQ(c.size(), 4u);
    for (const int red : {0, 3}) EXPECT_EQ(c[std::size_t(red)].x, 1);
    for (const int cyan : {1, 2}) {
        EXPECT_EQ(c[std::size_t(cyan)].x, 0);
        EXPECT_EQ(c[std::size_t(cyan)].y, 1);
        EXPECT_NEAR(c[std::size_t(cyan)].z, 0.5, 1e-6);
    }
    of.json["images"] = {{{"uri", "a b.png"}}};
    EXPECT_NE(of.read().notes.at(0).find("1 textures left out"), std::string::npos);
    EXPECT_FLOAT_EQ(of.read().meshes[0].colours.at(0).z, 0.5f);
}

TEST(GltfScene, RequiredExtensionsAreKnownOrRefusedByName)
{
    const auto said = [](const std::string& name) {
        Tetrahedron of;
        of.json["extensionsRequired"] = {name};
        return of.refused();
    };
    for (const char* name : {"KHR_mesh_quantization", "KHR_materials_unlit", "KHR_lights_punctual"})
        EXPECT_EQ(said(name), "");
    EXPECT_EQ(said("VENDOR_foo"),
              "x.glb: /extensionsRequired/0: expected no extension that is not known here, found "
              "VENDOR_foo");
    for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}) {
        EXPECT_NE(said(name).find(name), std::string::npos);
        EXPECT_NE(said(name).find("gltf-transform"), std::string::npos);
    }
}

TEST(GltfScene, NodesThatAreNoTreeAreRefused)
{
    Tetrahedron circle, many;
    circle.at("/nodes/0/children") = {0};
    EXPECT_NE(circle.refused().find("a circle"), std::string::npos);
    circle.at("/nodes/0/children") = {7};
    EXPECT_NE(circle.refused().find("one of 1 nodes"), std::string::npos);
    circle.at("/nodes/0").erase("children");
    circle.at("/nodes/0/mesh") = 7;
    EXPECT_NE(circle.refused().find("one of 1 meshes"), std::string::npos);
    circle.at("/nodes/0/mesh") = 0, circle.at("/scene") = 3;
    EXPECT_NE(circle.refused().find("one of 1 scenes"), std::string::npos);
    // Each level doubles the places.
    for (int i = 0; i < 40; ++i) many.at("/nodes").push_back({{"children", {i, i}}});
    many.at("/scenes/0/nodes") = {40};
    EXPECT_NE(many.refused(), "");
}

}  // namespace
}  // namespace knead
