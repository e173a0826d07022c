#include "host/files/zip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cstring>
#include <new>

#include "host/base/errors.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "ZIP is little-endian");

constexpr std::uint32_t local_mark = 0x04034b50, central_mark = 0x02014b50, end_mark = 0x06054b50;
constexpr std::size_t local_size = 30, central_size = 46, end_size = 22, longest_comment = 65535;
constexpr std::uint16_t stored = 0, deflated = 8, encrypted_flag = 1;

template <class T>
T number_at(const std::string& bytes, std::size_t at)
{
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::uint32_t crc_of(const std::string& content)
{
    return std::uint32_t(
        crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()));
}

// Inflates exactly `size` bytes; returns false for anything else.
bool inflate_into(std::string& to, std::size_t size, const char* from, std::size_t packed)
{
    z_stream z{};
    if (inflateInit2(&z, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
    to.resize(size);
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(from));
    z.avail_in = uInt(packed);
    z.next_out = reinterpret_cast<Bytef*>(to.data());
    z.avail_out = uInt(size);
    const int answer = inflate(&z, Z_FINISH);
    const bool whole = answer == Z_STREAM_END && z.avail_out == 0 && z.avail_in == 0;
    inflateEnd(&z);
    return whole;
}

}  // namespace

bool begins_zip(const std::string& start)
{
    return start.size() >= 4 && number_at<std::uint32_t>(start, 0) == local_mark;
}

ZipReader::ZipReader(const std::string& all, const std::string& file) : bytes(all), path(file)
{
    // The end record is behind everything but a comment.
    std::size_t end = std::string::npos;
    for (std::size_t back = end_size; back <= bytes.size() && back <= end_size + longest_comment;
         ++back) {
        const std::size_t at = bytes.size() - back;
        if (number_at<std::uint32_t>(bytes, at) != end_mark) continue;
        if (number_at<std::uint16_t>(bytes, at + 20) != back - end_size) continue;
        end = at;
        break;
    }
    if (end == std::string::npos) fail("end", "a central directory", "none");
    const std::size_t count = number_at<std::uint16_t>(bytes, end + 10),
                      size = number_at<std::uint32_t>(bytes, end + 12);
    std::size_t at = number_at<std::uint32_t>(bytes, end + 16);
    if (at == 0xffffffffu) fail("end", "an archive without ZIP64", "one with it");
    if (at > end || size > end - at)
        fail("end", fmt::format("a central directory before byte {}", end),
             fmt::format("{} bytes at {}", size, at));
    for (std::size_t k = 0; k < count; ++k) {
        const std::string where = fmt::format("byte {}", at);
        if (end - at < central_size || number_at<std::uint32_t>(bytes, at) != central_mark)
            fail(where, "an entry of the central directory", "something else");
        const std::size_t name = number_at<std::uint16_t>(bytes, at + 28),
                          more = std::size_t(number_at<std::uint16_t>(bytes, at + 30)) +
                                 number_at<std::uint16_t>(bytes, at + 32);
        if (end - at - central_size < name + more)
            fail(where, "an entry inside the directory", "a longer one");
        Entry e{bytes.substr(at + central_size, name),    number_at<std::uint16_t>(bytes, at + 10),
                number_at<std::uint32_t>(bytes, at + 16), number_at<std::uint32_t>(bytes, at + 20),
                number_at<std::uint32_t>(bytes, at + 24), number_at<std::uint32_t>(bytes, at + 42)};
        if (number_at<std::uint16_t>(bytes, at + 8) & encrypted_flag)
            fail(where, "no encryption", "\"" + e.name.substr(0, 80) + "\" encrypted");
        entries.push_back(std::move(e));
        at += central_size + name + more;
    }
}

void ZipReader::fail(const std::string& where, const std::string& expected,
                     const std::string& found) const
{
    throw InputError(
        fmt::format("{}: ZIP: {}: expected {}, found {}", path, where, expected, found));
}

const ZipReader::Entry* ZipReader::find(const std::string& name) const
{
    for (const Entry& e : entries)
        if (e.name == name) return &e;
    return nullptr;
}

std::vector<std::string> ZipReader::names() const
{
    std::vector<std::string> all;
    for (const Entry& e : entries) all.push_back(e.name);
    return all;
}

std::string ZipReader::read(const std::string& name, std::size_t most) const
{
    const std::string where = "\"" + name.substr(0, 80) + "\"";
    const Entry* e = find(name);
    if (!e) fail(where, "an entry of this name", "none");
    if (e->size > most) fail(where, fmt::format("at most {} bytes", most), std::to_string(e->size));
    // Sizes in the local header may be 0: those of the directory count.
    const std::size_t header = e->header;
    if (header > bytes.size() || bytes.size() - header < local_size ||
        number_at<std::uint32_t>(bytes, header) != local_mark)
        fail(where, "a local header inside the file", fmt::format("byte {}", header));
    const std::size_t from = header + local_size + number_at<std::uint16_t>(bytes, header + 26) +
                             number_at<std::uint16_t>(bytes, header + 28);
    if (from > bytes.size() || e->packed > bytes.size() - from)
        fail(where, fmt::format("{} bytes inside the file", e->packed),
             fmt::format("a start at {}", from));
    std::string content;
    if (e->method == stored && e->size == e->packed)
        content = bytes.substr(from, e->size);
    else if (e->method != deflated)
        fail(where, "a stored or deflated entry", fmt::format("method {}", e->method));
    else if (!inflate_into(content, e->size, bytes.data() + from, e->packed))
        fail(where, fmt::format("{} bytes, inflated", e->size), "damage");
    if (crc_of(content) != e->checksum) fail(where, "the checksum of its content", "another");
    return content;
}

std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>& entries,
                      const std::string& path)
{
    std::string out, directory;
    const auto put = [](std::string& to, auto value) {
        to.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    std::size_t size = end_size;
    for (const auto& [name, content] : entries)
        size += local_size + central_size + 2 * name.size() + content.size();
    if (size > UINT32_MAX) throw OutputError(path + ": a ZIP holds at most 4 GiB");
    out.reserve(size);
    for (const auto& [name, content] : entries) {
        const auto header = std::uint32_t(out.size()), bytes = std::uint32_t(content.size());
        // Version 1.0, no flags, stored, 1980-01-01 0:00.
        const auto common = [&](std::string& to) {
            put(to, std::uint16_t(10)), put(to, std::uint16_t(0)), put(to, stored);
            put(to, std::uint16_t(0)), put(to, std::uint16_t(0x21));
            put(to, crc_of(content)), put(to, bytes), put(to, bytes);
            put(to, std::uint16_t(name.size())), put(to, std::uint16_t(0));
        };
        put(out, local_mark), common(out);
        out += name, out += content;
        put(directory, central_mark), put(directory, std::uint16_t(10)), common(directory);
        put(directory, std::uint16_t(0)), put(directory, std::uint16_t(0));
        put(directory, std::uint16_t(0)), put(directory, std::uint32_t(0)), put(directory, header);
        directory += name;
    }
    const auto at = std::uint32_t(out.size()), bytes = std::uint32_t(directory.size());
    const auto count = std::uint16_t(entries.size());
    out += directory;
    put(out, end_mark), put(out, std::uint32_t(0)), put(out, count), put(out, count);
    put(out, bytes), put(out, at), put(out, std::uint16_t(0));
    return out;
}

}  // namespace knead
