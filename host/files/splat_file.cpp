#include "host/files/splat_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/files/splat_gather.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, ".splat is read as it lies");

// A row of a .splat file.
struct SplatRow {
    float centre[3], scale[3];
    std::uint8_t colour[4];    // RGB of degree 0, opacity
    std::uint8_t rotation[4];  // w, x, y, z, each (byte - 128) / 128
};
static_assert(sizeof(SplatRow) == 32);

bool finite(Vec3<float> v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

double norm(Quat<double> q) { return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z); }

}  // namespace

SplatGather::SplatGather(const std::string& format, int degree)
{
    file.format = format;
    file.cloud.degree = std::min(degree, max_sh_degree);
    if (degree > max_sh_degree) file.repairs.degree_left_out = degree;
}

void SplatGather::reserve(std::size_t count)
{
    SplatCloud& cloud = file.cloud;
    cloud.centre.reserve(count);
    cloud.rotation.reserve(count);
    cloud.scale.reserve(count);
    cloud.opacity.reserve(count);
    cloud.sh.reserve(count * std::size_t(harmonics(cloud.degree)));
}

bool SplatGather::accepted(const RawSplat& raw)
{
    const double length_of_q = norm(raw.rotation);
    if (!finite(cast<float>(raw.centre)) || !finite(cast<float>(raw.scale)) ||
        !std::isfinite(raw.opacity) || !std::isfinite(length_of_q)) {
        ++file.repairs.not_finite;
        return false;
    }
    if (length_of_q > 0) return true;
    ++file.repairs.no_rotation;
    return false;
}

void SplatGather::keep(const RawSplat& raw)
{
    const Vec3<double> s = raw.scale;
    if (s.x < 0 || s.y < 0 || s.z < 0) ++file.repairs.mirrored;
    SplatCloud& cloud = file.cloud;
    cloud.centre.push_back(cast<float>(raw.centre));
    cloud.rotation.push_back(cast<float>(unit(raw.rotation)));
    cloud.scale.push_back(cast<float>(Vec3<double>{std::abs(s.x), std::abs(s.y), std::abs(s.z)}));
    cloud.opacity.push_back(float(std::clamp(raw.opacity, 0.0, 1.0)));
}

SplatFile SplatGather::gathered(const std::string& path)
{
    if (file.cloud.count() == 0)
        throw InputError(path + ": expected splats, found " +
                         (file.repairs.dropped() == 0
                              ? std::string("none")
                              : fmt::format("{}, none of which can be drawn: {} with a number that "
                                            "is not finite, {} without a rotation",
                                            file.repairs.dropped(), file.repairs.not_finite,
                                            file.repairs.no_rotation)));
    return std::move(file);
}

std::vector<std::string> remarks(const SplatFile& file)
{
    const SplatRepairs& r = file.repairs;
    std::vector<std::string> lines;
    if (r.dropped())
        lines.push_back(
            fmt::format("{} splats left out that cannot be drawn: {} with a number that is not "
                        "finite, {} without a rotation",
                        r.dropped(), r.not_finite, r.no_rotation));
    if (r.mirrored)
        lines.push_back(
            fmt::format("{} splats with a negative half axis: the sign is dropped", r.mirrored));
    if (r.degree_left_out) lines.push_back("harmonics above degree 3 are left out");
    lines.insert(lines.end(), file.notes.begin(), file.notes.end());
    return lines;
}

SplatFile parse_splat(const std::string& bytes, const std::string& path)
{
    if (bytes.size() % sizeof(SplatRow) != 0)
        throw InputError(fmt::format("{}: expected rows of {} bytes, found {} bytes after the last",
                                     path, sizeof(SplatRow), bytes.size() % sizeof(SplatRow)));
    const std::size_t count = bytes.size() / sizeof(SplatRow);
    SplatGather gather("splat", 0);
    gather.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        SplatRow row;
        std::memcpy(&row, bytes.data() + i * sizeof row, sizeof row);
        const auto part = [&](int k) { return (double(row.rotation[k]) - 128) / 128; };
        const auto dc = [&](int k) { return (double(row.colour[k]) / 255 - 0.5) / sh_constant; };
        gather.add({{row.centre[0], row.centre[1], row.centre[2]},
                    {row.scale[0], row.scale[1], row.scale[2]},
                    {part(0), part(1), part(2), part(3)},
                    double(row.colour[3]) / 255},
                   [&](int) {
                       return Vec3<double>{dc(0), dc(1), dc(2)};
                   });
    }
    return gather.gathered(path);
}

std::string splat_bytes(const SplatCloud& cloud)
{
    std::string out;
    out.reserve(cloud.count() * sizeof(SplatRow));
    const std::size_t stride = std::size_t(harmonics(cloud.degree));
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> x = cloud.centre[i], s = cloud.scale[i], dc = cloud.sh[i * stride];
        const Quat<float> q = cloud.rotation[i];
        const auto colour = [](float c) { return byte(255 * (0.5 + sh_constant * double(c))); };
        const auto part = [](float c) { return byte(128 + 128 * double(c)); };
        const SplatRow row{
            {x.x, x.y, x.z},
            {s.x, s.y, s.z},
            {colour(dc.x), colour(dc.y), colour(dc.z), byte(255 * double(cloud.opacity[i]))},
            {part(q.w), part(q.x), part(q.y), part(q.z)}};
        out.append(reinterpret_cast<const char*>(&row), sizeof row);
    }
    return out;
}

SplatFile parse_splats(const std::string& bytes, const std::string& path)
{
    if (begins_spz(bytes) || ending(path) == ".spz") return parse_spz(bytes, path);
    if (bytes.starts_with("ply") || ending(path) == ".ply") return parse_splat_ply(bytes, path);
    if (ending(path) == ".splat") return parse_splat(bytes, path);
    throw InputError(path + ": expected splats: PLY, SPZ, or a file ending in .splat");
}

SplatFile read_splats(const std::string& path)
{
    return parse_splats(read_text(path, max_file_bytes), path);
}

void write_splats(const std::string& path, const SplatCloud& cloud)
{
    if (ending(path) == ".ply") return write_whole(path, splat_ply_bytes(cloud));
    if (ending(path) == ".splat") return write_whole(path, splat_bytes(cloud));
    if (ending(path) == ".spz") return write_whole(path, spz_bytes(cloud, path));
    if (ending(path) == ".glb") return write_whole(path, splat_glb_bytes(cloud, path));
    throw InputError(path + ": expected .ply, .splat, .spz or .glb for splats, found \"" +
                     ending(path) + "\"");
}

}  // namespace knead
