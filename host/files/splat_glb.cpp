// Splats as glTF, KHR_gaussian_splatting: points with the attributes of splats. Viewers without the
// extension draw the points.  [Khronos 2026]
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/files/glb.h"
#include "host/files/splat_file.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

using Json = nlohmann::json;
constexpr const char* extension = "KHR_gaussian_splatting";

// Linear value of an sRGB channel.  IEC 61966-2-1
float decoded(float s)
{
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

// Point colours: the linear colour of degree 0, and the opacity.
std::vector<std::uint8_t> point_colours(const SplatCloud& cloud)
{
    std::vector<std::uint8_t> colours;
    const auto stride = std::size_t(harmonics(cloud.degree));
    const auto byte = [](float s) {
        return std::uint8_t(std::lround(255 * std::clamp(s, 0.0f, 1.0f)));
    };
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> c = cloud.sh[i * stride];
        for (const float s : {c.x, c.y, c.z})
            colours.push_back(byte(decoded(std::clamp(0.5f + float(sh_constant) * s, 0.0f, 1.0f))));
        colours.push_back(byte(cloud.opacity[i]));
    }
    return colours;
}

std::vector<Vec3<float>> coefficients(const SplatCloud& cloud, int k)
{
    std::vector<Vec3<float>> own;
    const auto stride = std::size_t(harmonics(cloud.degree));
    for (std::size_t i = 0; i < cloud.count(); ++i)
        own.push_back(cloud.sh[i * stride + std::size_t(k)]);
    return own;
}

// x, y, z, w
std::vector<float> rotations(const SplatCloud& cloud)
{
    std::vector<float> all;
    for (const Quat<float>& given : cloud.rotation) {
        const Quat<float> q = unit(given);
        all.insert(all.end(), {q.x, q.y, q.z, q.w});
    }
    return all;
}

Json attributes(Glb& glb, const SplatCloud& cloud)
{
    const std::size_t count = cloud.count();
    const auto vectors = [&](const std::vector<Vec3<float>>& values) {
        return add_accessor(glb, values, gltf_float, "VEC3", count, gltf_vertices);
    };
    const auto named = [](const std::string& name) { return std::string(extension) + ":" + name; };
    Json all;
    const int position = vectors(cloud.centre);
    all["POSITION"] = position;
    Box3<float> box{cloud.centre.at(0), cloud.centre.at(0)};
    for (const Vec3<float> x : cloud.centre) grow(box, x);
    glb.gltf["accessors"][std::size_t(position)]["min"] = {box.low.x, box.low.y, box.low.z};
    glb.gltf["accessors"][std::size_t(position)]["max"] = {box.high.x, box.high.y, box.high.z};
    all[named("ROTATION")] =
        add_accessor(glb, rotations(cloud), gltf_float, "VEC4", count, gltf_vertices);
    all[named("SCALE")] = vectors(cloud.scale);
    all[named("OPACITY")] =
        add_accessor(glb, cloud.opacity, gltf_float, "SCALAR", count, gltf_vertices);
    for (int l = 0, k = 0; l <= cloud.degree; ++l)
        for (int n = 0; n <= 2 * l; ++n, ++k)
            all[named("SH_DEGREE_" + std::to_string(l) + "_COEF_" + std::to_string(n))] =
                vectors(coefficients(cloud, k));
    const int colour =
        add_accessor(glb, point_colours(cloud), gltf_byte, "VEC4", count, gltf_vertices);
    glb.gltf["accessors"][std::size_t(colour)]["normalized"] = true;
    all["COLOR_0"] = colour;
    return all;
}

}  // namespace

std::string splat_glb_bytes(const SplatCloud& given, const std::string& path)
{
    if (given.count() == 0) throw InputError(path + ": expected splats, found none");
    // glTF axes: right, up, back.
    const SplatCloud cloud = placed(given, {0, 1, 0, 0}, 1, {0, 0, 0});
    Glb glb;
    glb.gltf = {{"asset", {{"version", "2.0"}, {"generator", "knead"}}},
                {"extensionsUsed", {extension}},
                {"scene", 0},
                {"scenes", Json::array({{{"nodes", {0}}}})},
                {"nodes", Json::array({{{"mesh", 0}, {"name", "splats"}}})}};
    const Json primitive = {
        {"attributes", attributes(glb, cloud)},
        {"mode", 0},
        {"extensions",
         {{extension, {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}}}}}};
    glb.gltf["meshes"] =
        Json::array({{{"name", "splats"}, {"primitives", Json::array({primitive})}}});
    return glb_bytes(std::move(glb), path, "try .ply");
}

}  // namespace knead
