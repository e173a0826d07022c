#include "host/run/checkpoint.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/run/checkpoint_body.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is written as memory is");

constexpr char magic[] = "knead.checkpoint";  // 16 bytes, without the 0
constexpr std::uint32_t version = 6;

struct Head {
    char magic[16];
    std::uint32_t version, reserved;
    std::uint64_t facts, body;  // bytes
};
static_assert(sizeof(Head) == 40);

// Calls visit(number) for each number of a frame in the order of the file.
template <class Row, class Visit>
void each_number_of_row(Row& r, Visit&& visit)
{
    const auto all = [&](auto&... numbers) { (visit(numbers), ...); };
    const auto vector = [&](auto& v) { all(v.x, v.y, v.z); };
    all(r.frame, r.simulated, r.hand_time, r.hands, r.wall, r.hands_wall, r.surface_wall);
    each_stored_number(r.stats, visit);
    all(r.audited, r.crowding.particles, r.crowding.most);
    all(r.left.count, r.left.mean, r.left.p99, r.left.max);
    all(r.between.count, r.between.mean, r.between.p99, r.between.max);
    all(r.meshed, r.kept, r.mesh_volume, r.triangles);
    all(r.splats_split, r.splats_added, r.splats_waiting);
    all(r.cubes, r.cubes_activated, r.cubes_frozen);
    auto& a = r.state;
    all(a.mass, a.volume, a.unloaded, a.kinetic, a.elastic, a.fastest, a.broken, a.hash);
    vector(a.momentum), vector(a.spin);
}

// Calls fact(key, value) for each fact except the lengths of the sections.
template <class C, class Visit>
void each_fact(C& checkpoint, Visit&& fact)
{
    auto& [command, record, state, splats, local] = checkpoint;
    fact("command", command);
    fact("rows", record.rows);
    fact("before", record.first);
    fact("first_mesh_volume", record.first_mesh_volume);
    fact("depths", record.depths);
    fact("frames_wanted", record.frames_wanted);
    fact("wall", record.wall);
    fact("quiet_low", state.quiet_low);
    fact("quiet_stored", state.quiet_stored);
    fact("speed_squared", state.speed_squared);
    fact("stiffness", state.stiffness);
    fact("drift", state.drift);
    fact("covered", state.covered);
    fact("splat_degree", splats.cloud.degree);
    fact("antialiased", splats.cloud.antialiased);
    fact("clay", local.clay);
    fact("objects", local.objects);
}

// Conversion of facts to and from JSON.
template <class T>
Json to_fact(const T& value)
{
    return value;
}
template <class T>
void take_fact(const Json& from, T& value)
{
    from.get_to(value);
}
void take_fact(const Json& from, Json& value) { value = from; }

Json to_fact(const Int3& n) { return {n.x, n.y, n.z}; }
void take_fact(const Json& from, Int3& n) { n = {from.at(0), from.at(1), from.at(2)}; }

Json to_fact(const FrameRow& row)
{
    Json numbers = Json::array();
    each_number_of_row(row, [&](const auto& number) { numbers.push_back(number); });
    for (const StageTime& s : row.stages) numbers.push_back(s.name), numbers.push_back(s.seconds);
    return numbers;
}
void take_fact(const Json& numbers, FrameRow& row)
{
    std::size_t at = 0;
    each_number_of_row(row, [&](auto& number) { numbers.at(at++).get_to(number); });
    for (; at < numbers.size(); at += 2)
        row.stages.push_back({numbers.at(at).get<std::string>(), numbers.at(at + 1).get<double>()});
}

Json to_fact(const std::vector<FrameRow>& rows)
{
    Json all = Json::array();
    for (const FrameRow& row : rows) all.push_back(to_fact(row));
    return all;
}
void take_fact(const Json& from, std::vector<FrameRow>& rows)
{
    for (const Json& row : from) take_fact(row, rows.emplace_back());
}

// Stored as a row whose other numbers are 0.
Json to_fact(const Audit& state)
{
    FrameRow row;
    row.state = state;
    return to_fact(row);
}
void take_fact(const Json& from, Audit& state)
{
    FrameRow row;
    take_fact(from, row);
    state = row.state;
}

Json to_fact(const DepthCount& depths)
{
    Json bins = Json::array();  // non-empty ones: index, count
    for (std::size_t i = 0; i < depths.bins.size(); ++i)
        if (depths.bins[i]) bins.push_back(i), bins.push_back(depths.bins[i]);
    return {{"count", depths.count}, {"sum", depths.sum}, {"max", depths.max}, {"bins", bins}};
}
void take_fact(const Json& from, DepthCount& depths)
{
    depths.count = from.at("count"), depths.sum = from.at("sum"), depths.max = from.at("max");
    const Json& bins = from.at("bins");
    for (std::size_t i = 0; i < bins.size(); i += 2)
        depths.bins.at(bins.at(i).get<std::size_t>()) = bins.at(i + 1);
}

Json facts_json(const Checkpoint& c)
{
    Json facts = Json::object();
    each_fact(c, [&](const char* key, const auto& value) { facts[key] = to_fact(value); });
    each_section(c, [&](const char* name, const auto& array) { facts[name] = count_of(array); });
    return facts;
}

Checkpoint facts_in(const Json& from)
{
    Checkpoint c;
    each_fact(c, [&](const char* key, auto& value) { take_fact(from.at(key), value); });
    c.local.cloud.degree = c.splats.cloud.degree;
    c.local.cloud.antialiased = c.splats.cloud.antialiased;
    return c;
}

// Length of a section.
std::uint64_t count_in(const Json& facts, const char* name)
{
    return facts.at(name).get<std::uint64_t>();
}

std::string body_of(const Checkpoint& c)
{
    std::size_t bytes = 0;
    each_section(c, [&](const char*, const auto& array) {
        bytes += count_of(array) * element_bytes(array);
    });
    std::string body;
    body.reserve(bytes);
    NumberWriter write{body};
    each_section(c, [&](const char*, const auto& array) {
        for (std::size_t i = 0; i < count_of(array); ++i) each_number_of(array, i, write);
    });
    return body;
}

// Whether sections of these lengths fill exactly `bytes`. Allocates nothing of their size.
bool fill(const Checkpoint& c, const Json& facts, std::uint64_t bytes)
{
    if (c.splats.cloud.degree < 0 || c.splats.cloud.degree > max_sh_degree) return false;
    bool fits = true;
    each_section(c, [&](const char* name, const auto& array) {
        const std::uint64_t count = count_in(facts, name), each = element_bytes(array);
        fits = fits && count <= bytes / each;
        if (fits) bytes -= count * each;
    });
    return fits && bytes == 0;
}

void take_body(Checkpoint& c, const Json& facts, const char* from)
{
    NumberReader read{from};
    each_section(c, [&](const char* name, auto& array) {
        resize(array, count_in(facts, name));
        for (std::size_t i = 0; i < count_of(array); ++i) each_number_of(array, i, read);
    });
}

[[noreturn]] void refuse(const std::string& file, const std::string& why)
{
    throw InputError(file + ": " + why);
}

// Returns the head after checking the whole file's integrity.
Head checked_head(const std::string& file, const std::string& bytes)
{
    Head head{};
    if (bytes.compare(0, sizeof head.magic, magic) != 0)
        refuse(file, "byte 0: expected a checkpoint of a run, found something else");
    if (bytes.size() < sizeof head + 8) refuse(file, "expected a checkpoint, found its beginning");
    std::memcpy(&head, bytes.data(), sizeof head);
    if (head.version != version)
        refuse(file, fmt::format("byte 16: expected version {}, found {}{}", version, head.version,
                                 head.version > version ? ", of a newer knead" : ""));
    const std::uint64_t rest = bytes.size() - sizeof head - 8;
    if (head.facts > rest || head.body != rest - head.facts)
        refuse(file, fmt::format("expected the length given in the header, found {} bytes",
                                 bytes.size()));
    std::uint64_t hash;
    std::memcpy(&hash, bytes.data() + bytes.size() - 8, 8);
    if (XXH64(bytes.data(), bytes.size() - 8, 0) != hash)
        refuse(file, "damaged: its checksum is not that of its bytes");
    return head;
}

// SAX reader that rejects nesting deeper than that of a checkpoint: from_cbor() recurses once per
// level and would overflow the stack.
struct Depth : nlohmann::json_sax<Json> {
    int now = 0;
    bool down() { return ++now <= 8; }
    bool up() { return --now, true; }
    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(number_integer_t) override { return true; }
    bool number_unsigned(number_unsigned_t) override { return true; }
    bool number_float(number_float_t, const string_t&) override { return true; }
    bool string(string_t&) override { return true; }
    bool binary(binary_t&) override { return true; }
    bool key(string_t&) override { return true; }
    bool start_object(std::size_t) override { return down(); }
    bool start_array(std::size_t) override { return down(); }
    bool end_object() override { return up(); }
    bool end_array() override { return up(); }
    bool parse_error(std::size_t, const std::string&, const Json::exception&) override
    {
        return false;
    }
};

Json facts_of(const std::string& file, const char* from, const char* to)
{
    Depth depth;
    if (!Json::sax_parse(from, to, &depth, Json::input_format_t::cbor))
        refuse(file, "its header is not that of a checkpoint");
    return Json::from_cbor(from, to);
}

// Frames are numbered consecutively from 1, and fewer than wanted.
bool in_order(const RunRecord& record)
{
    for (std::size_t i = 0; i < record.rows.size(); ++i)
        if (record.rows[i].frame != int(i) + 1) return false;
    return !record.rows.empty() && record.rows.size() < std::size_t(record.frames_wanted);
}

}  // namespace

void write_checkpoint(const std::string& file, const Checkpoint& c)
{
    const std::vector<std::uint8_t> facts = Json::to_cbor(facts_json(c));
    const std::string body = body_of(c);
    Head head{{}, version, 0, facts.size(), body.size()};
    std::memcpy(head.magic, magic, sizeof head.magic);
    std::string whole;
    whole.reserve(sizeof head + facts.size() + body.size() + 8);
    whole.append(reinterpret_cast<const char*>(&head), sizeof head);
    whole.append(reinterpret_cast<const char*>(facts.data()), facts.size());
    whole += body;
    NumberWriter{whole}(std::uint64_t(XXH64(whole.data(), whole.size(), 0)));
    write_whole(file, whole);
}

Checkpoint read_checkpoint(const std::string& file)
{
    return parse_checkpoint(read_text(file, std::size_t(1) << 38), file);
}

Checkpoint parse_checkpoint(const std::string& bytes, const std::string& file)
{
    const Head head = checked_head(file, bytes);
    const char* facts = bytes.data() + sizeof head;
    try {
        const Json all = facts_of(file, facts, facts + head.facts);
        Checkpoint c = facts_in(all);
        const auto count = [&](const char* of) { return count_in(all, of); };
        if (!fill(c, all, head.body) ||
            (count("splats") > 0 && count("splats") != count("gaussians")))
            refuse(file,
                   fmt::format("expected {} particles, {} blocks, {} Gaussians and {} splats, "
                               "found {} bytes of them",
                               count("particles"), count("quiet"), count("gaussians"),
                               count("splats"), head.body));
        if (!in_order(c.record)) refuse(file, "its frames are not those of an unfinished run");
        take_body(c, all, facts + head.facts);
        return c;
    } catch (const Json::exception& e) {
        refuse(file, std::string("its header is not that of a checkpoint: ") + e.what());
    } catch (const std::out_of_range&) {
        refuse(file, "its depths or splats are not those of a checkpoint");
    }
}

}  // namespace knead
