#include "host/run/checkpoint.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/cbor.h"
#include "host/base/json_reader.h"
#include "host/session/stored_state_body.h"

namespace knead {
namespace {

constexpr const char* record_schema = "knead.checkpoint/7";
constexpr std::uint64_t state_id = 1;

// Version 6, which is read only.
constexpr std::uint32_t older_version = 6;
struct OlderHead {
    char magic[16];
    std::uint32_t version, reserved;
    std::uint64_t facts, body;  // bytes
};
static_assert(sizeof(OlderHead) == 40);

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

// Calls fact(key, value) for each fact of the run: all that is not in the stored state.
template <class C, class Visit>
void each_fact(C& checkpoint, Visit&& fact)
{
    auto& record = checkpoint.record;
    fact("command", checkpoint.command);
    fact("rows", record.rows);
    fact("before", record.first);
    fact("first_mesh_volume", record.first_mesh_volume);
    fact("depths", record.depths);
    fact("frames_wanted", record.frames_wanted);
    fact("wall", record.wall);
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

[[noreturn]] void refuse(const std::string& file, const std::string& why)
{
    throw InputError(file + ": " + why);
}

// Frames are numbered consecutively from 1, and fewer than wanted.
bool in_order(const RunRecord& record)
{
    for (std::size_t i = 0; i < record.rows.size(); ++i)
        if (record.rows[i].frame != int(i) + 1) return false;
    return !record.rows.empty() && record.rows.size() < std::size_t(record.frames_wanted);
}

// Calls read(), and refuses facts that it does not find or that are of another type.
template <class Read>
Checkpoint with_facts(const std::string& file, const Read& read)
{
    try {
        Checkpoint c = read();
        if (!in_order(c.record)) refuse(file, "its frames are not those of an unfinished run");
        return c;
    } catch (const Json::exception& e) {
        refuse(file, std::string("its header is not that of a checkpoint: ") + e.what());
    } catch (const std::out_of_range&) {
        refuse(file, "its depths or splats are not those of a checkpoint");
    }
}

void take_facts(const Json& from, Checkpoint& c)
{
    each_fact(c, [&](const char* key, auto& value) { take_fact(from.at(key), value); });
}

Json cbor_facts(std::string_view bytes, const std::string& file)
{
    std::optional<Json> facts = parse_cbor(bytes);
    if (!facts) refuse(file, "its header is not that of a checkpoint");
    return *std::move(facts);
}

// Returns the head after checking the whole file's integrity.
OlderHead checked_head(const std::string& file, const std::string& bytes)
{
    OlderHead head{};
    if (bytes.size() < sizeof head + 8) refuse(file, "expected a checkpoint, found its beginning");
    std::memcpy(&head, bytes.data(), sizeof head);
    if (head.version != older_version)
        refuse(file,
               fmt::format("byte 16: expected version {}, found {}", older_version, head.version));
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

Checkpoint older_checkpoint(const std::string& file)
{
    const std::string bytes = read_text(file, std::size_t(1) << 38);
    const OlderHead head = checked_head(file, bytes);
    const char* facts = bytes.data() + sizeof head;
    return with_facts(file, [&] {
        const Json all = cbor_facts({facts, head.facts}, file);
        Checkpoint c;
        take_facts(all, c);
        each_state_fact(c.stored,
                        [&](const char* key, auto& value) { take_fact(all.at(key), value); });
        copy_cloud_facts(c.stored);
        check_lengths(c.stored, all, head.body, file);
        read_body(c.stored, all, facts + head.facts);
        return c;
    });
}

Checkpoint checkpoint_in(const SessionFile& session)
{
    const std::string& file = session.chunks().path();
    const ChunkHead* record = session.run_record();
    if (!record)
        refuse(file,
               "expected a checkpoint of a run, found another session; `knead view` opens it");
    if (!session.chunks().broken_by().empty()) refuse(file, session.chunks().broken_by());
    if (!session.read_only().empty()) refuse(file, session.read_only());
    return with_facts(file, [&] {
        const Json all = cbor_facts(session.chunks().payload(*record), file);
        if (all.at("schema") != record_schema)
            refuse(file, fmt::format("/schema: expected {}, found {}", record_schema,
                                     described(all.at("schema"))));
        Checkpoint c;
        take_facts(all, c);
        c.meta = session.meta(), c.scene = session.scene();
        c.stored = session.state(record->parent);
        if (c.stored.frames != long(c.record.rows.size()))
            refuse(file, "its state is not that after its frames");
        return c;
    });
}

}  // namespace

void write_checkpoint(const std::string& file, const Checkpoint& c)
{
    Json facts = {{"schema", record_schema}};
    each_fact(c, [&](const char* key, const auto& value) { facts[key] = to_fact(value); });
    const std::vector<std::uint8_t> record = Json::to_cbor(facts);
    const std::string_view bytes(reinterpret_cast<const char*>(record.data()), record.size());
    write_chunks(
        {chunk_of(c.meta), chunk_of(c.scene), chunk_of(state_kind, to_bytes(c.stored), state_id),
         chunk_of(run_record_kind, bytes, 0, state_id, chunk_ancillary)},
        file);
}

Checkpoint read_checkpoint(const std::string& file)
{
    const std::string start = read_start(file, 16);
    if (begins_older_checkpoint(start)) return older_checkpoint(file);
    if (!begins_session(start))
        refuse(file, "byte 0: expected a checkpoint of a run, found something else");
    return checkpoint_in(SessionFile(file));
}

bool is_checkpoint(const std::string& file)
{
    return begins_older_checkpoint(read_start(file, 16)) || SessionFile(file).run_record();
}

}  // namespace knead
