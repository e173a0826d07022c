// SPZ, packed splats: a header followed by quantised arrays, versions 1 to 3 compressed together by
// gzip, version 4 each by Zstandard behind a header in the open.
// After the description of the format by Niantic Labs (github.com/nianticlabs/spz).
#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <numbers>

#include "host/base/errors.h"
#include "host/files/gzip.h"
#include "host/files/splat_axes.h"
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
    std::uint8_t streams;  // version 4; 0 before
};
static_assert(sizeof(SpzHeader) == 16);
// Version 4: where the table of streams begins, and zeros.
struct SpzTail {
    std::uint32_t table;
    std::uint8_t zeros[12];
};
static_assert(sizeof(SpzTail) == 16);
constexpr std::size_t header_4 = sizeof(SpzHeader) + sizeof(SpzTail);
struct SpzStream {
    std::uint64_t packed, unpacked;  // [bytes]
};
constexpr int antialiased_flag = 1, extensions_flag = 2, detail_flag = 0x80;
constexpr int max_fraction_bits = 23;
constexpr int spz_max_degree = 4;
// Decompression limit: content larger than this and than this multiple of the file is rejected as a
// decompression bomb.
constexpr std::size_t unpacked_anyway = 64 << 20, unpacked_ratio = 100;
constexpr std::size_t max_extensions = 1 << 20;              // bytes
constexpr std::uint32_t coordinate_extension = 0xadbe0003u;  // the axes of what is stored
constexpr std::uint32_t right_up_back = 4, most_systems = 16;
constexpr double colour_gain = 0.15;                           // of a coefficient of degree 0
constexpr double log_scale_steps = 16, log_scale_least = -10;  // half axes: e^(byte / 16 - 10)
constexpr double quaternion_step = 1 / (511 * std::numbers::sqrt2);

// Bytes per splat of each array, in file order.
struct Sizes {
    std::size_t centre, opacity = 1, colour = 3, scale = 3, rotation, sh;
    std::size_t all() const { return centre + opacity + colour + scale + rotation + sh; }
};

Sizes sizes(int version, int degree)
{
    return {.centre = version == 1 ? std::size_t(6) : 9,
            .rotation = version >= 3 ? std::size_t(4) : 3,
            .sh = 3 * std::size_t(harmonics(degree) - 1)};
}

// The axes that files are written in are right, up, back; those of clouds right, down, forward: a
// rotation by 180 degrees about x, which negates y, z, and these harmonics.
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
    if (h.version < 1 || h.version > 4) fail(path, "version 1 to 4", std::to_string(h.version));
    if (h.degree > spz_max_degree) fail(path, "harmonics up to degree 4", std::to_string(h.degree));
    if (h.fraction_bits > max_fraction_bits)
        fail(path, "at most 23 bits of fraction", std::to_string(h.fraction_bits));
    if (h.flags & detail_flag)
        fail(path, "splats of one level of detail", "a tree of levels (flag 128)");
    const std::size_t each = sizes(int(h.version), h.degree).all();
    if (h.count > (most - sizeof h) / each)
        fail(path, fmt::format("{} splats of {} bytes", h.count, each),
             fmt::format("a file that holds {} bytes at most", most));
    return h;
}

// The coordinate system that the records of type, length, content name; 0: none. Other records are
// passed over.
std::uint32_t named_axes(std::string_view records, const std::string& path)
{
    std::uint32_t system = 0;
    for (std::size_t at = 0; at < records.size();) {
        std::uint32_t record[2];
        if (records.size() - at < sizeof record)
            fail(path, "an extension's type and length", "the end of the file");
        std::memcpy(record, records.data() + at, sizeof record);
        at += sizeof record;
        if (record[1] > records.size() - at)
            fail(path, fmt::format("an extension of {} bytes", record[1]),
                 fmt::format("{} bytes left", records.size() - at));
        if (record[0] == coordinate_extension) {
            if (record[1] != sizeof system)
                fail(path, "a coordinate record of 4 bytes", std::to_string(record[1]));
            std::memcpy(&system, records.data() + at, sizeof system);
            if (system > most_systems)
                fail(path, "a coordinate system from 1 to 16", std::to_string(system));
        }
        at += record[1];
    }
    return system;
}

// `arrays`: those of all splats, back to back. `system`: 0 for that of the format.
SplatFile unpacked(std::string_view arrays, const SpzHeader& h, std::uint32_t system,
                   const std::string& path)
{
    const SplatAxes axes(spz_axes(system == 0 ? right_up_back : system));
    const Sizes size = sizes(int(h.version), h.degree);
    const auto* at = reinterpret_cast<const std::uint8_t*>(arrays.data());
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
            if (h.version > 1) return centre_part(centre + 9 * i + 3 * k, h.fraction_bits);
            std::uint16_t half;
            std::memcpy(&half, centre + 6 * i + 2 * k, sizeof half);
            return half_number(half);
        };
        const auto s = [&](std::size_t k) {
            return std::exp(scale[3 * i + k] / log_scale_steps + log_scale_least);
        };
        const std::uint8_t* packed = rotation + size.rotation * i;
        const Quat<double> q = h.version >= 3 ? smallest_three(packed) : first_three(packed);
        const auto stored = [&](int k) -> Vec3<double> {
            const std::uint8_t* c = k == 0 ? colour + 3 * i : sh + size.sh * i + 3 * (k - 1);
            if (k == 0) {
                const auto dc = [&](int n) { return (double(c[n]) / 255 - 0.5) / colour_gain; };
                return {dc(0), dc(1), dc(2)};
            }
            const auto part = [&](int n) { return (double(c[n]) - 128) / 128; };
            return {part(0), part(1), part(2)};
        };
        gather.add({axes.place({x(0), x(1), x(2)}), axes.half_axes({s(0), s(1), s(2)}),
                    axes.turn(q), double(opacity[i]) / 255},
                   [&](int k) { return axes.coefficient(k, stored); });
    }
    return gather.gathered(path);
}

// The arrays of version 4, from a Zstandard frame each. Sizes are known from the header, and each
// frame is unpacked into exactly as many bytes.
std::string unpacked_streams(const std::string& bytes, const SpzHeader& h, std::size_t table,
                             const std::string& path)
{
    const Sizes size = sizes(4, h.degree);
    std::vector<std::size_t> expected;
    for (const std::size_t each :
         {size.centre, size.opacity, size.colour, size.scale, size.rotation, size.sh})
        if (each > 0) expected.push_back(each * h.count);
    if (h.streams != expected.size())
        fail(path, fmt::format("{} streams at degree {}", expected.size(), h.degree),
             std::to_string(h.streams));
    if (table > bytes.size() || (bytes.size() - table) / sizeof(SpzStream) < expected.size())
        fail(path, "a table of streams inside the file", fmt::format("one at byte {}", table));
    std::string all(size.all() * h.count, '\0');
    std::size_t to = 0, from = table + expected.size() * sizeof(SpzStream);
    for (std::size_t k = 0; k < expected.size(); ++k) {
        SpzStream stream;
        std::memcpy(&stream, bytes.data() + table + k * sizeof stream, sizeof stream);
        if (stream.unpacked != expected[k])
            fail(path, fmt::format("stream {} of {} bytes", k + 1, expected[k]),
                 std::to_string(stream.unpacked));
        if (stream.packed > bytes.size() - from)
            fail(path, fmt::format("stream {} of {} packed bytes", k + 1, stream.packed),
                 fmt::format("{} bytes left", bytes.size() - from));
        const std::size_t got =
            ZSTD_decompress(all.data() + to, expected[k], bytes.data() + from, stream.packed);
        if (ZSTD_isError(got) || got != expected[k])
            fail(path, fmt::format("stream {} to unpack to {} bytes", k + 1, expected[k]),
                 ZSTD_isError(got) ? ZSTD_getErrorName(got) : std::to_string(got));
        from += stream.packed, to += expected[k];
    }
    if (from != bytes.size())
        fail(path, "the end of the file", fmt::format("{} bytes more", bytes.size() - from));
    return all;
}

SplatFile parse_spz_4(std::string bytes, const SpzHeader& h, const std::string& path)
{
    SpzTail tail;
    if (bytes.size() < header_4) fail(path, "a header of 32 bytes", std::to_string(bytes.size()));
    std::memcpy(&tail, bytes.data() + sizeof(SpzHeader), sizeof tail);
    if (tail.table < header_4 || tail.table > bytes.size())
        fail(path, "a table of streams behind the header", fmt::format("byte {}", tail.table));
    std::uint32_t system = 0;
    if (h.flags & extensions_flag) {
        const std::size_t size = std::min(tail.table - header_4, max_extensions + 1);
        if (size > max_extensions)
            fail(path, fmt::format("extensions of at most {} bytes", max_extensions),
                 std::to_string(tail.table - header_4));
        system = named_axes(std::string_view(bytes).substr(header_4, size), path);
    }
    bytes = unpacked_streams(bytes, h, tail.table, path);
    SplatFile file = unpacked(bytes, h, system, path);
    if (system == 0)
        file.notes.push_back(
            "no record of its axes: read as right, up, back, as the format has them; if the object "
            "stands on its head, its program kept right, down, front: set `up` to \"y\"");
    return file;
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

SplatFile parse_spz(std::string bytes, const std::string& path)
{
    const bool packed = begins_gzip(bytes);
    // The limit of a header in the open is known with its version.
    const bool open_3 = !packed && bytes.size() > 4 && bytes[4] < 4;
    const SpzHeader h =
        checked_header(packed ? gunzipped_start(bytes, sizeof(SpzHeader)) : bytes, path,
                       open_3 ? std::max(bytes.size(), sizeof(SpzHeader))
                              : std::max(unpacked_anyway, unpacked_ratio * bytes.size()));
    if (h.version == 4) {
        if (packed) fail(path, "version 4 in the open", "a gzip stream around it");
        return parse_spz_4(std::move(bytes), h, path);
    }
    const std::size_t end = sizeof h + h.count * sizes(int(h.version), h.degree).all();
    const bool extended = h.flags & extensions_flag;
    const std::size_t most = end + (extended ? max_extensions : 0);
    if (packed) bytes = gunzipped(bytes, path, most);
    if (bytes.size() < end || bytes.size() > most)
        fail(path, fmt::format("{} splats in {} bytes", h.count, end),
             fmt::format("{} bytes", bytes.size()));
    const std::string_view whole = bytes;
    const std::uint32_t system = extended ? named_axes(whole.substr(end), path) : 0;
    return unpacked(whole.substr(sizeof h, end - sizeof h), h, system, path);
}

namespace {

// Array k of a file, in file order, in its axes.
std::string packed_array(const SplatCloud& cloud, const SpzHeader& h, std::size_t k)
{
    const Sizes size = sizes(int(h.version), cloud.degree);
    const std::size_t n = cloud.count(), stride = std::size_t(harmonics(cloud.degree));
    const std::size_t each[] = {size.centre, size.opacity,  size.colour,
                                size.scale,  size.rotation, size.sh};
    std::string out;
    out.reserve(n * each[k]);
    const auto put = [&](double value) { out.push_back(char(byte(value))); };
    const auto put_centre = [&](double x) {
        const auto whole = std::uint32_t(std::lround(std::ldexp(x, h.fraction_bits)));
        for (int shift : {0, 8, 16}) out.push_back(char(whole >> shift));
    };
    for (std::size_t i = 0; i < n; ++i) {
        if (k == 0) {
            const Vec3<float> x = cloud.centre[i];
            put_centre(x.x), put_centre(-x.y), put_centre(-x.z);
        } else if (k == 1) {
            put(255 * double(cloud.opacity[i]));
        } else if (k == 2) {
            const Vec3<float> dc = cloud.sh[i * stride];
            for (float c : {dc.x, dc.y, dc.z}) put(255 * (colour_gain * double(c) + 0.5));
        } else if (k == 3) {
            const Vec3<float> s = cloud.scale[i];
            for (float part : {s.x, s.y, s.z})
                put(log_scale_steps * (std::log(double(part)) - log_scale_least));
        } else if (k == 4) {
            const Quat<float> r = cloud.rotation[i];
            const Quat<double> q{r.w, r.x, -double(r.y), -double(r.z)};
            const auto bytes = h.version >= 3 ? packed_smallest(q) : packed_first(q);
            out.append(reinterpret_cast<const char*>(bytes.data()), size.rotation);
        } else {
            for (std::size_t c = 1; c < stride; ++c) {
                const Vec3<float> v = cloud.sh[i * stride + c];
                for (float part : {v.x, v.y, v.z}) put(128 + 128 * sh_sign[c] * double(part));
            }
        }
    }
    return out;
}

template <class T>
void add_bytes(std::string& bytes, const T& value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Appends a Zstandard frame, piece by piece.
void compress_into(std::string& frame, const std::string& bytes)
{
    struct Free {
        void operator()(ZSTD_CCtx* c) const { ZSTD_freeCCtx(c); }
    };
    const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
    if (!context) throw std::bad_alloc();
    ZSTD_CCtx_setPledgedSrcSize(context.get(), bytes.size());
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    std::string piece(ZSTD_CStreamOutSize(), '\0');
    for (std::size_t left = 1; left > 0;) {
        ZSTD_outBuffer out{piece.data(), piece.size(), 0};
        left = ZSTD_compressStream2(context.get(), &out, &in, ZSTD_e_end);
        if (ZSTD_isError(left)) throw std::bad_alloc();  // nothing else can go wrong
        frame.append(piece, 0, out.pos);
    }
}

// With a record of the axes, since many files of this version have others.
void write_spz_4(const SplatCloud& cloud, SpzHeader h, std::size_t arrays, const AddBytes& add)
{
    h.streams = std::uint8_t(arrays), h.flags |= extensions_flag;
    constexpr std::uint32_t record[3] = {coordinate_extension, 4, right_up_back};
    std::string head;
    add_bytes(head, h);
    add_bytes(head, SpzTail{header_4 + sizeof record, {}});
    add_bytes(head, record);
    std::vector<std::string> frames;
    for (std::size_t k = 0; k < arrays; ++k) {
        const std::string array = packed_array(cloud, h, k);
        // What is not filled takes no memory.
        std::string frame;
        frame.reserve(ZSTD_compressBound(array.size()));
        compress_into(frame, array);
        add_bytes(head, SpzStream{frame.size(), array.size()});
        frames.push_back(std::move(frame));
    }
    add(head);
    for (std::string& frame : frames) add(frame), frame = {};
}

}  // namespace

void write_spz(const SplatCloud& cloud, const std::string& path, int version, const AddBytes& add)
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
    const std::size_t arrays = cloud.degree > 0 ? 6 : 5;
    if (version == 4) return write_spz_4(cloud, h, arrays, add);
    const auto part = [&](std::size_t k) {
        if (k > 0) return packed_array(cloud, h, k - 1);
        std::string head;
        add_bytes(head, h);
        return head;
    };
    gzip_parts(part, 1 + arrays, add);
}

std::string spz_bytes(const SplatCloud& cloud, const std::string& path, int version)
{
    std::string all;
    write_spz(cloud, path, version, [&](const std::string& part) { all += part; });
    return all;
}

}  // namespace knead
