// Splats as glTF, KHR_gaussian_splatting: points with the attributes of splats. Viewers without the
// extension draw the points.  [Khronos 2026]
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/files/glb.h"
#include "host/files/splat_axes.h"
#include "host/files/splat_file.h"

namespace knead {
namespace {

using Json = nlohmann::json;
constexpr const char* extension = "KHR_gaussian_splatting";

// Linear value of an sRGB channel.  IEC 61966-2-1
float decoded(float s)
{
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

// The attributes of a cloud in the axes of glTF, right, up, back: half a turn about x.
class SplatAttributes {
  public:
    explicit SplatAttributes(const SplatCloud& given)
        : cloud(given), stride(std::size_t(harmonics(given.degree)))
    {
        const auto named = [](const std::string& name) {
            return std::string(extension) + ":" + name;
        };
        attribute("POSITION", 3, [&](std::size_t i, float* to) {
            put(to, axes.place(cast<double>(cloud.centre[i])));
        });
        attribute(named("ROTATION"), 4, [&](std::size_t i, float* to) {
            const Quat<double> q = axes.turn(unit(cast<double>(cloud.rotation[i])));
            to[0] = float(q.x), to[1] = float(q.y), to[2] = float(q.z), to[3] = float(q.w);
        });
        attribute(named("SCALE"), 3,
                  [&](std::size_t i, float* to) { put(to, cast<double>(cloud.scale[i])); });
        attribute(named("OPACITY"), 1, [&](std::size_t i, float* to) { *to = cloud.opacity[i]; });
        for (int l = 0, k = 0; l <= cloud.degree; ++l)
            for (int n = 0; n <= 2 * l; ++n, ++k)
                attribute(named("SH_DEGREE_" + std::to_string(l) + "_COEF_" + std::to_string(n)), 3,
                          [this, k](std::size_t i, float* to) {
                              put(to, axes.coefficient(k, [&](int j) {
                                  return cast<double>(cloud.sh[i * stride + std::size_t(j)]);
                              }));
                          });
    }

    // Fills in the views and accessors of the document; returns the primitive's attributes.
    Json describe(Json& gltf)
    {
        const std::size_t count = cloud.count();
        constexpr const char* types[] = {"", "SCALAR", "", "VEC3", "VEC4"};
        Json all;
        for (const Attribute& a : attributes) {
            const std::size_t bytes = count * a.columns * sizeof(float);
            all[a.name] = describe_accessor(gltf, size, bytes, gltf_float, types[a.columns], count,
                                            gltf_vertices);
            size += bytes;
        }
        Box3<float> box = empty_box<float>();
        for (const Vec3<float> x : cloud.centre)
            grow(box, cast<float>(axes.place(cast<double>(x))));
        Json& position = gltf["accessors"][all["POSITION"].get<std::size_t>()];
        position["min"] = {box.low.x, box.low.y, box.low.z};
        position["max"] = {box.high.x, box.high.y, box.high.z};
        const int colour =
            describe_accessor(gltf, size, 4 * count, gltf_byte, "VEC4", count, gltf_vertices);
        gltf["accessors"][std::size_t(colour)]["normalized"] = true;
        all["COLOR_0"] = colour;
        size += 4 * count;
        return all;
    }

    std::size_t bytes() const { return size; }  // once described

    void write(const AddBytes& add) const
    {
        std::string part;
        const auto each = [&](std::size_t row, auto&& append_row) {
            for (std::size_t i = 0; i < cloud.count(); ++i) {
                append_row(i);
                if (part.size() + row <= part_bytes) continue;
                add(part);
                part.clear();
            }
        };
        for (const Attribute& a : attributes)
            each(a.columns * sizeof(float), [&](std::size_t i) {
                float values[4];
                a.value(i, values);
                part.append(reinterpret_cast<const char*>(values), a.columns * sizeof(float));
            });
        each(4, [&](std::size_t i) {
            for (const std::uint8_t c : colour_of(i)) part.push_back(char(c));
        });
        add(part);
    }

  private:
    static constexpr std::size_t part_bytes = 4 << 20;
    struct Attribute {
        std::string name;
        std::size_t columns;
        std::function<void(std::size_t i, float* to)> value;
    };

    template <class Value>
    void attribute(const std::string& name, std::size_t columns, Value&& value)
    {
        attributes.push_back({name, columns, value});
    }

    static void put(float* to, Vec3<double> v)
    {
        to[0] = float(v.x), to[1] = float(v.y), to[2] = float(v.z);
    }

    // Of the point: the linear colour of degree 0, and the opacity.
    std::array<std::uint8_t, 4> colour_of(std::size_t i) const
    {
        const auto byte_of = [](float s) {
            return std::uint8_t(std::lround(255 * std::clamp(s, 0.0f, 1.0f)));
        };
        const auto channel = [&](float s) {
            return byte_of(decoded(std::clamp(0.5f + float(sh_constant) * s, 0.0f, 1.0f)));
        };
        const Vec3<float> c = cloud.sh[i * stride];
        return {channel(c.x), channel(c.y), channel(c.z), byte_of(cloud.opacity[i])};
    }

    const SplatCloud& cloud;
    const std::size_t stride;
    const SplatAxes axes{"RUB"};
    std::vector<Attribute> attributes;
    std::size_t size = 0;
};

}  // namespace

void write_splat_glb(const SplatCloud& cloud, const std::string& path, const AddBytes& add)
{
    if (cloud.count() == 0) throw InputError(path + ": expected splats, found none");
    SplatAttributes attributes(cloud);
    Json gltf = {{"asset", {{"version", "2.0"}, {"generator", "knead"}}},
                 {"extensionsUsed", {extension}},
                 {"scene", 0},
                 {"scenes", Json::array({{{"nodes", {0}}}})},
                 {"nodes", Json::array({{{"mesh", 0}, {"name", "splats"}}})}};
    const Json primitive = {
        {"attributes", attributes.describe(gltf)},
        {"mode", 0},
        {"extensions",
         {{extension, {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}}}}}};
    gltf["meshes"] = Json::array({{{"name", "splats"}, {"primitives", Json::array({primitive})}}});
    add(glb_head(std::move(gltf), attributes.bytes(), path, "try .ply"));
    attributes.write(add);
}

std::string splat_glb_bytes(const SplatCloud& cloud, const std::string& path)
{
    std::string all;
    write_splat_glb(cloud, path, [&](const std::string& part) { all += part; });
    return all;
}

}  // namespace knead
