// glTF: how much work a file may ask for, counted before any of it is done.
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/gltf.h"
#include "host/files/mesh_reader.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

std::string word(std::size_t n)
{
    const auto w = std::uint32_t(n);
    return {reinterpret_cast<const char*>(&w), sizeof w};
}

// Primitives that all name one accessor of so many vertices, the last of them of `mode`; behind the
// vertices the buffer is filled up to `size` bytes.
std::string shared_glb(int primitives, int vertices, std::size_t size, int mode = 4)
{
    std::string binary;
    for (int i = 0; i < 3 * vertices; ++i) {
        const auto x = float(i % 7);
        binary.append(reinterpret_cast<const char*>(&x), sizeof x);
    }
    binary.resize(std::max(size, binary.size()));
    Json parts = Json::array();
    for (int i = 0; i < primitives; ++i) parts.push_back({{"attributes", {{"POSITION", 0}}}});
    parts.back()["mode"] = mode;
    const Json all = {
        {"asset", {{"version", "2.0"}}},
        {"buffers", {{{"byteLength", binary.size()}}}},
        {"bufferViews", {{{"buffer", 0}, {"byteLength", binary.size()}}}},
        {"accessors",
         {{{"bufferView", 0}, {"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}}}},
        {"meshes", {{{"name", "category 7"}, {"primitives", parts}}}}};
    std::string text = all.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::string body =
        word(text.size()) + "JSON" + text + word(binary.size()) + std::string("BIN\0", 4) + binary;
    return "glTF" + word(2) + word(12 + body.size()) + body;
}

std::string refused(const std::string& bytes)
{
    return reason<InputError>([&] { parse_gltf(bytes, "x.glb", GltfSkins::ignored); });
}

// The last primitive is broken, too: had any been read, up to there, that would be said.
TEST(GltfBounds, PrimitivesThatShareAnAccessorAreCountedBeforeAnyIsRead)
{
    const std::string bytes = shared_glb(20000, 900, 3000000, 7);
    ASSERT_GT(bytes.size(), 3000000u);
    // A vertex is three numbers, and a corner where there are no indices.
    const std::size_t each = 900 * (3 + 3) * sizeof(double);
    EXPECT_EQ(refused(bytes),
              "x.glb: /meshes: expected at most " + std::to_string(64 * bytes.size()) +
                  " bytes of numbers, 64 times the file, found " + std::to_string(20000 * each));
}

TEST(GltfBounds, SharingWithinTheBoundIsRead)
{
    const std::string bytes = shared_glb(300, 30, 0);
    ASSERT_EQ(refused(bytes), "");
    const std::vector<FileMesh> meshes = parse_glb(bytes, "x.glb").meshes;
    ASSERT_EQ(meshes.size(), 300u);
    for (const FileMesh& m : {meshes.front(), meshes.back()}) {
        EXPECT_EQ(m.vertices.size(), 30u);
        EXPECT_EQ(m.category, 7);
    }
}

TEST(GltfBounds, ThereAreAtMost65536Primitives)
{
    EXPECT_EQ(refused(shared_glb(sanitized ? 1024 : 65536, 3, 0)), "");
    EXPECT_EQ(refused(shared_glb(65537, 3, 0)),
              "x.glb: /meshes: expected at most 65536 primitives in all, found 65537");
}

}  // namespace
}  // namespace knead
