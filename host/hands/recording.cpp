#include "host/hands/recording.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/hands/recording_rules.h"

namespace knead {
namespace {

constexpr char magic[] = "KNHANDS1";
constexpr std::size_t magic_size = 8, checksum_size = 8;
constexpr std::uint32_t version = 1;
constexpr std::uint32_t tracked_bit = 1u << 31;  // bits below: joint j is valid
constexpr std::size_t joint_size = 8 * 4;        // position, quaternion, radius
constexpr std::size_t frame_size = 8 + side_count * (4 + joint_count * joint_size);
constexpr std::size_t largest_file = std::size_t(1) << 30;  // [bytes]: five hours of 30 Hz

// Appends a word in little-endian order on every machine.
template <class Word>
void put(std::string& bytes, Word word)
{
    for (std::size_t i = 0; i < sizeof word; ++i) bytes += char(word >> (8 * i) & 0xff);
}
void put(std::string& bytes, float x) { put(bytes, std::bit_cast<std::uint32_t>(x)); }
void put(std::string& bytes, double x) { put(bytes, std::bit_cast<std::uint64_t>(x)); }

class Reader {
  public:
    Reader(const std::string& bytes, const std::string& path) : bytes_(bytes), path_(path) {}
    Place place(std::size_t offset) const { return {path_, fmt::format("at byte {}", offset)}; }
    std::size_t offset() const { return offset_; }
    std::string text(std::size_t size, const char* what)
    {
        need(size, what);
        return bytes_.substr(std::exchange(offset_, offset_ + size), size);
    }
    template <class T>
    T take(const char* what)
    {
        using Word = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
        need(sizeof(T), what);
        Word word = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i)
            word |= Word(static_cast<unsigned char>(bytes_[offset_ + i])) << (8 * i);
        offset_ += sizeof(T);
        return std::bit_cast<T>(word);
    }

  private:
    void need(std::size_t size, const char* what) const
    {
        if (bytes_.size() - offset_ >= size) return;
        place(offset_).refuse(fmt::format("{} of {} bytes", what, size),
                              fmt::format("the end of the file after {}", bytes_.size() - offset_));
    }
    const std::string& bytes_;
    const std::string& path_;
    std::size_t offset_ = 0;
};

Hand take_hand(Reader& in)
{
    Hand hand;
    const std::size_t at = in.offset();
    const auto flags = in.take<std::uint32_t>("flags");
    if (flags & ~(tracked_bit | ((1u << joint_count) - 1)))
        in.place(at).refuse("no flag but 26 joints and bit 31", fmt::format("{:#010x}", flags));
    hand.tracked = (flags & tracked_bit) != 0;
    for (int j = 0; j < joint_count; ++j) {
        const Place place = in.place(in.offset());
        float v[8];
        for (float& x : v) x = in.take<float>("a joint's number");
        hand.joints[j] = {{v[3], v[4], v[5], v[6]}, {v[0], v[1], v[2]}};
        hand.radius[j] = v[7];
        hand.valid[j] = (flags >> j & 1u) != 0;
        check_joint(hand.joints[j], hand.radius[j], hand.valid[j], place);
    }
    return hand;
}

void put_hand(std::string& bytes, const Hand& hand)
{
    std::uint32_t flags = hand.tracked ? tracked_bit : 0;
    for (int j = 0; j < joint_count; ++j) flags |= hand.valid[j] ? 1u << j : 0;
    put(bytes, flags);
    for (int j = 0; j < joint_count; ++j) {
        const auto& [q, p] = hand.joints[j];
        for (const float x : {p.x, p.y, p.z, q.w, q.x, q.y, q.z, hand.radius[j]}) put(bytes, x);
    }
}

Recording from_binary(const std::string& bytes, const std::string& path)
{
    Reader in(bytes, path);
    in.text(magic_size, "the magic");
    const auto found_version = in.take<std::uint32_t>("the version");
    if (found_version != version)
        in.place(magic_size)
            .refuse(fmt::format("version {}", version), fmt::format("version {}", found_version));
    const std::size_t joints_at = in.offset();
    const auto joints = in.take<std::uint32_t>("the number of joints");
    if (joints != joint_count)
        in.place(joints_at).refuse(fmt::format("{} joints", int(joint_count)),
                                   fmt::format("{}", joints));
    Recording r;
    const std::size_t header_at = in.offset();
    r.rate = in.take<double>("the rate");
    r.latency = in.take<double>("the latency");
    const std::size_t count_at = in.offset();
    const auto count = in.take<std::uint64_t>("the number of frames");
    const auto name_size = in.take<std::uint32_t>("the length of the name");
    r.name = in.text(name_size, "the name");
    check_header(r, in.place(header_at));

    // The frame count is accepted only if it matches the file size exactly.
    const std::size_t left = bytes.size() - in.offset();
    const std::size_t room = left < checksum_size ? 0 : (left - checksum_size) / frame_size;
    if (count != room || left != room * frame_size + checksum_size)
        in.place(count_at).refuse(
            fmt::format("frames of {} bytes and a checksum to fill {} bytes", frame_size, left),
            fmt::format("a count of {}", count));
    const std::size_t end = bytes.size() - checksum_size;
    if (count == 0) in.place(count_at).refuse("at least 1 frame", "0");
    Reader tail(bytes, path);
    tail.text(end, "the frames");
    const auto sum = tail.take<std::uint64_t>("the checksum");
    const std::uint64_t own = XXH64(bytes.data(), end, 0);
    if (sum != own)
        in.place(end).refuse(fmt::format("the checksum {:016x}", own), fmt::format("{:016x}", sum));

    r.frames.reserve(count);
    double before = -1;
    for (std::uint64_t i = 0; i < count; ++i) {
        const Place place = in.place(in.offset());
        HandFrame frame;
        frame.time = in.take<double>("the time");
        check_time(frame.time, before, place);
        before = frame.time;
        for (Hand& hand : frame.hand) hand = take_hand(in);
        r.frames.push_back(frame);
    }
    return r;
}

}  // namespace

void check(const Recording& r)
{
    check_header(r, {r.name, "recording"});
    if (r.frames.empty()) Place{r.name, "recording"}.refuse("at least 1 frame", "0");
    double before = -1;
    for (std::size_t i = 0; i < r.frames.size(); ++i) {
        const Place place{r.name, fmt::format("frame {}", i)};
        check_time(r.frames[i].time, before, place);
        before = r.frames[i].time;
        for (const Hand& hand : r.frames[i].hand)
            for (int j = 0; j < joint_count; ++j)
                check_joint(hand.joints[j], hand.radius[j], hand.valid[j], place);
    }
}

std::string to_binary(const Recording& r)
{
    std::string bytes(magic, magic_size);
    bytes.reserve(64 + r.name.size() + r.frames.size() * frame_size);
    put(bytes, version);
    put(bytes, std::uint32_t(joint_count));
    put(bytes, r.rate);
    put(bytes, r.latency);
    put(bytes, std::uint64_t(r.frames.size()));
    put(bytes, std::uint32_t(r.name.size()));
    bytes += r.name;
    for (const HandFrame& frame : r.frames) {
        put(bytes, frame.time);
        for (const Hand& hand : frame.hand) put_hand(bytes, hand);
    }
    put(bytes, std::uint64_t(XXH64(bytes.data(), bytes.size(), 0)));
    return bytes;
}

Recording from_bytes(const std::string& bytes, const std::string& path)
{
    if (bytes.compare(0, magic_size, magic) == 0) return from_binary(bytes, path);
    if (!bytes.empty() && bytes[0] == '{') return from_lines(bytes, path);
    Place{path, "at byte 0"}.refuse("\"KNHANDS1\" or a JSON object",
                                    bytes.empty() ? "an empty file" : "something else");
}

Recording read_recording(const std::string& path)
{
    return from_bytes(read_text(path, largest_file), path);
}

void write_recording(const std::string& path, const Recording& recording)
{
    const std::string form = ending(path);
    const bool binary = form == ".hands";
    if (!binary && form != ".jsonl")
        throw InputError(fmt::format("{}: expected the ending .hands or .jsonl", path));
    check(recording);
    write_whole(path, binary ? to_binary(recording) : to_lines(recording));
}

}  // namespace knead
