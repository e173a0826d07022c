// glTF: what is right is read, whoever asks; of what is not, file, place, expected and found are
// said.
#include "host/files/gltf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/assets/skin.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/files/mesh_reader.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

template <class T>
void append(std::string& bytes, const T& value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string glb(const std::string& text, const std::string& binary)
{
    const auto word = [](std::size_t n) {
        std::string w;
        append(w, std::uint32_t(n));
        return w;
    };
    std::string all = word(text.size()) + "JSON" + text;
    if (!binary.empty()) all += word(binary.size()) + std::string("BIN\0", 4) + binary;
    return "glTF" + word(2) + word(12 + all.size()) + all;
}

// A triangle of three vertices that hang on two joints: the document, and what it points into.
struct Example {
    Json json;
    std::string binary;

    Example()
    {
        for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 0.f}) append(binary, x);
        for (const int i : {0, 1, 2, 0}) append(binary, std::uint16_t(i));  // 36; the last pads
        for (int v = 0; v < 3; ++v)                                         // 44
            for (const int j : {0, 1, 0, 0}) append(binary, std::uint8_t(j));
        for (int v = 0; v < 3; ++v)  // 56
            for (const float w : {0.25f, 0.75f, 0.f, 0.f}) append(binary, w);
        for (int m = 0; m < 2; ++m)  // 104
            for (int k = 0; k < 16; ++k) append(binary, float(k % 5 == 0 ? 1 + m : 0));
        json = parse_json(R"({
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 232}],
            "bufferViews": [{"buffer": 0, "byteLength": 36},
                            {"buffer": 0, "byteLength": 8, "byteOffset": 36},
                            {"buffer": 0, "byteLength": 188, "byteOffset": 44}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
                {"bufferView": 2, "componentType": 5121, "count": 3, "type": "VEC4"},
                {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4",
                 "byteOffset": 12},
                {"bufferView": 2, "componentType": 5126, "count": 2, "type": "MAT4",
                 "byteOffset": 60}],
            "meshes": [{"name": "category 7", "primitives": [{
                "attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3}, "indices": 1}]}],
            "nodes": [{"mesh": 0}, {"name": "wrist"}, {"name": "index-finger-tip"}],
            "skins": [{"joints": [1, 2], "inverseBindMatrices": 4}]})",
                          "example");
    }
    Json& at(const std::string& pointer) { return json[Json::json_pointer(pointer)]; }
    void set_float(std::size_t byte, float value) { std::memcpy(&binary[byte], &value, 4); }
    std::string bytes() const
    {
        std::string text = json.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        return glb(text, binary);
    }
    // What is said of it; "" where it is read.
    std::string refused(GltfSkins skins = GltfSkins::read) const
    {
        try {
            parse_gltf(bytes(), "x.glb", skins);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
};

TEST(Gltf, TrianglesAndSkinsAreReadAsStored)
{
    const Gltf all = parse_gltf(Example().bytes(), "x.glb", GltfSkins::read);
    ASSERT_EQ(all.parts.size(), 1u);
    const GltfPart& part = all.parts[0];
    EXPECT_EQ(part.mesh, "category 7");
    ASSERT_EQ(part.vertices.size(), 3u);
    EXPECT_EQ(part.vertices[2].y, 2);
    ASSERT_EQ(part.triangles.size(), 1u);
    EXPECT_TRUE((part.triangles[0] == Int3{0, 1, 2}));
    EXPECT_EQ(part.joints, (std::vector<std::array<int, 4>>(3, {0, 1, 0, 0})));
    EXPECT_EQ(part.weights, (std::vector<std::array<double, 4>>(3, {0.25, 0.75, 0, 0})));
    ASSERT_EQ(all.skins.size(), 1u);
    EXPECT_EQ(all.skins[0].joints, (std::vector<std::string>{"wrist", "index-finger-tip"}));
    EXPECT_EQ(all.skins[0].inverse_bind[1][5], 2);
    const Gltf plain = parse_gltf(Example().bytes(), "x.glb", GltfSkins::ignored);
    EXPECT_TRUE(plain.skins.empty());
    EXPECT_TRUE(plain.parts[0].joints.empty());
    EXPECT_EQ(parse_glb(Example().bytes(), "x.glb").meshes[0].category, 7);
}

TEST(Gltf, IndicesMayBeOfAnySizeOrLeftOut)
{
    for (const int type : {5121, 5123, 5125, 0}) {
        Example e;
        e.binary = e.binary.substr(0, 36);
        for (const std::uint32_t i : {2, 1, 0}) {
            if (type == 5121) append(e.binary, std::uint8_t(i));
            if (type == 5123) append(e.binary, std::uint16_t(i));
            if (type == 5125) append(e.binary, i);
        }
        e.binary.resize((e.binary.size() + 3) / 4 * 4);
        e.at("/buffers/0/byteLength") = e.binary.size();
        e.at("/bufferViews/1/byteLength") = e.binary.size() - 36;
        e.at("/accessors/1/componentType") = type;
        if (type == 0) e.at("/meshes/0/primitives/0").erase("indices");
        if (type == 0) e.at("/accessors/1/componentType") = 5123;
        const Gltf all = parse_gltf(e.bytes(), "x.glb", GltfSkins::ignored);
        ASSERT_EQ(all.parts[0].triangles.size(), 1u) << type;
        EXPECT_TRUE((all.parts[0].triangles[0] == (type ? Int3{2, 1, 0} : Int3{0, 1, 2}))) << type;
    }
}

TEST(Gltf, WhatIsNotReadMayBeAnything)
{
    Example e;
    e.at("/accessors/0/extras") = {{"count", "many"}};
    e.at("/extensions") = {{"KHR_lights_punctual", {{"lights", 7}}}};
    e.at("/images") = {{{"uri", "/etc/passwd"}}, {{"bufferView", 99}, {"mimeType", "image/png"}}};
    e.at("/materials") = "none";
    e.at("/animations") = {{{"channels", 7}}};
    e.at("/nodes/0/camera") = "front";
    EXPECT_EQ(e.refused(), "");
    for (const char* extras :
         {"3", "\"text\"", "[1, 2]", "null", R"({"category": "7"})", R"({"category": -1})",
          R"({"category": 256})", R"({"category": 7.5})", R"({"category": {"category": 7}})",
          R"({"targetNames": ["smile"]})"}) {
        e.at("/meshes/0/extras") = Json::parse(extras);
        EXPECT_EQ(e.refused(), "") << extras;
        EXPECT_FALSE(parse_gltf(e.bytes(), "x.glb", GltfSkins::read).parts[0].category) << extras;
    }
    e.at("/meshes/0/extras") = {{"category", 255}, {"other", "text"}};
    EXPECT_EQ(parse_gltf(e.bytes(), "x.glb", GltfSkins::read).parts[0].category, 255);
    e.at("/skins") = 7;
    EXPECT_EQ(e.refused(GltfSkins::ignored), "");
}

struct Wrong {
    const char *pointer, *value, *said;
};

TEST(Gltf, ADocumentThatBreaksTheFormatIsNamedWithItsPlace)
{
    const Wrong all[] = {
        {"/asset/version", "2", "/asset/version: expected a text, found 2"},
        {"/asset", "[]", "/asset: expected an object, found an array of 0"},
        {"/accessors", "{}", "/accessors: expected an array, found an object"},
        {"/accessors/0", "5", "/accessors/0: expected an object, found 5"},
        {"/accessors/0/count", "\"3\"",
         "/accessors/0/count: expected a whole number below 2^32, found the text \"3\""},
        {"/accessors/0/count", "3.5",
         "/accessors/0/count: expected a whole number below 2^32, found 3.5"},
        {"/accessors/0/count", "-1",
         "/accessors/0/count: expected a whole number below 2^32, found -1"},
        {"/accessors/0/count", "18446744073709551615",
         "/accessors/0/count: expected a whole number below 2^32, found 18446744073709551615"},
        {"/accessors/0/bufferView", "4294967296",
         "/accessors/0/bufferView: expected a whole number below 2^31, found 4294967296"},
        {"/accessors/0/type", "3", "/accessors/0/type: expected a text, found 3"},
        {"/accessors/0/type", "\"VEC9\"", "/: expected glTF 2.0, found Unsupported `type`"},
        {"/bufferViews/0/byteStride", "2", "/: expected glTF 2.0, found Invalid `byteStride'"},
        {"/meshes/0/primitives", "{}", "/meshes/0/primitives: expected an array, found an object"},
        {"/meshes/0/primitives/0/attributes/POSITION", "0.5",
         "/meshes/0/primitives/0/attributes/POSITION: expected a whole number below 2^31"},
        {"/skins/0/joints/1", "\"wrist\"",
         "/skins/0/joints/1: expected a number, found the text \"wrist\""},
        {"/buffers/0/uri", "\"data:application/octet-stream;base64,AAAA\"",
         "/buffers/0/uri: expected none: the buffer inside the file, found the text"},
        {"/buffers/1", "{\"byteLength\": 232}",
         "/buffers: expected at most one, found an array of 2"},
        {"/buffers/0/byteLength", "0", "/: expected glTF 2.0, found "},
        {"/buffers/0/byteLength", "236", "/: expected glTF 2.0, found Invalid `byteLength'"},
    };
    for (const Wrong& wrong : all) {
        Example e;
        e.at(wrong.pointer) = Json::parse(wrong.value);
        EXPECT_EQ(e.refused().rfind(std::string("x.glb: ") + wrong.said, 0), 0u)
            << wrong.pointer << " = " << wrong.value << ": " << e.refused();
    }
    for (const char* required :
         {"/asset", "/asset/version", "/buffers/0/byteLength", "/bufferViews/0/buffer",
          "/bufferViews/0/byteLength", "/accessors/0/componentType", "/accessors/0/count",
          "/accessors/0/type", "/meshes/0/primitives", "/meshes/0/primitives/0/attributes",
          "/skins/0/joints", "/skins/0/inverseBindMatrices"}) {
        Example e;
        const Json::json_pointer at(required);
        e.json[at.parent_pointer()].erase(at.back());
        EXPECT_EQ(e.refused().rfind(std::string("x.glb: ") + required + ": expected ", 0), 0u)
            << required << ": " << e.refused();
    }
}

TEST(Gltf, AccessorsThatReachTooFarOrAreOfAnotherTypeAreNamed)
{
    const std::string first = "/accessors/0 (of /meshes/0/primitives/0/attributes/POSITION): ";
    const Wrong all[] = {
        {"/accessors/0/count", "4",
         "expected the 36 bytes of its view at most, found 4 elements that end at 48"},
        {"/accessors/0/count", "4294967295",
         "expected the 36 bytes of its view at most, found 4294967295 elements"},
        {"/accessors/0/byteOffset", "4", "found 3 elements that end at 40"},
        {"/accessors/0/byteOffset", "4294967295", "found 3 elements that end at 4294967331"},
        {"/bufferViews/0/byteOffset", "4294967295",
         "/bufferViews/0: expected the 232 bytes of the buffer at most"},
        {"/bufferViews/0/byteStride", "8", "expected a stride of at least 12, found 8"},
        {"/bufferViews/0/buffer", "1", "/bufferViews/0: expected the file's buffer, found 1"},
        {"/accessors/0/bufferView", "3", "expected one of 3 views, found 3"},
        {"/accessors/0/componentType", "5123", "expected VEC3 of floats, found 3 of type 5123"},
        {"/accessors/0/type", "\"VEC2\"", "expected VEC3 of floats, found 2 of type 5126"},
        {"/accessors/0/sparse",
         R"({"count": 2, "indices": {"bufferView": 1, "componentType": 5121},
             "values": {"bufferView": 0}})",
         "/sparse/indices: element 1: expected ascending numbers below 3, found 0"},
        {"/accessors/0/sparse",
         R"({"count": 1, "indices": {"bufferView": 1, "componentType": 5126},
             "values": {"bufferView": 0}})",
         "/sparse/indices: expected unsigned bytes, shorts or ints, found type 5126"},
        {"/accessors/0/sparse",
         R"({"count": 4, "indices": {"bufferView": 1, "componentType": 5121},
             "values": {"bufferView": 0}})",
         "/sparse/values: expected the 36 bytes of its view at most"},
        {"/accessors/0/sparse", R"({"count": 1, "indices": {"bufferView": 1}})",
         "/accessors/0/sparse/values: expected it, found nothing"},
        {"/accessors/1/componentType", "5126",
         "expected SCALAR of unsigned bytes, shorts or ints, found 1 of type 5126"},
        {"/accessors/1/count", "2",
         "/meshes/0/primitives/0: expected three corners a triangle, found 2"},
        {"/accessors/1/bufferView", "2", "element 0: expected a vertex below 3, found 256"},
        {"/accessors/2/count", "2", "JOINTS_0: expected one for each of 3 vertices, found 2"},
        {"/accessors/4/count", "1",
         "/skins/0/inverseBindMatrices: expected one for each of 2 joints, found 1"},
        {"/meshes/0/primitives/0/attributes/POSITION", "5",
         "/meshes/0/primitives/0/attributes/POSITION: expected one of 5 accessors, found 5"},
        {"/meshes/0/primitives/0/attributes", "{}",
         "/meshes/0/primitives/0/attributes/POSITION: expected one of 5 accessors, found none"},
        {"/meshes/0/primitives/0/mode", "1",
         "/meshes/0/primitives/0/mode: expected triangles (4), found 1"},
        {"/skins/0/joints/1", "3", "/skins/0/joints/1: expected one of 3 nodes, found 3"},
    };
    for (const Wrong& wrong : all) {
        Example e;
        e.at(wrong.pointer) = Json::parse(wrong.value);
        const std::string said = e.refused();
        EXPECT_NE(said.find(wrong.said), said.npos) << wrong.pointer << ": " << said;
        EXPECT_EQ(said.rfind("x.glb: /", 0), 0u) << said;
    }
    Example e;
    e.at("/accessors/0/count") = 4;
    EXPECT_EQ(e.refused().rfind("x.glb: " + first, 0), 0u) << e.refused();
}

TEST(Gltf, NumbersThatAreNotFiniteAreNamedWithTheirElement)
{
    for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
        Example position, weight, matrix;
        position.set_float(16, bad), weight.set_float(76, bad), matrix.set_float(108, bad);
        const std::pair<Example*, std::string> all[] = {
            {&position,
             "/accessors/0 (of /meshes/0/primitives/0/attributes/POSITION): element 1: "},
            {&weight, "/accessors/3 (of /meshes/0/primitives/0/attributes/WEIGHTS_0): element 1: "},
            {&matrix, "/accessors/4 (of /skins/0/inverseBindMatrices): element 0: "}};
        for (const auto& [example, place] : all)
            EXPECT_EQ(example->refused(),
                      "x.glb: " + place + "expected finite numbers, found " + std::to_string(bad));
    }
}

TEST(Gltf, ChunksThatEndOutsideAreNamedByTheirByte)
{
    const std::string whole = Example().bytes();
    const auto said = [&](std::size_t byte, std::uint32_t value) {
        std::string bytes = whole;
        std::memcpy(&bytes[byte], &value, 4);
        try {
            parse_gltf(bytes, "x.glb", GltfSkins::read);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    std::uint32_t json = 0;
    std::memcpy(&json, &whole[12], 4);
    EXPECT_EQ(said(0, 7), "x.glb: byte 0: expected a GLB file, found something else");
    EXPECT_EQ(said(4, 1), "x.glb: byte 4: expected version 2, found 1");
    EXPECT_EQ(said(8, 0xffffffff).rfind("x.glb: byte 8: expected the file's ", 0), 0u);
    EXPECT_EQ(said(12, 0xffffffff).rfind("x.glb: byte 12: expected a JSON chunk", 0), 0u);
    const std::string second = "x.glb: byte " + std::to_string(20 + json) + ": ";
    for (const std::uint32_t size : {240u, 236u, 233u, 0xffffffffu})
        EXPECT_EQ(said(20 + json, size).rfind(second, 0), 0u) << size;
}

// A megabyte that names its vertices a million times, or nests a million times, stays small.
TEST(Gltf, AFileCannotAskForMuchMoreThanItself)
{
    Example e;
    const Json part = e.at("/meshes/0/primitives/0");
    e.binary.resize(120012);
    e.at("/buffers/0/byteLength") = e.binary.size();
    e.at("/bufferViews/0/byteLength") = e.binary.size();
    e.at("/accessors/0/count") = 10001;
    for (int i = 0; i < 1000; ++i) e.at("/meshes/0/primitives").push_back(part);
    // 1001 times 10001 vertices of 24 bytes and 3 corners of 8.
    EXPECT_NE(e.refused(GltfSkins::ignored).find("64 times the file, found 240288048"),
              std::string::npos)
        << e.refused(GltfSkins::ignored);
    const std::string deep = R"({"asset":{"version":"2.0"},"extras":)" + std::string(1000000, '[') +
                             std::string(1000000, ']') + "}";
    try {
        parse_gltf(glb(deep, ""), "x.glb", GltfSkins::read);
        ADD_FAILURE();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "x.glb: expected at most 64 levels of nesting");
    }
}

// Whatever is cut off, flipped or exchanged: an answer or an InputError.
TEST(Gltf, BrokenBytesEndInAMessage)
{
    const std::string whole = Example().bytes();
    long refused = 0, read = 0;
    const auto tried = [&](const std::string& bytes) {
        try {
            parse_gltf(bytes, "x.glb", GltfSkins::read);
            ++read;
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).rfind("x.glb: ", 0), 0u) << e.what();
            ++refused;
        }
    };
    for (std::size_t cut = 0; cut < whole.size(); ++cut) tried(whole.substr(0, cut));
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const int flip : {1, 0x10, 0x80, 0xff}) {
            std::string bytes = whole;
            bytes[at] = char(bytes[at] ^ flip);
            tried(bytes);
        }
    const Json flat = Example().json.flatten();
    for (const auto& [pointer, value] : flat.items())
        for (const char* other : {"null", "-1", "0", "1e300", "4294967295", "\"\"", "[]", "{}"}) {
            Example changed;
            changed.at(pointer) = Json::parse(other);
            tried(changed.bytes());
        }
    EXPECT_GT(refused, 2000);
    EXPECT_GT(read, 10);
}

TEST(Gltf, ASkinThatIsNoHandIsNamed)
{
    const Folder folder;
    const std::string path = folder / "hand.glb";
    const auto said = [&](const std::string& bytes) {
        write_whole(path, bytes);
        try {
            read_skin(path);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_EQ(said(Example().bytes()),
              path + ": /skins/0/joints: expected one named \"thumb-metacarpal\", found 0");
    Example bare;
    bare.at("/meshes/0/primitives/0/attributes") = {{"POSITION", 0}};
    EXPECT_EQ(said(bare.bytes()), path + ": /meshes/0/primitives/0: expected JOINTS_0, found none");
    bare.json.erase("skins");
    EXPECT_EQ(said(bare.bytes()),
              path + ": expected one skin and one mesh of one part, found 0 and 1");
    EXPECT_EQ(said("glTF"), path + ": byte 0: expected a GLB file, found something else");
}

TEST(Gltf, ATransformThatIsNoneIsRefused)
{
    for (const char* kind : {"matrix", "translation", "rotation", "scale"}) {
        Example e;
        e.at(std::string("/nodes/0/") + kind) = {1, 0};
        EXPECT_NE(reason<InputError>([&] {
                      parse_glb(e.bytes(), "x.glb");
                  }).find(std::string("x.glb: /nodes/0/") + kind + ": expected"),
                  std::string::npos)
            << kind;
    }
}

}  // namespace
}  // namespace knead
