// Compressed splat PLY of SuperSplat and PlayCanvas: chunks of 256 splats, each with the bounds of
// its values, and four packed words a splat. docs/reference/formats.md.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/files/splat_gather.h"
#include "host/files/splat_ply_dialect.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "packed words are read as they lie");

constexpr std::size_t chunk_size = 256;  // splats
constexpr double largest_log = 20;       // of half axes, as writers clamp them
constexpr const char* bounds_names[] = {
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
constexpr const char* word_names[] = {"packed_position", "packed_rotation", "packed_scale",
                                      "packed_color"};

// The rows of an element: fixed size, little-endian, inside the file.
struct PackedRows {
    const char* first = nullptr;
    std::size_t rows = 0, stride = 0;

    template <class T>
    T at(std::size_t row, std::size_t offset) const
    {
        T value;
        std::memcpy(&value, first + row * stride + offset, sizeof value);
        return value;
    }
};

// Where the values of one splat's chunk lie: low + (high - low) * t.
struct Bounds3 {
    std::array<double, 3> low{0, 0, 0}, high{1, 1, 1};

    Vec3<double> between(double x, double y, double z) const
    {
        return {std::lerp(low[0], high[0], x), std::lerp(low[1], high[1], y),
                std::lerp(low[2], high[2], z)};
    }
};

class PackedReader {
  public:
    PackedReader(const std::string& all, const std::string& file)
        : bytes(all), path(file), header(parse_ply_header(all, file))
    {
        if (!header.little_endian) fail("format binary_little_endian", "another");
        std::size_t at = header.body;
        for (const PlyElement& e : header.elements) {
            PackedRows rows{bytes.data() + at, e.rows, 0};
            for (const PlyProperty& p : e.properties) {
                if (p.list) fail("no lists", "\"" + p.name + "\"");
                rows.stride += size_of(p.type);
            }
            if (rows.stride > 0 && e.rows > (bytes.size() - at) / rows.stride)
                fail(fmt::format("{} rows of \"{}\" of {} bytes", e.rows, e.name, rows.stride),
                     fmt::format("{} bytes left", bytes.size() - at));
            at += e.rows * rows.stride;
            if (e.name == "chunk") chunk = rows, find(e, PlyType::f32, bounds_names, bounds_at);
            if (e.name == "vertex") vertex = rows, find(e, PlyType::u32, word_names, word_at);
            if (e.name == "sh") sh = rows, find_sh(e);
        }
        if (at != bytes.size())
            fail("the end of the file", fmt::format("{} bytes more", bytes.size() - at));
        // Without a colour box, colours are stored as they are.
        coloured = bounds_at[12] >= 0;
        require(bounds_at, coloured ? 18 : 12, bounds_names);
        require(word_at, 4, word_names);
        if (chunk.rows < (vertex.rows + chunk_size - 1) / chunk_size)
            fail(fmt::format("a chunk for each {} of {} splats", chunk_size, vertex.rows),
                 std::to_string(chunk.rows));
        if (sh_count > 0 && sh.rows != vertex.rows)
            fail(fmt::format("harmonics of {} splats", vertex.rows), std::to_string(sh.rows));
    }

    SplatFile read() const
    {
        const int degree = sh_count == 0 ? 0 : sh_count == 9 ? 1 : sh_count == 24 ? 2 : 3;
        SplatGather gather("compressed ply", degree);
        gather.reserve(vertex.rows);
        gather.file.cloud.antialiased = says_antialiased(header);
        for (std::size_t i = 0; i < vertex.rows; ++i) {
            const auto rgb = colour(i);
            gather.add(splat(i), [&](int k) -> Vec3<double> {
                if (k == 0)
                    return {(rgb.x - 0.5) / sh_constant, (rgb.y - 0.5) / sh_constant,
                            (rgb.z - 0.5) / sh_constant};
                const auto of_channel = sh_count / 3;
                const auto at = [&](std::size_t channel) {
                    const std::size_t n = channel * of_channel + std::size_t(k - 1);
                    return coefficient(sh.at<std::uint8_t>(i, std::size_t(sh_at[n])));
                };
                return {at(0), at(1), at(2)};
            });
        }
        SplatFile file = gather.gathered(path);
        file.notes = dialect_notes(header);
        return file;
    }

  private:
    [[noreturn]] void fail(const std::string& expected, const std::string& found) const
    {
        throw InputError(
            fmt::format("{}: compressed PLY: expected {}, found {}", path, expected, found));
    }

    // Offsets in a row of the named properties; -1 for those that are not there.
    template <std::size_t n>
    void find(const PlyElement& e, PlyType type, const char* const (&names)[n],
              std::array<long, n>& offsets) const
    {
        long at = 0;
        for (const PlyProperty& p : e.properties) {
            for (std::size_t k = 0; k < n; ++k)
                if (p.name == names[k]) {
                    if (p.type != type)
                        fail(fmt::format("{} for \"{}\"", type == PlyType::f32 ? "float" : "uint",
                                         p.name),
                             "another type");
                    offsets[k] = at;
                }
            at += long(size_of(p.type));
        }
    }

    void find_sh(const PlyElement& e)
    {
        for (const PlyProperty& p : e.properties) sh_count += p.name.starts_with("f_rest_");
        if (sh_count != 0 && sh_count != 9 && sh_count != 24 && sh_count != 45)
            fail("0, 9, 24 or 45 properties f_rest_0, f_rest_1, ...", std::to_string(sh_count));
        sh_at.assign(sh_count, -1);
        long at = 0;
        for (const PlyProperty& p : e.properties) {
            for (std::size_t k = 0; k < sh_count; ++k)
                if (p.name == "f_rest_" + std::to_string(k)) {
                    if (p.type != PlyType::u8) fail("uchar for harmonics", "another type");
                    sh_at[k] = at;
                }
            at += long(size_of(p.type));
        }
        for (std::size_t k = 0; k < sh_count; ++k)
            if (sh_at[k] < 0) fail("the property \"f_rest_" + std::to_string(k) + "\"", "none");
    }

    template <std::size_t n>
    void require(const std::array<long, n>& offsets, std::size_t count,
                 const char* const (&names)[n]) const
    {
        for (std::size_t k = 0; k < count; ++k)
            if (offsets[k] < 0) fail(fmt::format("the property \"{}\"", names[k]), "none");
    }

    // Bounds k, k + 1, k + 2 and the three behind them.
    Bounds3 bounds(std::size_t i, std::size_t k) const
    {
        Bounds3 b;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            b.low[axis] = chunk.at<float>(i / chunk_size, std::size_t(bounds_at[k + axis]));
            b.high[axis] = chunk.at<float>(i / chunk_size, std::size_t(bounds_at[k + 3 + axis]));
        }
        return b;
    }
    std::uint32_t word(std::size_t i, std::size_t k) const
    {
        return vertex.at<std::uint32_t>(i, std::size_t(word_at[k]));
    }
    // 11, 10 and 11 bits, x highest.
    static Vec3<double> three(std::uint32_t w, const Bounds3& b)
    {
        return b.between((w >> 21) / 2047.0, (w >> 11 & 1023) / 1023.0, (w & 2047) / 2047.0);
    }

    RawSplat splat(std::size_t i) const
    {
        const Vec3<double> log_scale = three(word(i, 2), bounds(i, 6));
        return {three(word(i, 0), bounds(i, 0)),
                {std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z)},
                rotation_of(word(i, 1)),
                (word(i, 3) & 255) / 255.0};
    }

    // The index of the largest of w, x, y, z in the two highest bits, then the others in 10 bits
    // each, from -sqrt(1/2) to sqrt(1/2).
    static Quat<double> rotation_of(std::uint32_t w)
    {
        std::array<double, 4> q{};
        const std::uint32_t largest = w >> 30;
        double rest = 1;
        int shift = 20;
        for (std::uint32_t k = 0; k < 4; ++k) {
            if (k == largest) continue;
            q[k] = ((w >> shift & 1023) / 1023.0 - 0.5) * std::numbers::sqrt2;
            rest -= q[k] * q[k];
            shift -= 10;
        }
        q[largest] = std::sqrt(std::max(0.0, rest));
        return {q[0], q[1], q[2], q[3]};
    }

    // 0 to 1, 1 being white.
    Vec3<double> colour(std::size_t i) const
    {
        const std::uint32_t w = word(i, 3);
        const Bounds3 b = coloured ? bounds(i, 12) : Bounds3();
        return b.between((w >> 24) / 255.0, (w >> 16 & 255) / 255.0, (w >> 8 & 255) / 255.0);
    }

    // Writers round down, so that the value is the middle of the step; the ends are exact.
    static double coefficient(std::uint8_t b)
    {
        const double t = b == 0 ? 0 : b == 255 ? 1 : (b + 0.5) / 256;
        return 8 * (t - 0.5);
    }

    const std::string& bytes;
    const std::string& path;
    const PlyFile header;
    PackedRows chunk, vertex, sh;
    std::array<long, 18> bounds_at = filled<18>();
    std::array<long, 4> word_at = filled<4>();
    std::size_t sh_count = 0;
    std::vector<long> sh_at;
    bool coloured = false;

    template <std::size_t n>
    static std::array<long, n> filled()
    {
        std::array<long, n> none;
        none.fill(-1);
        return none;
    }
};

// Half axes as the format stores them.
Vec3<float> clamped_logs(Vec3<float> s)
{
    const auto log = [](float x) {
        return float(std::clamp(std::log(double(x)), -largest_log, largest_log));
    };
    return {log(s.x), log(s.y), log(s.z)};
}

Vec3<float> display_colour(Vec3<float> dc)
{
    const auto c = [](float x) { return float(0.5 + sh_constant * double(x)); };
    return {c(dc.x), c(dc.y), c(dc.z)};
}

std::uint32_t quantum(float low, float x, float high, std::uint32_t most)
{
    if (!(high > low)) return 0;
    const double t = (double(x) - low) / (double(high) - low);
    return std::uint32_t(std::lround(std::clamp(t, 0.0, 1.0) * most));
}

std::uint32_t packed_three(const Box3<float>& b, Vec3<float> x)
{
    return quantum(b.low.x, x.x, b.high.x, 2047) << 21 |
           quantum(b.low.y, x.y, b.high.y, 1023) << 11 | quantum(b.low.z, x.z, b.high.z, 2047);
}

std::uint32_t packed_rotation(Quat<float> given)
{
    const Quat<double> u = unit(cast<double>(given));
    const std::array<double, 4> q{u.w, u.x, u.y, u.z};
    std::uint32_t largest = 0;
    for (std::uint32_t k = 1; k < 4; ++k)
        if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
    const double sign = q[largest] < 0 ? -1 : 1;
    std::uint32_t bits = largest;
    for (std::uint32_t k = 0; k < 4; ++k) {
        if (k == largest) continue;
        const double t = sign * q[k] / std::numbers::sqrt2 + 0.5;
        bits = bits << 10 | std::uint32_t(std::lround(std::clamp(t, 0.0, 1.0) * 1023));
    }
    return bits;
}

// Values of one chunk: their bounds.
struct ChunkBounds {
    Box3<float> centre, log_scale, colour;
};

std::string packed_header(const SplatCloud& cloud, std::size_t chunks)
{
    std::string out = "ply\nformat binary_little_endian 1.0\ncomment written by knead\n";
    if (cloud.antialiased) out += "comment SplatRenderMode: mip\n";
    out += fmt::format("element chunk {}\n", chunks);
    for (const char* name : bounds_names) out += fmt::format("property float {}\n", name);
    out += fmt::format("element vertex {}\n", cloud.count());
    for (const char* name : word_names) out += fmt::format("property uint {}\n", name);
    const int rest = 3 * (harmonics(cloud.degree) - 1);
    if (rest > 0) out += fmt::format("element sh {}\n", cloud.count());
    for (int k = 0; k < rest; ++k) out += fmt::format("property uchar f_rest_{}\n", k);
    return out + "end_header\n";
}

}  // namespace

bool holds_compressed_splats(const PlyFile& ply)
{
    const PlyElement* vertex = ply.find("vertex");
    return ply.find("chunk") && vertex && vertex->find("packed_position");
}

SplatFile parse_compressed_ply(const std::string& bytes, const std::string& path)
{
    return PackedReader(bytes, path).read();
}

std::string compressed_ply_bytes(const SplatCloud& cloud, const std::string& path)
{
    if (cloud.count() == 0) throw InputError(path + ": expected splats, found none");
    const std::vector<std::uint32_t> order = order_by_place(cloud);
    const std::size_t chunks = (order.size() + chunk_size - 1) / chunk_size;
    const auto stride = std::size_t(harmonics(cloud.degree));
    std::vector<ChunkBounds> bounds;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::uint32_t i = order[k];
        const Vec3<float> x = cloud.centre[i], s = clamped_logs(cloud.scale[i]),
                          c = display_colour(cloud.sh[i * stride]);
        if (k % chunk_size == 0) bounds.push_back({{x, x}, {s, s}, {c, c}});
        grow(bounds.back().centre, x), grow(bounds.back().log_scale, s);
        grow(bounds.back().colour, c);
    }
    std::string out = packed_header(cloud, chunks);
    out.reserve(out.size() + chunks * 72 + order.size() * (16 + 3 * (stride - 1)));
    const auto put = [&](auto value) {
        out.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const ChunkBounds& b : bounds)
        for (const Box3<float>* box : {&b.centre, &b.log_scale, &b.colour})
            for (const Vec3<float> v : {box->low, box->high}) put(v.x), put(v.y), put(v.z);
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::uint32_t i = order[k];
        const ChunkBounds& b = bounds[k / chunk_size];
        const Vec3<float> c = display_colour(cloud.sh[i * stride]);
        put(packed_three(b.centre, cloud.centre[i]));
        put(packed_rotation(cloud.rotation[i]));
        put(packed_three(b.log_scale, clamped_logs(cloud.scale[i])));
        put(quantum(b.colour.low.x, c.x, b.colour.high.x, 255) << 24 |
            quantum(b.colour.low.y, c.y, b.colour.high.y, 255) << 16 |
            quantum(b.colour.low.z, c.z, b.colour.high.z, 255) << 8 |
            std::uint32_t(byte(255 * double(cloud.opacity[i]))));
    }
    for (const std::uint32_t i : order)
        for (float Vec3<float>::*channel : {&Vec3<float>::x, &Vec3<float>::y, &Vec3<float>::z})
            for (std::size_t n = 1; n < stride; ++n) {
                const double t = double(cloud.sh[i * stride + n].*channel) / 8 + 0.5;
                out.push_back(char(std::uint8_t(std::clamp(256 * t, 0.0, 255.0))));
            }
    return out;
}

}  // namespace knead
