// SPZ, packed splats, versions 2 and 3: a header followed by quantised arrays, compressed by gzip.
// After the description of the format by Niantic Labs (github.com/nianticlabs/spz).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "host/base/errors.h"
#include "host/files/gzip.h"
#include "host/files/splat_gather.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "SPZ is read as it lies");

struct SpzHeader {
    char mark[4];  // "NGSP"
    std::uint32_t version, count;
    std::uint8_t degree;
    std::uint8_t fraction_bits;  // for centres
    std::uint8_t flags;
    std::uint8_t zero;
};
static_assert(sizeof(SpzHeader) == 16);
constexpr int antialiased_flag = 1, extensions_flag = 2;
constexpr int max_fraction_bits = 23;
constexpr int spz_max_degree = 4;
// Decompression limit: content larger than this and than this multiple of the file is rejected as a
// decompression bomb.
constexpr std::size_t unpacked_anyway = 64 << 20, unpacked_ratio = 100;
constexpr std::size_t max_extensions = 1 << 20;                // bytes
constexpr std::uint32_t coordinate_extension = 0xadbe0003u;    // other axes than the default
constexpr double colour_gain = 0.15;                           // of a coefficient of degree 0
constexpr double log_scale_steps = 16, log_scale_least = -10;  // half axes: e^(byte / 16 - 10)
constexpr double quaternion_step = 1 / (511 * std::numbers::sqrt2);

// Bytes per splat of each array, in file order.
struct Sizes {
    std::size_t centre = 9, opacity = 1, colour = 3, scale = 3, rotation, sh;
    std::size_t all() const { return centre + opacity + colour + scale + rotation + sh; }
};

Sizes sizes(int version, int degree)
{
    return {.rotation = version >= 3 ? std::size_t(4) : 3,
            .sh = 3 * std::size_t(harmonics(degree) - 1)};
}

// The format's axes are right, up, back; those of clouds right, down, forward: a rotation by 180
// degrees about x, which negates y, z, and these harmonics.
constexpr double sh_sign[] = {1, -1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1};

double centre_part(const std::uint8_t* at, int fraction_bits)
{
    const std::uint32_t bits =
        std::uint32_t(at[0]) | std::uint32_t(at[1]) << 8 | std::uint32_t(at[2]) << 16;
    const int whole = int(bits) - (bits & 0x800000u ? 0x1000000 : 0);
    return std::ldexp(double(whole), -fraction_bits);
}

// x, y, z as bytes; w >= 0 follows from unit length.
Quat<double> first_three(const std::uint8_t* at)
{
    const auto part = [&](int k) { return double(at[k]) / 127.5 - 1; };
    const double x = part(0), y = part(1), z = part(2);
    return {std::sqrt(std::max(0.0, 1 - x * x - y * y - z * z)), x, y, z};
}

// The three smallest of x, y, z, w in 10 bits each, a sign and 9 bits for up to sqrt(1/2), the last
// one lowest; above them the index of the largest, which is >= 0 and follows from unit length.
Quat<double> smallest_three(const std::uint8_t* at)
{
    std::uint32_t bits;
    std::memcpy(&bits, at, sizeof bits);
    const std::uint32_t largest = bits >> 30;
    std::array<double, 4> q{};
    double rest = 1;
    for (std::uint32_t k = 4; k-- > 0;) {
        if (k == largest) continue;
        const double part = quaternion_step * double(bits & 511);
        q[k] = bits & 512 ? -part : part;
        rest -= part * part;
        bits >>= 10;
    }
    q[largest] = std::sqrt(std::max(0.0, rest));
    return {q[3], q[0], q[1], q[2]};
}

std::array<std::uint8_t, 4> packed_first(Quat<double> q)
{
    const double to = q.w < 0 ? -127.5 : 127.5;
    return {byte(to * q.x + 127.5), byte(to * q.y + 127.5), byte(to * q.z + 127.5), 0};
}

std::array<std::uint8_t, 4> packed_smallest(Quat<double> r)
{
    const std::array<double, 4> q{r.x, r.y, r.z, r.w};
    std::uint32_t largest = 0;
    for (std::uint32_t k = 1; k < 4; ++k)
        if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
    std::uint32_t bits = largest;
    for (std::uint32_t k = 0; k < 4; ++k) {
        if (k == largest) continue;
        const bool negative = (q[k] < 0) != (q[largest] < 0);
        const double part = std::min(511.0, std::round(std::abs(q[k]) / quaternion_step));
        bits = bits << 10 | std::uint32_t(negative) << 9 | std::uint32_t(part);
    }
    std::array<std::uint8_t, 4> bytes;
    std::memcpy(bytes.data(), &bits, sizeof bits);
    return bytes;
}

[[noreturn]] void fail(const std::string& path, const std::string& expected,
                       const std::string& found)
{
    throw InputError(fmt::format("{}: SPZ: expected {}, found {}", path, expected, found));
}

// `most`: maximum unpacked size of the file [bytes].
SpzHeader checked_header(const std::string& start, const std::string& path, std::size_t most)
{
    if (start.size() < sizeof(SpzHeader))
        fail(path, "a header of 16 bytes", fmt::format("{}", start.size()));
    SpzHeader h;
    std::memcpy(&h, start.data(), sizeof h);
    if (std::memcmp(h.mark, "NGSP", 4) != 0) fail(path, "\"NGSP\" first", "something else");
    if (h.version != 2 && h.version != 3)
        fail(
            path, "version 2 or 3",
            fmt::format("{}{}", h.version, h.version == 4 ? ", which is packed by Zstandard" : ""));
    if (h.degree > spz_max_degree) fail(path, "harmonics up to degree 4", std::to_string(h.degree));
    if (h.fraction_bits > max_fraction_bits)
        fail(path, "at most 23 bits of fraction", std::to_string(h.fraction_bits));
    const std::size_t each = sizes(int(h.version), h.degree).all();
    if (h.count > (most - sizeof h) / each)
        fail(path, fmt::format("{} splats of {} bytes", h.count, each),
             fmt::format("a file that holds {} bytes at most", most));
    return h;
}

// Checks the records of type, length, content.
void check_extensions(const std::string& all, std::size_t at, const std::string& path)
{
    while (at < all.size()) {
        std::uint32_t record[2];
        if (all.size() - at < sizeof record)
            fail(path, "an extension's type and length", "the end of the file");
        std::memcpy(record, all.data() + at, sizeof record);
        at += sizeof record;
        if (record[1] > all.size() - at)
            fail(path, fmt::format("an extension of {} bytes", record[1]),
                 fmt::format("{} bytes left", all.size() - at));
        if (record[0] == coordinate_extension)
            fail(path, "axes that point right, up and back", "an extension that names others");
        at += record[1];
    }
}

SplatFile unpacked(const std::string& all, const SpzHeader& h, const std::string& path)
{
    const Sizes size = sizes(int(h.version), h.degree);
    const auto* at = reinterpret_cast<const std::uint8_t*>(all.data()) + sizeof h;
    const auto next = [&](std::size_t each) {
        const std::uint8_t* array = at;
        at += each * h.count;
        return array;
    };
    const auto *centre = next(size.centre), *opacity = next(size.opacity),
               *colour = next(size.colour), *scale = next(size.scale),
               *rotation = next(size.rotation), *sh = next(size.sh);
    SplatGather gather("spz", h.degree);
    gather.reserve(h.count);
    gather.file.cloud.antialiased = h.flags & antialiased_flag;
    for (std::size_t i = 0; i < h.count; ++i) {
        const auto x = [&](std::size_t k) {
            return centre_part(centre + 9 * i + 3 * k, h.fraction_bits);
        };
        const auto s = [&](std::size_t k) {
            return std::exp(scale[3 * i + k] / log_scale_steps + log_scale_least);
        };
        const std::uint8_t* packed = rotation + size.rotation * i;
        const Quat<double> q = h.version >= 3 ? smallest_three(packed) : first_three(packed);
        const auto coefficient = [&](int k) -> Vec3<double> {
            const std::uint8_t* c = k == 0 ? colour + 3 * i : sh + size.sh * i + 3 * (k - 1);
            if (k == 0) {
                const auto dc = [&](int n) { return (double(c[n]) / 255 - 0.5) / colour_gain; };
                return {dc(0), dc(1), dc(2)};
            }
            const auto part = [&](int n) { return sh_sign[k] * (double(c[n]) - 128) / 128; };
            return {part(0), part(1), part(2)};
        };
        gather.add({{x(0), 0 - x(1), 0 - x(2)},  // never -0
                    {s(0), s(1), s(2)},
                    {q.w, q.x, -q.y, -q.z},
                    double(opacity[i]) / 255},
                   coefficient);
    }
    return gather.gathered(path);
}

// Number of fraction bits: as many as the range of the centres allows, but with steps no finer than
// 1/65536 of the largest coordinate's power of two or 1/4096 m, whichever is finer: more bits would
// only encode noise.
int fraction_bits_for(const SplatCloud& cloud, const std::string& path)
{
    float farthest = 0;
    for (const Vec3<float>& x : cloud.centre)
        farthest = std::max({farthest, std::abs(x.x), std::abs(x.y), std::abs(x.z)});
    int exponent = 0;  // farthest < 2^exponent
    std::frexp(farthest, &exponent);
    const int fit = 22 - exponent;
    if (fit < 0)
        throw InputError(
            fmt::format("{}: SPZ: expected centres within 4e6 m, found {} m", path, farthest));
    return std::min({fit, std::max(16 - exponent, 12), max_fraction_bits});
}

}  // namespace

bool begins_spz(const std::string& start)
{
    return start.starts_with("NGSP") || (begins_gzip(start) && gunzipped_start(start, 4) == "NGSP");
}

SplatFile parse_spz(const std::string& bytes, const std::string& path)
{
    const bool packed = begins_gzip(bytes);
    const SpzHeader h = checked_header(
        packed ? gunzipped_start(bytes, sizeof(SpzHeader)) : bytes, path,
        packed ? std::max(unpacked_anyway, unpacked_ratio * bytes.size()) : bytes.size());
    const std::size_t end = sizeof h + h.count * sizes(int(h.version), h.degree).all();
    const bool extended = h.flags & extensions_flag;
    const std::size_t most = end + (extended ? max_extensions : 0);
    const std::string unzipped = packed ? gunzipped(bytes, path, most) : std::string();
    const std::string& all = packed ? unzipped : bytes;
    if (all.size() < end || all.size() > most)
        fail(path, fmt::format("{} splats in {} bytes", h.count, end),
             fmt::format("{} bytes", all.size()));
    if (extended) check_extensions(all, end, path);
    return unpacked(all, h, path);
}

std::string spz_bytes(const SplatCloud& cloud, const std::string& path, int version)
{
    if (cloud.count() > 0x7fffffffu)
        throw InputError(fmt::format("{}: SPZ: expected at most 2147483647 splats, found {}", path,
                                     cloud.count()));
    const SpzHeader h{{'N', 'G', 'S', 'P'},
                      std::uint32_t(version),
                      std::uint32_t(cloud.count()),
                      std::uint8_t(cloud.degree),
                      std::uint8_t(fraction_bits_for(cloud, path)),
                      std::uint8_t(cloud.antialiased ? antialiased_flag : 0),
                      0};
    std::string out(reinterpret_cast<const char*>(&h), sizeof h);
    const Sizes size = sizes(version, cloud.degree);
    out.reserve(out.size() + cloud.count() * size.all());
    const auto put = [&](double value) { out.push_back(char(byte(value))); };
    const auto put_centre = [&](double x) {
        const auto whole = std::uint32_t(std::lround(std::ldexp(x, h.fraction_bits)));
        for (int shift : {0, 8, 16}) out.push_back(char(whole >> shift));
    };
    for (const Vec3<float>& x : cloud.centre) put_centre(x.x), put_centre(-x.y), put_centre(-x.z);
    for (float a : cloud.opacity) put(255 * double(a));
    const std::size_t stride = std::size_t(harmonics(cloud.degree));
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> dc = cloud.sh[i * stride];
        for (float c : {dc.x, dc.y, dc.z}) put(255 * (colour_gain * double(c) + 0.5));
    }
    for (const Vec3<float>& s : cloud.scale)
        for (float part : {s.x, s.y, s.z})
            put(log_scale_steps * (std::log(double(part)) - log_scale_least));
    for (const Quat<float>& r : cloud.rotation) {
        const Quat<double> q{r.w, r.x, -double(r.y), -double(r.z)};
        const auto bytes = version >= 3 ? packed_smallest(q) : packed_first(q);
        out.append(reinterpret_cast<const char*>(bytes.data()), size.rotation);
    }
    for (std::size_t i = 0; i < cloud.count(); ++i)
        for (std::size_t k = 1; k < stride; ++k) {
            const Vec3<float> c = cloud.sh[i * stride + k];
            for (float part : {c.x, c.y, c.z}) put(128 + 128 * sh_sign[k] * double(part));
        }
    return gzipped(out);
}

}  // namespace knead
