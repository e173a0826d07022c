// Splats as glTF: what another reader finds in the file.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/files/splat_file.h"

namespace knead {
namespace {

using Json = nlohmann::json;

// Of a cloud with different numbers everywhere.
SplatCloud some_cloud(int degree, std::size_t count = 50)
{
    SplatCloud c;
    c.degree = degree;
    const auto wave = [](std::size_t i, double step) { return float(std::sin(double(i) * step)); };
    for (std::size_t i = 0; i < count; ++i) {
        c.centre.push_back({wave(i, 1), wave(i, 2), wave(i, 3)});
        c.rotation.push_back(unit(Quat<float>{1, wave(i, 4), wave(i, 5), wave(i, 6)}));
        c.scale.push_back({0.01f + 0.001f * float(i), 0.02f, 0.03f});
        c.opacity.push_back(0.5f + 0.5f * wave(i, 7));
        for (int k = 0; k < harmonics(degree); ++k)
            c.sh.push_back({wave(i, k + 0.1), wave(i, k + 0.2), wave(i, k + 0.3)});
    }
    return c;
}

struct Document {
    Json gltf;
    std::string binary;
};
std::uint32_t word(const std::string& bytes, std::size_t at)
{
    std::uint32_t w;
    std::memcpy(&w, bytes.data() + at, 4);
    return w;
}
Document parsed(const std::string& bytes)
{
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(bytes, 4), 2u);
    EXPECT_EQ(word(bytes, 8), bytes.size());
    const std::size_t text = word(bytes, 12), binary = word(bytes, 20 + text);
    EXPECT_EQ(text % 4 + binary % 4, 0u);
    EXPECT_EQ(bytes.size(), 28 + text + binary);
    return {Json::parse(bytes.substr(20, text)), bytes.substr(28 + text)};
}
// The floats of an attribute.
std::vector<float> values(const Document& d, const std::string& name)
{
    const Json& primitive = d.gltf["meshes"][0]["primitives"][0];
    const Json& accessor = d.gltf["accessors"][primitive["attributes"].at(name).get<std::size_t>()];
    const Json& view = d.gltf["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::size_t size = view["byteLength"], from = view["byteOffset"];
    EXPECT_EQ(accessor["componentType"], 5126) << name;
    EXPECT_LE(from + size, d.binary.size());
    std::vector<float> all(size / 4);
    std::memcpy(all.data(), d.binary.data() + from, size);
    const std::size_t each = accessor["type"] == "SCALAR" ? 1 : accessor["type"] == "VEC3" ? 3 : 4;
    EXPECT_EQ(all.size(), each * accessor["count"].get<std::size_t>()) << name;
    return all;
}
const std::string splatting = "KHR_gaussian_splatting";

TEST(SplatGlb, HasWhatTheExtensionAsksFor)
{
    for (int degree = 0; degree <= 3; ++degree) {
        const SplatCloud cloud = some_cloud(degree);
        const Document d = parsed(splat_glb_bytes(cloud, "a.glb"));
        EXPECT_EQ(d.gltf["asset"]["version"], "2.0");
        EXPECT_EQ(d.gltf["extensionsUsed"], Json::array({splatting}));
        EXPECT_EQ(d.gltf["scenes"][0]["nodes"], Json::array({0}));
        EXPECT_EQ(d.gltf["buffers"][0]["byteLength"], d.binary.size());
        const Json& primitive = d.gltf["meshes"][0]["primitives"][0];
        EXPECT_EQ(primitive["mode"], 0);
        EXPECT_EQ(primitive["extensions"][splatting]["kernel"], "ellipse");
        EXPECT_EQ(primitive["extensions"][splatting]["colorSpace"], "srgb_rec709_display");
        EXPECT_EQ(primitive["attributes"].size(), 5u + std::size_t(harmonics(degree)));
        EXPECT_EQ(values(d, splatting + ":OPACITY"), cloud.opacity);
        const std::vector<float> q = values(d, splatting + ":ROTATION");
        for (std::size_t i = 0; i < q.size(); i += 4)
            EXPECT_NEAR(
                q[i] * q[i] + q[i + 1] * q[i + 1] + q[i + 2] * q[i + 2] + q[i + 3] * q[i + 3], 1,
                1e-6);
        for (const float s : values(d, splatting + ":SCALE")) EXPECT_GE(s, 0);
        const std::vector<float> first = values(d, splatting + ":SH_DEGREE_0_COEF_0");
        EXPECT_NEAR(first[3], cloud.sh[std::size_t(harmonics(degree))].x, 1e-6);
    }
}

// glTF's y points up where that of clouds points down: half a turn about x, of all that turns.
TEST(SplatGlb, StandsUpright)
{
    const SplatCloud cloud = some_cloud(3);
    const Document d = parsed(splat_glb_bytes(cloud, "a.glb"));
    const std::vector<float> x = values(d, "POSITION"), q = values(d, splatting + ":ROTATION"),
                             s = values(d, splatting + ":SCALE");
    const Json& position =
        d.gltf["accessors"]
              [d.gltf["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
    const Quat<double> turn{0, 1, 0, 0};
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> c = cloud.centre[i];
        EXPECT_EQ((std::array{x[3 * i], x[3 * i + 1], x[3 * i + 2]}),
                  (std::array{c.x, -c.y, -c.z}));
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_LE(position["min"][k].get<float>(), x[3 * i + k]);
            EXPECT_GE(position["max"][k].get<float>(), x[3 * i + k]);
        }
        const Ellipsoid<double> written{{q[4 * i + 3], q[4 * i], q[4 * i + 1], q[4 * i + 2]},
                                        {s[3 * i], s[3 * i + 1], s[3 * i + 2]}};
        const Ellipsoid<double> turned{turn * cast<double>(cloud.rotation[i]),
                                       cast<double>(cloud.scale[i])};
        const Sym3<double> a = covariance(written), b = covariance(turned);
        EXPECT_NEAR(a.xx, b.xx, 1e-9);
        EXPECT_NEAR(a.yz, b.yz, 1e-9);
        EXPECT_NEAR(a.xy, b.xy, 1e-9);
        // The colour in a direction is that in the direction turned along.
        const Vec3<double> direction{0.48, 0.6, -0.64};
        const auto own = [&](int k) { return cast<double>(cloud.sh[16 * i + std::size_t(k)]); };
        const auto in_file = [&](int k) {
            const int l = k == 0 ? 0 : k < 4 ? 1 : k < 9 ? 2 : 3;
            const std::vector<float> all = values(d, splatting + ":SH_DEGREE_" + std::to_string(l) +
                                                         "_COEF_" + std::to_string(k - l * l));
            return Vec3<double>{all[3 * i], all[3 * i + 1], all[3 * i + 2]};
        };
        if (i % 10) continue;
        const Vec3<double> was = sh_colour(3, direction, own),
                           is = sh_colour(3, rotate(turn, direction), in_file);
        EXPECT_NEAR(was.x, is.x, 1e-5);
        EXPECT_NEAR(was.z, is.z, 1e-5);
    }
}

TEST(SplatGlb, OfNoSplatsThereIsNone) { EXPECT_THROW(splat_glb_bytes({}, "a.glb"), InputError); }

}  // namespace
}  // namespace knead
