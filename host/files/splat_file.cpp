#include "host/files/splat_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numeric>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/files/byte_window.h"
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

void check_any(const SplatFile& file, const std::string& path)
{
    if (file.cloud.count() == 0)
        throw InputError(path + ": expected splats, found " +
                         (file.repairs.dropped() == 0
                              ? std::string("none")
                              : fmt::format("{}, none of which can be drawn: {} with a number that "
                                            "is not finite, {} without a rotation",
                                            file.repairs.dropped(), file.repairs.not_finite,
                                            file.repairs.no_rotation)));
}

SplatFile SplatGather::gathered(const std::string& path)
{
    check_any(file, path);
    return std::move(file);
}

std::vector<std::uint32_t> order_by_place(const SplatCloud& cloud)
{
    Box3<float> box{cloud.centre.at(0), cloud.centre[0]};
    for (const Vec3<float>& x : cloud.centre) grow(box, x);
    const Vec3<float> size = edges(box);
    const auto spread = [](float from, float x, float edge) {
        std::uint32_t v =
            edge > 0 ? std::uint32_t(std::clamp(1024 * ((x - from) / edge), 0.0f, 1023.0f)) : 0;
        v = (v | v << 16) & 0x030000ffu;
        v = (v | v << 8) & 0x0300f00fu;
        v = (v | v << 4) & 0x030c30c3u;
        return (v | v << 2) & 0x09249249u;
    };
    std::vector<std::uint32_t> keys(cloud.count()), order(cloud.count());
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const Vec3<float> x = cloud.centre[i];
        keys[i] = spread(box.low.x, x.x, size.x) | spread(box.low.y, x.y, size.y) << 1 |
                  spread(box.low.z, x.z, size.z) << 2;
    }
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    return order;
}

void drop_not_finite(SplatFile& file, const std::string& path)
{
    SplatCloud& c = file.cloud;
    const auto stride = std::size_t(harmonics(c.degree));
    std::size_t kept = 0;
    for (std::size_t i = 0; i < c.count(); ++i) {
        bool good = finite(c.centre[i]) && finite(c.scale[i]) && std::isfinite(c.opacity[i]);
        for (std::size_t k = 0; k < stride; ++k) good = good && finite(c.sh[i * stride + k]);
        if (!good) {
            ++file.repairs.not_finite;
            continue;
        }
        if (kept < i) set_splat(c, kept, c, i);
        ++kept;
    }
    resize(c, kept);
    check_any(file, path);
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
    return parse_splat(ByteWindow(bytes), path);
}

SplatFile parse_splat(const ByteWindow& bytes, const std::string& path)
{
    if (bytes.size() % sizeof(SplatRow) != 0)
        throw InputError(fmt::format("{}: expected rows of {} bytes, found {} bytes after the last",
                                     path, sizeof(SplatRow), bytes.size() % sizeof(SplatRow)));
    const std::size_t count = bytes.size() / sizeof(SplatRow);
    SplatGather gather("splat", 0);
    gather.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const SplatRow row = bytes.at<SplatRow>(i * sizeof(SplatRow));
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

void write_dot_splat(const SplatCloud& cloud, const AddBytes& add)
{
    constexpr std::size_t part_bytes = 4 << 20;
    std::string part;
    const std::size_t stride = std::size_t(harmonics(cloud.degree));
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> x = cloud.centre[i], s = cloud.scale[i], dc = cloud.sh[i * stride];
        const Quat<float> q = cloud.rotation[i];
        const auto colour = [](float c) { return byte(255 * (0.5 + sh_constant * double(c))); };
        const auto of_rotation = [](float c) { return byte(128 + 128 * double(c)); };
        const SplatRow row{
            {x.x, x.y, x.z},
            {s.x, s.y, s.z},
            {colour(dc.x), colour(dc.y), colour(dc.z), byte(255 * double(cloud.opacity[i]))},
            {of_rotation(q.w), of_rotation(q.x), of_rotation(q.y), of_rotation(q.z)}};
        part.append(reinterpret_cast<const char*>(&row), sizeof row);
        if (part.size() < part_bytes) continue;
        add(part);
        part.clear();
    }
    add(part);
}

std::string splat_bytes(const SplatCloud& cloud)
{
    std::string all;
    all.reserve(cloud.count() * sizeof(SplatRow));
    write_dot_splat(cloud, [&](const std::string& part) { all += part; });
    return all;
}

void refuse_unread_splats(const std::string& path, const std::string& start)
{
    const std::string form = ending(path);
    const auto refuse = [&](const char* format, const char* why) {
        throw InputError(fmt::format("{}: {} is not read: {}", path, format, why));
    };
    if (form == ".splatv" || start.starts_with(std::string_view("\x4b\x67\0\0", 4)))
        refuse(".splatv", "its splats move; export one point in time as .ply");
    if (form == ".lcc" || form == ".lcc2" || ending(path) == ".lci")
        refuse(".lcc (XGRIDS)", "export the scene as .ply");
}

SplatFile parse_splats(std::string bytes, const std::string& path)
{
    refuse_unread_splats(path, bytes);
    const std::string form = ending(path);
    if (begins_spz(bytes) || form == ".spz") return parse_spz(std::move(bytes), path);
    if (bytes.starts_with("ply") || form == ".ply") return parse_splat_ply(bytes, path);
    if (bytes.starts_with("glTF") || form == ".glb") return parse_splat_glb(bytes, path);
    if (form == ".splat") return parse_splat(bytes, path);
    if (form == ".ksplat") return parse_ksplat(bytes, path);
    if (form == ".sog") return parse_sog(bytes, path);
    throw InputError(
        path + ": expected splats: PLY, SPZ, glTF, or a file ending in .splat, .ksplat or .sog");
}

SplatFile read_splats(const std::string& path)
{
    if (is_sog_folder(path)) return read_sog_folder(path);
    if (std::optional<SplatFile> plain = read_plain_splat_ply(path)) return std::move(*plain);
    std::error_code none;
    if (!is_standard(path) && std::filesystem::is_regular_file(path, none)) {
        const std::string start = read_start(path, 4), form = ending(path);
        const auto window = [&] {
            auto file = std::make_shared<const OpenFile>(path);
            if (file->size() > max_file_bytes)
                throw InputError(fmt::format("{}: expected at most {} bytes, found {}", path,
                                             max_file_bytes, file->size()));
            return ByteWindow(std::move(file));
        };
        const bool named = !start.starts_with("ply") && !begins_spz(start);
        if (named && start.starts_with("glTF")) return parse_splat_glb(window(), path);
        if (named && form == ".splat") return parse_splat(window(), path);
        if (named && form == ".ksplat") return parse_ksplat(window(), path);
    }
    return parse_splats(read_text(path, max_file_bytes), path);
}

void write_splats(const std::string& path, const SplatCloud& cloud, int spz_version)
{
    const std::string form = ending(path);
    if (path.ends_with(".compressed.ply"))
        return write_whole(path, compressed_ply_bytes(cloud, path));
    if (form == ".ply")
        return write_in_parts(path, [&](const AddBytes& add) { write_splat_ply(cloud, add); });
    if (form == ".splat")
        return write_in_parts(path, [&](const AddBytes& add) { write_dot_splat(cloud, add); });
    if (form == ".spz")
        return write_in_parts(
            path, [&](const AddBytes& add) { write_spz(cloud, path, spz_version, add); });
    if (form == ".glb")
        return write_in_parts(path,
                              [&](const AddBytes& add) { write_splat_glb(cloud, path, add); });
    if (form == ".sog") return write_whole(path, sog_bytes(cloud, path));
    throw InputError(path + ": expected .ply, .splat, .spz, .sog or .glb for splats, found \"" +
                     form + "\"");
}

namespace {

// Ranges of a format's numbers; those of the others are as wide as floats.
struct FormatRange {
    double most_dc = HUGE_VAL, most_rest = HUGE_VAL;    // magnitudes
    double least_log = -HUGE_VAL, most_log = HUGE_VAL;  // of half axes
    bool harmonics = true, antialiased = true;
};

FormatRange range_of(const std::string& path)
{
    const std::string form = ending(path);
    // Colours from 0 to 1.
    if (form == ".splat")
        return {.most_dc = 0.5 / sh_constant, .harmonics = false, .antialiased = false};
    if (form == ".glb") return {.antialiased = false};
    // A byte each: (b / 255 - 1/2) / 0.15, (b - 128) / 128, b / 16 - 10.
    if (form == ".spz")
        return {.most_dc = 0.5 / 0.15, .most_rest = 1, .least_log = -10, .most_log = 95 / 16.0};
    if (path.ends_with(".compressed.ply"))
        return {.most_rest = 4, .least_log = -20, .most_log = 20};
    if (form == ".sog") return {.least_log = -20};
    return {};
}

}  // namespace

std::vector<std::string> losses(const SplatCloud& cloud, const std::string& path)
{
    const FormatRange range = range_of(path);
    const std::string form = path.ends_with(".compressed.ply") ? ".compressed.ply" : ending(path);
    const auto stride = std::size_t(harmonics(cloud.degree));
    const auto beyond = [](Vec3<float> v, double most) {
        return !(std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most);
    };
    std::size_t colours = 0, rests = 0, sizes = 0;
    constexpr double rounding = 1e-3;  // of a limit
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        colours += beyond(cloud.sh[i * stride], range.most_dc * (1 + rounding));
        bool far = false;
        for (std::size_t k = 1; k < stride && range.harmonics && !far; ++k)
            far = beyond(cloud.sh[i * stride + k], range.most_rest * (1 + 1 / 128.0));
        rests += far;
        const Vec3<float> s = cloud.scale[i];
        const double most = std::log(double(max(s.x, max(s.y, s.z)))),
                     least = std::log(double(min(s.x, min(s.y, s.z))));
        sizes += most > range.most_log + 1 / 32.0 || least < range.least_log - 1 / 32.0;
    }
    std::vector<std::string> lines;
    const auto say = [&](const std::string& text) { lines.push_back(text); };
    if (!range.harmonics && cloud.degree > 0)
        say("harmonics above degree 0 are left out: " + form + " has no room for them");
    if (!range.antialiased && cloud.antialiased)
        say("the mark of antialiased training is left out: " + form + " has none");
    if (colours > 0)
        say(fmt::format("{} splats have colours beyond the range of {}: cut", colours, form));
    if (rests > 0)
        say(fmt::format("{} splats have harmonics beyond the range of {}: cut", rests, form));
    if (sizes > 0)
        say(fmt::format("{} splats have half axes beyond the range of {}: cut", sizes, form));
    constexpr std::size_t palette = 65536;
    if (form == ".sog" && cloud.degree > 0 && cloud.count() > palette)
        say(fmt::format("harmonics of {} splats share {} entries of .sog", cloud.count(), palette));
    return lines;
}

}  // namespace knead
