#include "host/files/gzip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <new>

#include "host/base/errors.h"

namespace knead {
namespace {

constexpr int gzip_window = 16 + MAX_WBITS;  // with the header and checksum of gzip
constexpr std::size_t step = std::size_t(1) << 16, largest_part = std::size_t(4) << 20;

// Feeds `bytes` to zlib in pieces, since zlib counts in 32 bits.
class Feed {
  public:
    Feed(z_stream& stream, const std::string& bytes) : z(stream), all(bytes) {}

    // Refills the input. Returns true if it is the last piece.
    bool more()
    {
        if (z.avail_in == 0) {
            const std::size_t size = std::min(all.size() - given, step);
            z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(all.data() + given));
            z.avail_in = uInt(size);
            given += size;
        }
        return given == all.size();
    }
    std::size_t used() const { return given - z.avail_in; }

  private:
    z_stream& z;
    const std::string& all;
    std::size_t given = 0;
};

struct Inflated {
    std::string bytes;
    bool ended = false;    // stream complete, checksum correct
    std::size_t used = 0;  // compressed bytes consumed
    std::string trouble;   // zlib's message, if any
};

Inflated inflated(const std::string& bytes, std::size_t most)
{
    z_stream z{};
    if (inflateInit2(&z, gzip_window) != Z_OK) throw std::bad_alloc();
    Inflated out;
    out.bytes.reserve(most + 1);  // takes no memory until it is filled
    Feed feed(z, bytes);
    std::string part(step, '\0');
    int answer = Z_OK;
    // Reading one byte beyond `most` detects longer content.
    while (answer == Z_OK && out.bytes.size() <= most) {
        feed.more();
        z.next_out = reinterpret_cast<Bytef*>(part.data());
        z.avail_out = uInt(std::min(step, most + 1 - out.bytes.size()));
        const std::size_t room = z.avail_out;
        answer = inflate(&z, Z_NO_FLUSH);  // Z_BUF_ERROR: truncated file
        out.bytes.append(part, 0, room - z.avail_out);
    }
    out.ended = answer == Z_STREAM_END;
    out.used = feed.used();
    if (z.msg) out.trouble = z.msg;
    inflateEnd(&z);
    return out;
}

}  // namespace

bool begins_gzip(const std::string& start) { return start.starts_with("\x1f\x8b"); }

std::string gunzipped_start(const std::string& bytes, std::size_t most)
{
    std::string start = inflated(bytes, most).bytes;
    start.resize(std::min(start.size(), most));
    return start;
}

std::string gunzipped(const std::string& bytes, const std::string& path, std::size_t most)
{
    Inflated all = inflated(bytes, most);
    const auto fail = [&](const std::string& expected, const std::string& found) {
        throw InputError(
            fmt::format("{}: byte {}: expected {}, found {}", path, all.used, expected, found));
    };
    if (all.bytes.size() > most) fail(fmt::format("{} bytes, unpacked", most), "more");
    if (!all.ended)
        fail("a gzip stream to its end",
             all.trouble.empty() ? "the end of the file" : "damage: " + all.trouble);
    if (all.used != bytes.size())
        fail("the end of the file", fmt::format("{} bytes more", bytes.size() - all.used));
    return std::move(all.bytes);
}

void gzip_parts(const std::function<std::string(std::size_t k)>& part, std::size_t parts,
                const AddBytes& add)
{
    z_stream z{};
    constexpr int memory = 9;  // the maximum, for speed
    if (deflateInit2(&z, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_window, memory,
                     Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    struct End {
        z_stream& of;
        ~End() { deflateEnd(&of); }
    } const end{z};
    std::string out;
    for (std::size_t k = 0; k < parts; ++k) {
        const std::string bytes = part(k);
        Feed feed(z, bytes);
        const bool last = k + 1 == parts;
        for (int answer = Z_OK;;) {
            const bool all = feed.more();
            const std::size_t size = out.size();
            out.resize(size + step);
            z.next_out = reinterpret_cast<Bytef*>(out.data() + size);
            z.avail_out = uInt(step);
            answer = deflate(&z, last && all ? Z_FINISH : Z_NO_FLUSH);
            out.resize(size + step - z.avail_out);
            if (out.size() >= largest_part) add(out), out.clear();
            if (last ? answer == Z_STREAM_END : all && z.avail_in == 0 && z.avail_out > 0) break;
        }
    }
    add(out);
}

std::string gzipped(const std::string& bytes)
{
    std::string all;
    gzip_parts([&](std::size_t) { return bytes; }, 1,
               [&](const std::string& part) { all += part; });
    return all;
}

}  // namespace knead
