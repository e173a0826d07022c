// .ksplat of GaussianSplats3D, read only: sections of rows of one of three levels of compression,
// whose centres lie in buckets. docs/reference/formats.md.
#include <fmt/format.h>

#include <array>
#include <bit>

#include "host/base/errors.h"
#include "host/files/ply.h"
#include "host/files/splat_gather.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, ".ksplat is read as it lies");

constexpr std::size_t file_header = 4096, section_header = 1024, bucket_bytes = 12;
constexpr std::size_t max_degree_in_file = 2;

class KsplatReader {
  public:
    KsplatReader(const ByteWindow& all, const std::string& file) : bytes(all), rows(all), path(file)
    {
    }

    SplatFile read()
    {
        if (bytes.size() < file_header)
            fail(0, "a header of 4096 bytes", std::to_string(bytes.size()));
        const int major = at<std::uint8_t>(0), minor = at<std::uint8_t>(1);
        if (major != 0 || minor < 1)
            fail(0, "version 0.1 or a later 0", fmt::format("{}.{}", major, minor));
        const std::size_t most_sections = at<std::uint32_t>(4);
        level = at<std::uint16_t>(20);
        if (level > 2) fail(20, "compression level 0, 1 or 2", std::to_string(level));
        low_sh = at<float>(36), high_sh = at<float>(40);
        if (low_sh == 0) low_sh = -1.5;
        if (high_sh == 0) high_sh = 1.5;
        if (most_sections > (bytes.size() - file_header) / section_header)
            fail(4, fmt::format("{} headers of sections", most_sections),
                 fmt::format("{} bytes", bytes.size()));
        // Degrees first: the cloud has the highest. The file's own count of sections may be 0.
        std::size_t degree = 0, splats = 0, data = file_header + most_sections * section_header;
        std::vector<Section> sections;
        for (std::size_t k = 0; k < most_sections; ++k) {
            const Section s = section(file_header + k * section_header, data);
            data = s.end;
            if (s.count == 0) continue;
            degree = std::max(degree, s.degree), splats += s.count;
            sections.push_back(s);
        }
        if (data != bytes.size())
            fail(data, "the end of the file", fmt::format("{} bytes more", bytes.size() - data));
        SplatGather gather("ksplat", int(degree));
        gather.reserve(splats);
        for (const Section& s : sections) add(s, gather);
        return gather.gathered(path);
    }

  private:
    struct Section {
        std::size_t count, degree, full, bucket_size, row;
        double range, block;
        std::size_t lengths, buckets, bucket_count, first_row,
            end;  // offsets, but for bucket_count
    };

    [[noreturn]] void fail(std::size_t byte_at, const std::string& expected,
                           const std::string& found) const
    {
        throw InputError(fmt::format("{}: .ksplat: byte {}: expected {}, found {}", path, byte_at,
                                     expected, found));
    }

    // Precondition: inside the file.
    template <class T>
    T at(std::size_t offset) const
    {
        return bytes.at<T>(offset);
    }

    // The header at `from`, of a section whose data begins at `data`.
    Section section(std::size_t from, std::size_t data) const
    {
        Section s{};
        const auto word = [&](std::size_t k) { return std::size_t(at<std::uint32_t>(from + k)); };
        const std::size_t most = word(4);
        s.count = word(0), s.bucket_size = word(8), s.bucket_count = word(12);
        s.block = at<float>(from + 16);
        const std::size_t stored = at<std::uint16_t>(from + 20);
        const std::size_t range = word(24);
        s.range = range != 0 ? double(range) : level == 0 ? 1 : 32767;
        s.full = word(32);
        const std::size_t partial = word(36);
        s.degree = at<std::uint16_t>(from + 40);
        if (s.count > most)
            fail(from, fmt::format("at most {} splats", most), std::to_string(s.count));
        if (s.degree > max_degree_in_file)
            fail(from + 40, "harmonics up to degree 2", std::to_string(s.degree));
        if (s.bucket_count > 0 && stored != bucket_bytes)
            fail(from + 20, "12 bytes a bucket", std::to_string(stored));
        const std::size_t sh = 3 * std::size_t(harmonics(int(s.degree)) - 1);
        s.row = level == 0 ? 44 + 4 * sh : 24 + (level == 1 ? 2 : 1) * sh;
        s.lengths = data, s.buckets = data + 4 * partial;
        s.first_row = s.buckets + stored * s.bucket_count;
        s.end = s.first_row + s.row * most;  // below 2^32 * 140 each: no overflow
        if (s.end > bytes.size())
            fail(from, fmt::format("a section that ends at {} at most", bytes.size()),
                 fmt::format("{} splats of {} bytes that end at {}", most, s.row, s.end));
        if (level > 0 && s.count > 0) check_buckets(s, from, partial);
        return s;
    }

    // Every splat of a packed section has a bucket.
    void check_buckets(const Section& s, std::size_t from, std::size_t partial) const
    {
        if (s.full > s.bucket_count || s.bucket_count - s.full < partial)
            fail(from + 32, fmt::format("at most {} buckets, full and partial", s.bucket_count),
                 fmt::format("{} and {}", s.full, partial));
        std::size_t holds = s.full * s.bucket_size;
        for (std::size_t k = 0; k < partial; ++k) holds += at<std::uint32_t>(s.lengths + 4 * k);
        if (holds < s.count)
            fail(from, fmt::format("buckets of {} splats", s.count), std::to_string(holds));
    }

    void add(const Section& s, SplatGather& gather) const
    {
        // Full buckets first, then the partial ones by their lengths.
        std::size_t bucket = 0, left = s.full > 0 ? s.bucket_size : 0;
        const auto length_of = [&](std::size_t b) {
            return b < s.full ? s.bucket_size
                              : std::size_t(at<std::uint32_t>(s.lengths + 4 * (b - s.full)));
        };
        if (level > 0) left = length_of(0);
        for (std::size_t i = 0; i < s.count; ++i) {
            if (level > 0) {
                while (left == 0) left = length_of(++bucket);
                --left;
            }
            add(s, s.first_row + i * s.row, bucket, gather);
        }
    }

    // The row at `from`.
    void add(const Section& s, std::size_t from, std::size_t bucket, SplatGather& gather) const
    {
        const auto real = [&](std::size_t offset, std::size_t k) -> double {
            return level == 0 ? double(rows.at<float>(from + offset + 4 * k))
                              : half_number(rows.at<std::uint16_t>(from + offset + 2 * k));
        };
        const auto centre = [&](std::size_t k) -> double {
            if (level == 0) return rows.at<float>(from + 4 * k);
            const double spacing = s.block / 2 / s.range;
            return (double(rows.at<std::uint16_t>(from + 2 * k)) - s.range) * spacing +
                   double(at<float>(s.buckets + bucket_bytes * bucket + 4 * k));
        };
        const std::size_t scale = level == 0 ? 12 : 6, rotation = level == 0 ? 24 : 12,
                          colour = level == 0 ? 40 : 20, sh = colour + 4;
        const auto channel = [&](std::size_t k) {
            return double(rows.at<std::uint8_t>(from + colour + k)) / 255;
        };
        // Each degree channel by channel.
        const auto coefficient = [&](int k) -> Vec3<double> {
            if (k == 0) {
                const auto dc = [&](std::size_t c) { return (channel(c) - 0.5) / sh_constant; };
                return {dc(0), dc(1), dc(2)};
            }
            if (k >= harmonics(int(s.degree))) return {0, 0, 0};
            const std::size_t first = k < 4 ? 0 : 9, each = k < 4 ? 3 : 5,
                              n = std::size_t(k) - (k < 4 ? 1 : 4);
            const auto part = [&](std::size_t c) {
                const std::size_t number = first + c * each + n;
                if (level < 2) return real(sh, number);
                return low_sh +
                       double(rows.at<std::uint8_t>(from + sh + number)) / 255 * (high_sh - low_sh);
            };
            return {part(0), part(1), part(2)};
        };
        gather.add({{centre(0), centre(1), centre(2)},
                    {real(scale, 0), real(scale, 1), real(scale, 2)},
                    {real(rotation, 0), real(rotation, 1), real(rotation, 2), real(rotation, 3)},
                    channel(3)},
                   coefficient);
    }

    const ByteWindow bytes, rows;  // headers and buckets; rows
    const std::string& path;
    int level = 0;
    double low_sh = -1.5, high_sh = 1.5;
};

}  // namespace

SplatFile parse_ksplat(const std::string& bytes, const std::string& path)
{
    return parse_ksplat(ByteWindow(bytes), path);
}

SplatFile parse_ksplat(const ByteWindow& bytes, const std::string& path)
{
    return KsplatReader(bytes, path).read();
}

}  // namespace knead
