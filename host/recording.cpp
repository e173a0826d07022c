#include "recording.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

namespace knead {
namespace {

using json = nlohmann::json;

constexpr char magic[] = "KNHANDS1";
constexpr std::size_t magic_size = 8, checksum_size = 8;
constexpr std::uint32_t version = 1;
constexpr std::uint32_t tracked_bit = 1u << 31;  // below it one bit per joint: valid
constexpr std::size_t joint_size = 8 * 4;        // position, quaternion, radius
constexpr std::size_t frame_size = 8 + side_count * (4 + joint_count * joint_size);
constexpr std::uintmax_t largest_file = std::uintmax_t(1) << 30;  // [bytes]: five hours of 30 Hz
constexpr std::size_t longest_name = 100, longest_line = 1 << 16;

constexpr const char* side_names[side_count] = {"left", "right"};

// Says where in its file a thing stands: "at byte 12" or "in line 3".
struct Place {
    std::string path, at;
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const
    {
        throw InputError(fmt::format("{}: {}: expected {}, found {}", path, at, expected, found));
    }
};

// What is asked of each value, whichever form it came from.
void check_header(const Recording& r, const Place& place)
{
    if (r.name.empty() || r.name.size() > longest_name)
        place.refuse(fmt::format("a name of 1 to {} characters", longest_name),
                     fmt::format("{}", r.name.size()));
    for (const unsigned char letter : r.name)
        if (letter < 0x20 || letter > 0x7e)
            place.refuse("a name of printable ASCII", fmt::format("the byte {:#04x}", letter));
    if (!(r.rate > 0 && r.rate <= 1000))
        place.refuse("a rate above 0 and at most 1000 Hz", fmt::format("{}", r.rate));
    if (!(r.latency >= 0 && r.latency <= 10))
        place.refuse("a latency of 0 to 10 s", fmt::format("{}", r.latency));
}

void check_time(double time, double before, const Place& place)
{
    if (!(time >= 0 && time <= 1e5))
        place.refuse("a time of 0 to 100000 s", fmt::format("{}", time));
    if (!(time > before))
        place.refuse(fmt::format("a time after {} s", before), fmt::format("{} s", time));
}

void check_joint(const Joint<float>& joint, float radius, bool valid, const Place& place)
{
    for (const float x : {joint.p.x, joint.p.y, joint.p.z})
        if (!(std::abs(x) <= 100)) place.refuse("a position within 100 m", fmt::format("{}", x));
    const double w = joint.q.w, x = joint.q.x, y = joint.q.y, z = joint.q.z;
    const double square = w * w + x * x + y * y + z * z;
    const bool unseen = !valid && square == 0;
    if (!(std::abs(square - 1) <= 2e-3) && !unseen)
        place.refuse("a unit quaternion", fmt::format("({}, {}, {}, {})", w, x, y, z));
    if (!(radius >= 0 && radius <= 1))
        place.refuse("a radius of 0 to 1 m", fmt::format("{}", radius));
}

// Little-endian on every machine.
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

    // The count is believed only where it explains the size of the file to the byte.
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

// One number of a JSON line, in the fewest digits that read back as the same number.
template <class R>
void put_number(std::string& line, R x)
{
    char digits[32];
    line.append(digits, std::to_chars(digits, digits + sizeof digits, x).ptr);
}

const json& member(const json& object, const char* key, const Place& place)
{
    const auto found = object.find(key);
    if (found == object.end()) place.refuse(fmt::format("the key \"{}\"", key), "none");
    return *found;
}

double number(const json& value, const char* what, const Place& place)
{
    if (!value.is_number()) place.refuse(fmt::format("a number for {}", what), value.type_name());
    return value.get<double>();
}

json parse_object(const std::string& line, std::size_t keys, const Place& place)
{
    json object = json::parse(line, nullptr, false);
    if (!object.is_object())
        place.refuse("a JSON object", object.is_discarded() ? "no JSON" : object.type_name());
    if (object.size() != keys)
        place.refuse(fmt::format("{} keys", keys), fmt::format("{}", object.size()));
    return object;
}

Hand parse_hand(const json& object, const char* side, const Place& place)
{
    if (!object.is_object() || object.size() != 2)
        place.refuse(fmt::format("an object with \"tracked\" and \"joints\" for {}", side),
                     object.type_name());
    Hand hand;
    const json& tracked = member(object, "tracked", place);
    if (!tracked.is_boolean()) place.refuse("true or false for \"tracked\"", tracked.type_name());
    hand.tracked = tracked.get<bool>();
    const json& rows = member(object, "joints", place);
    if (!rows.is_array() || rows.size() != joint_count)
        place.refuse(fmt::format("{} joints for {}", int(joint_count), side),
                     fmt::format("{} of {}", rows.type_name(), rows.size()));
    for (int j = 0; j < joint_count; ++j) {
        const json& row = rows[j];
        if (!row.is_array() || row.size() != 9)
            place.refuse("9 numbers for a joint",
                         fmt::format("{} of {}", row.type_name(), row.size()));
        float v[9];
        for (int k = 0; k < 9; ++k) v[k] = float(number(row[k], "a joint", place));
        if (v[8] != 0 && v[8] != 1) place.refuse("validity 0 or 1", fmt::format("{}", v[8]));
        hand.joints[j] = {{v[3], v[4], v[5], v[6]}, {v[0], v[1], v[2]}};
        hand.radius[j] = v[7];
        hand.valid[j] = v[8] == 1;
        check_joint(hand.joints[j], hand.radius[j], hand.valid[j], place);
    }
    return hand;
}

Recording from_lines(const std::string& bytes, const std::string& path)
{
    Recording r;
    std::size_t begin = 0, line_number = 0, count = 0;
    double before = -1;
    const auto place = [&] { return Place{path, fmt::format("in line {}", line_number)}; };
    while (begin < bytes.size()) {
        const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
        ++line_number;
        if (end - begin > longest_line)
            place().refuse(fmt::format("at most {} characters", longest_line),
                           fmt::format("{}", end - begin));
        const std::string line = bytes.substr(begin, end - begin);
        begin = end + 1;
        if (line_number == 1) {
            const json header = parse_object(line, 5, place());
            const json& format = member(header, "format", place());
            if (format != "knead.hands/1") place().refuse("\"knead.hands/1\"", format.dump());
            const json& name = member(header, "name", place());
            if (!name.is_string()) place().refuse("a string for \"name\"", name.type_name());
            r.name = name.get<std::string>();
            r.rate = number(member(header, "rate", place()), "\"rate\"", place());
            r.latency = number(member(header, "latency", place()), "\"latency\"", place());
            const json& frames = member(header, "frames", place());
            if (!frames.is_number_unsigned() || frames.get<std::uint64_t>() == 0)
                place().refuse("at least 1 frame", frames.dump());
            count = frames.get<std::uint64_t>();
            check_header(r, place());
            continue;
        }
        if (r.frames.size() == count) place().refuse("the end of the file", "another line");
        const json object = parse_object(line, 3, place());
        HandFrame frame;
        frame.time = number(member(object, "time", place()), "\"time\"", place());
        check_time(frame.time, before, place());
        before = frame.time;
        for (int s = 0; s < side_count; ++s)
            frame.hand[s] =
                parse_hand(member(object, side_names[s], place()), side_names[s], place());
        r.frames.push_back(frame);
    }
    if (r.frames.size() != count || count == 0)
        place().refuse(fmt::format("{} frames in all", count), fmt::format("{}", r.frames.size()));
    return r;
}

bool ends_with(const std::string& text, const std::string& ending)
{
    return text.size() >= ending.size() &&
           text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
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

std::string to_lines(const Recording& r)
{
    std::string text = R"({"format":"knead.hands/1","name":)" + json(r.name).dump() + R"(,"rate":)";
    put_number(text, r.rate);
    put_number(text += R"(,"latency":)", r.latency);
    text += fmt::format(",\"frames\":{}}}\n", r.frames.size());
    for (const HandFrame& frame : r.frames) {
        put_number(text += R"({"time":)", frame.time);
        for (int s = 0; s < side_count; ++s) {
            const Hand& hand = frame.hand[s];
            text += fmt::format(R"(,"{}":{{"tracked":{},"joints":[)", side_names[s], hand.tracked);
            for (int j = 0; j < joint_count; ++j) {
                const auto& [q, p] = hand.joints[j];
                text += j == 0 ? "[" : ",[";
                for (const float x : {p.x, p.y, p.z, q.w, q.x, q.y, q.z, hand.radius[j]}) {
                    put_number(text, x);
                    text += ',';
                }
                text += hand.valid[j] ? "1]" : "0]";
            }
            text += "]}";
        }
        text += "}\n";
    }
    return text;
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
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error)
        throw InputError(fmt::format("{}: expected a recording, found: {}", path, error.message()));
    if (size > largest_file)
        throw InputError(
            fmt::format("{}: expected at most {} bytes, found {}", path, largest_file, size));
    std::string bytes(size, '\0');
    std::ifstream in(path, std::ios::binary);
    in.read(bytes.data(), std::streamsize(size));
    if (!in)
        throw InputError(fmt::format("{}: expected {} bytes, could not read them", path, size));
    return from_bytes(bytes, path);
}

void write_recording(const std::string& path, const Recording& recording)
{
    const bool binary = ends_with(path, ".hands");
    if (!binary && !ends_with(path, ".jsonl"))
        throw InputError(fmt::format("{}: expected the ending .hands or .jsonl", path));
    check(recording);
    const std::string bytes = binary ? to_binary(recording) : to_lines(recording);
    const std::string beside = path + ".partial";
    std::error_code error;
    {
        std::ofstream out(beside, std::ios::binary | std::ios::trunc);
        out.write(bytes.data(), std::streamsize(bytes.size()));
        out.close();
        if (!out) error = std::make_error_code(std::errc::io_error);
    }
    if (!error) std::filesystem::rename(beside, path, error);
    if (!error) return;
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw std::runtime_error(fmt::format("{}: could not be written: {}", path, error.message()));
}

}  // namespace knead
