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

// Visits the stored numbers of a frame in the order of the file.
template <class Row, class Visit>
void each_number(Row& r, Visit&& visit)
{
    const auto all = [&](auto&... numbers) { (visit(numbers), ...); };
    const auto vector = [&](auto& v) { all(v.x, v.y, v.z); };
    auto& t = r.stats;
    all(r.frame, r.simulated, r.hand_time, r.hands, r.wall, r.hands_wall, r.surface_wall);
    all(t.substeps, t.dt_min, t.dt_max, t.yielded, t.projected, t.clipped, t.confined, t.repaired);
    all(t.abrupt, t.moved_far, t.clipped_negligible, t.found_depth, t.active_blocks, t.moved,
        t.woken);
    all(t.stranded, t.splats_projected, t.splats_repaired);
    for (auto& count : t.limits) visit(count);
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

Json row_json(const FrameRow& row)
{
    Json numbers = Json::array();
    each_number(row, [&](const auto& number) { numbers.push_back(number); });
    for (const StageTime& s : row.stages) numbers.push_back(s.name), numbers.push_back(s.seconds);
    return numbers;
}

FrameRow row_of(const Json& numbers)
{
    FrameRow row;
    std::size_t at = 0;
    each_number(row, [&](auto& number) { numbers.at(at++).get_to(number); });
    for (; at < numbers.size(); at += 2)
        row.stages.push_back({numbers.at(at).get<std::string>(), numbers.at(at + 1).get<double>()});
    return row;
}

Json depths_json(const DepthCount& depths)
{
    Json bins = Json::array();  // non-empty ones: index, count
    for (std::size_t i = 0; i < depths.bins.size(); ++i)
        if (depths.bins[i]) bins.push_back(i), bins.push_back(depths.bins[i]);
    return {{"count", depths.count}, {"sum", depths.sum}, {"max", depths.max}, {"bins", bins}};
}

DepthCount depths_in(const Json& from)
{
    DepthCount depths;
    depths.count = from.at("count"), depths.sum = from.at("sum"), depths.max = from.at("max");
    const Json& bins = from.at("bins");
    for (std::size_t i = 0; i < bins.size(); i += 2)
        depths.bins.at(bins.at(i).get<std::size_t>()) = bins.at(i + 1);
    return depths;
}

Json triple(Int3 n) { return {n.x, n.y, n.z}; }
Int3 triple_in(const Json& from) { return {from.at(0), from.at(1), from.at(2)}; }

Json facts_json(const Checkpoint& c)
{
    Json rows = Json::array();
    for (const FrameRow& row : c.record.rows) rows.push_back(row_json(row));
    FrameRow before;  // the first frame
    before.state = c.record.first;
    const SavedState& s = c.state;
    return {{"command", c.command},
            {"rows", rows},
            {"before", row_json(before)},
            {"first_mesh_volume", c.record.first_mesh_volume},
            {"depths", depths_json(c.record.depths)},
            {"frames_wanted", c.record.frames_wanted},
            {"wall", c.record.wall},
            {"particles", s.contents.particles.size()},
            {"gaussians", s.contents.gaussians.size()},
            {"splats", c.splats.count()},
            {"still", c.local.cloud.count()},
            {"home", c.local.slot_of.size()},
            {"clay", c.local.clay},
            {"objects", c.local.objects},
            {"splat_degree", c.splats.cloud.degree},
            {"antialiased", c.splats.cloud.antialiased},
            {"quiet", s.quiet.size()},
            {"sliding", s.sliding.size()},
            {"quiet_low", triple(s.quiet_low)},
            {"quiet_stored", triple(s.quiet_stored)},
            {"speed_squared", s.speed_squared},
            {"stiffness", s.stiffness},
            {"drift", s.drift},
            {"covered", s.covered}};
}

// Solvers that can be saved store floats: the file is lossless.
constexpr std::size_t particle_bytes = 22 * sizeof(float) + 2 * sizeof(std::uint32_t);
template <class P, class Visit>
void each_float(P& p, Visit&& visit)
{
    for (auto* v : {&p.x, &p.v, &p.C.a, &p.C.b, &p.C.c}) visit(v->x), visit(v->y), visit(v->z);
    for (auto* e : {&p.e.xx, &p.e.yy, &p.e.zz, &p.e.xy, &p.e.xz, &p.e.yz, &p.k}) visit(*e);
}

constexpr std::size_t sliding_bytes = sizeof(int) + 3 * sizeof(float);
constexpr std::size_t gaussian_bytes = 12 * sizeof(float) + 2 * sizeof(std::uint32_t);
template <class G, class Visit>
void each_float_of(G& g, Visit&& visit)
{
    for (auto* v : {&g.x, &g.F.a, &g.F.b, &g.F.c}) visit(v->x), visit(v->y), visit(v->z);
}

std::string body_of(const Checkpoint& c)
{
    const SavedState& s = c.state;
    std::string body;
    body.reserve(s.contents.particles.size() * (particle_bytes + sizeof(int)) +
                 s.quiet.size() * sizeof(int) + s.sliding.size() * sliding_bytes +
                 s.contents.gaussians.size() * gaussian_bytes +
                 (c.splats.count() + c.local.cloud.count()) *
                     (splat_bytes(c.splats.cloud.degree) + local_bytes));
    for (const Particle<double>& p : s.contents.particles) {
        each_float(p, [&](double number) { append(body, float(number)); });
        append(body, p.object), append(body, p.sides);
    }
    for (int id : s.order) append(body, id);
    for (int frames : s.quiet) append(body, frames);
    for (const SlidingNode& n : s.sliding)
        append(body, n.place), append(body, n.force), append(body, n.time),
            append(body, n.impulse_deficit);
    for (const Gaussian<double>& g : s.contents.gaussians) {
        each_float_of(g, [&](double number) { append(body, float(number)); });
        append(body, g.object), append(body, g.sides);
    }
    append(body, c.splats.cloud);
    for (const float extent : c.splats.extent) append(body, extent);
    append(body, c.local);
    return body;
}

// Numbers of items in the body.
struct Counts {
    std::uint64_t particles, quiet, sliding, gaussians, splats, still, home;
    int degree;

    bool fill(std::uint64_t bytes) const
    {
        constexpr std::uint64_t each = particle_bytes + sizeof(int);
        if (degree < 0 || degree > max_sh_degree) return false;
        const std::uint64_t one = splat_bytes(degree), splat = one + sizeof(float),
                            slot = one + local_bytes;
        if (particles > bytes / each || quiet > bytes / sizeof(int) ||
            sliding > bytes / sliding_bytes || gaussians > bytes / gaussian_bytes ||
            splats > bytes / splat || still > bytes / slot || home > bytes / sizeof(int))
            return false;
        return bytes == particles * each + quiet * sizeof(int) + sliding * sliding_bytes +
                            gaussians * gaussian_bytes + splats * splat + still * slot +
                            home * sizeof(int);
    }
};

void take_body(Checkpoint& c, const Counts& n, const char* from)
{
    SavedState& s = c.state;
    Taker taker{from};
    const auto take_float = [&](double& number) {
        float rounded;
        taker.take(rounded), number = rounded;
    };
    s.contents.gaussians.resize(n.gaussians);
    s.contents.particles.resize(n.particles), s.order.resize(n.particles), s.quiet.resize(n.quiet);
    s.sliding.resize(n.sliding);
    for (Particle<double>& p : s.contents.particles) {
        each_float(p, take_float);
        taker.take(p.object), taker.take(p.sides);
    }
    for (int& id : s.order) taker.take(id);
    for (int& frames : s.quiet) taker.take(frames);
    for (SlidingNode& one : s.sliding)
        taker.take(one.place), taker.take(one.force), taker.take(one.time),
            taker.take(one.impulse_deficit);
    for (Gaussian<double>& g : s.contents.gaussians) {
        each_float_of(g, take_float);
        taker.take(g.object), taker.take(g.sides);
    }
    taker.take(c.splats.cloud, n.splats);
    c.splats.extent.resize(n.splats);
    for (float& extent : c.splats.extent) taker.take_finite(extent);
    taker.take(c.local, n.still, n.home);
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
        refuse(file, fmt::format("expected a checkpoint as long as it says, found {} bytes",
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
        refuse(file, "its facts are not those of a checkpoint");
    return Json::from_cbor(from, to);
}

Checkpoint facts_in(const Json& from)
{
    Checkpoint c;
    c.command = from.at("command");
    for (const Json& row : from.at("rows")) c.record.rows.push_back(row_of(row));
    c.record.first = row_of(from.at("before")).state;
    c.record.first_mesh_volume = from.at("first_mesh_volume");
    c.record.depths = depths_in(from.at("depths"));
    c.record.frames_wanted = from.at("frames_wanted");
    c.record.wall = from.at("wall");
    SavedState& s = c.state;
    s.quiet_low = triple_in(from.at("quiet_low"));
    s.quiet_stored = triple_in(from.at("quiet_stored"));
    s.speed_squared = from.at("speed_squared"), s.stiffness = from.at("stiffness");
    s.drift = from.at("drift"), s.covered = from.at("covered");
    from.at("splat_degree").get_to(c.splats.cloud.degree);
    from.at("antialiased").get_to(c.splats.cloud.antialiased);
    c.local.cloud.degree = c.splats.cloud.degree;
    c.local.cloud.antialiased = c.splats.cloud.antialiased;
    from.at("clay").get_to(c.local.clay), from.at("objects").get_to(c.local.objects);
    return c;
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
    append(whole, std::uint64_t(XXH64(whole.data(), whole.size(), 0)));
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
        const auto count = [&](const char* of) { return all.at(of).get<std::uint64_t>(); };
        const Counts counts{count("particles"), count("quiet"),       count("sliding"),
                            count("gaussians"), count("splats"),      count("still"),
                            count("home"),      c.splats.cloud.degree};
        if (!counts.fill(head.body) || (counts.splats && counts.splats != counts.gaussians))
            refuse(file,
                   fmt::format("expected {} particles, {} blocks, {} Gaussians and {} splats, "
                               "found {} bytes of them",
                               counts.particles, counts.quiet, counts.gaussians, counts.splats,
                               head.body));
        if (!in_order(c.record)) refuse(file, "its frames are not those of a run on its way");
        take_body(c, counts, facts + head.facts);
        return c;
    } catch (const Json::exception& e) {
        refuse(file, std::string("its facts are not those of a checkpoint: ") + e.what());
    } catch (const std::out_of_range&) {
        refuse(file, "its depths or splats are not those of a checkpoint");
    }
}

}  // namespace knead
