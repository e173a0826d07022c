#include "host/run/report.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/solver/frame_stats.h"

namespace knead {
namespace {

Json milliseconds(const std::vector<double>& seconds)
{
    const Spread s = spread(seconds);
    return {{"median_ms", 1e3 * s.median},
            {"p95_ms", 1e3 * s.p95},
            {"mean_ms", 1e3 * s.mean},
            {"max_ms", 1e3 * s.max},
            {"samples", seconds.size()}};
}

struct Stage {
    std::string name;
    std::vector<double> seconds;
};

// Times per stage over the frames that have them, in the order of the frame.
std::vector<Stage> stages(const RunRecord& record)
{
    std::vector<Stage> all;
    const auto add = [&](const std::string& name, double seconds) {
        for (Stage& s : all)
            if (s.name == name) return s.seconds.push_back(seconds);
        all.push_back({name, {seconds}});
    };
    for (const FrameRow& row : record.rows) {
        add("hands", row.hands_wall);
        for (const StageTime& s : row.stages) add(s.name, s.seconds);
        if (row.meshed) add("surface", row.surface_wall);
    }
    return all;
}

std::vector<double> frame_seconds(const RunRecord& record)
{
    std::vector<double> all;
    for (const FrameRow& row : record.rows) all.push_back(row.wall);
    return all;
}

FrameStats stats_of(const RunRecord& record)
{
    FrameStats all;
    for (const FrameRow& row : record.rows) add_to(all, row.stats);
    return all;
}

long total(const RunRecord& record, long FrameRow::*part)
{
    long sum = 0;
    for (const FrameRow& row : record.rows) sum += row.*part;
    return sum;
}

long largest(const RunRecord& record, long FrameRow::*part)
{
    long most = 0;
    for (const FrameRow& row : record.rows) most = std::max(most, row.*part);
    return most;
}

Json context(const Scene& scene, const RunInfo& facts)
{
    Json all = machine_facts(facts.solver.starts_with("cuda"));
    all.update({{"executable", "knead run"},
                {"json_schema_version", 1},
                {"device", facts.solver},
                {"threads_asked", facts.threads},
                {"scene", scene.path},
                {"scene_hash", file_hash(scene.path)},
                {"settings", facts.settings},
                {"hands", scene.has_hands ? scene.hands.recording : ""},
                {"hands_hash", scene.has_hands ? file_hash(scene.hands.recording) : ""},
                {"seed", scene.seed},
                {"deterministic", scene.setup.deterministic}});
    return all;
}

Json benchmark_row(const std::string& name, const Spread& s, std::size_t iterations)
{
    return {{"name", name},
            {"run_name", name},
            {"run_type", "iteration"},
            {"repetitions", 1},
            {"repetition_index", 0},
            {"iterations", iterations},
            {"time_unit", "ms"},
            {"real_time", 1e3 * s.median},
            {"p95", 1e3 * s.p95}};
}

Json runs(const Scene& scene, const RunRecord& record, const RunInfo& facts)
{
    const std::vector<double> frames = frame_seconds(record);
    Json all = Json::array();
    Json frame = benchmark_row(scene.name + "/frame", spread(frames), frames.size());
    double wall = 0;
    for (double s : frames) wall += s;
    if (!frames.empty()) frame["cpu_time"] = 1e3 * facts.cpu_seconds / double(frames.size());
    const double steps = double(record.particles) * double(stats_of(record).substeps);
    frame["items_per_second"] = wall > 0 ? steps / wall : 0;  // particle-substeps
    all.push_back(frame);
    for (const Stage& s : stages(record))
        all.push_back(
            benchmark_row(scene.name + "/stage/" + s.name, spread(s.seconds), s.seconds.size()));
    return all;
}

Json vector(Vec3<double> v) { return {v.x, v.y, v.z}; }

template <class T>
requires std::is_arithmetic_v<T> Json reported(T value, double scale)
{
    if constexpr (std::is_floating_point_v<T>) return scale * value;
    return value;
}
Json reported(const long (&limits)[int(Limit::count)], double)
{
    Json by = Json::object();
    for (int l = 0; l < int(Limit::count); ++l) by[limit_names[l]] = limits[l];
    return by;
}

// Adds the statistics of all frames to the objects that `knead` has.
void add_statistics(Json& knead, const FrameStats& all)
{
    each_statistic([&](const auto& row) {
        const Json::json_pointer to(row.report);
        if (!to.empty() && knead.contains(to.parent_pointer()))
            knead[to] = reported(all[row.member], row.scale);
    });
}

Json substeps_per_frame(const RunRecord& record)
{
    std::vector<double> per_frame;
    for (const FrameRow& row : record.rows) per_frame.push_back(row.stats.substeps);
    const Spread s = spread(per_frame);
    return {{"median", s.median}, {"p95", s.p95}, {"max", s.max}};
}

// Momentum from walls and tools: the change of momentum without that by gravity.
Json momentum(const Scene& scene, const RunRecord& record, const FrameRow& last)
{
    const Vec3<double> gravity = (record.first.mass * last.simulated) * scene.setup.gravity;
    const Vec3<double> change = last.state.momentum - record.first.momentum;
    return {{"first_kg_m_per_s", vector(record.first.momentum)},
            {"last_kg_m_per_s", vector(last.state.momentum)},
            {"by_gravity_kg_m_per_s", vector(gravity)},
            {"by_walls_and_tools_kg_m_per_s", vector(change - gravity)},
            {"spin_first_kg_m2_per_s", vector(record.first.spin)},
            {"spin_last_kg_m2_per_s", vector(last.state.spin)}};
}

double drift(double first, double last) { return first > 0 ? last / first - 1 : 0; }

// The worst over all audited frames.
Crowding crowding_of(const RunRecord& record)
{
    Crowding worst;
    for (const FrameRow& row : record.rows) {
        worst.particles = std::max(worst.particles, row.crowding.particles);
        worst.most = std::max(worst.most, row.crowding.most);
    }
    return worst;
}

Json volumes(const RunRecord& record, const FrameRow& last)
{
    Json v = {{"first_m3", record.first.volume},
              {"last_m3", last.state.volume},
              {"drift", drift(record.first.volume, last.state.volume)},
              {"plastic_drift", drift(record.first.unloaded, last.state.unloaded)}};
    v["elastic_drift"] = drift(record.first.volume / std::max(record.first.unloaded, 1e-300),
                               last.state.volume / std::max(last.state.unloaded, 1e-300));
    v["most_crowded"] = crowding_of(record).most;
    if (record.first_mesh_volume < 0 || !last.meshed) return v;
    v["mesh_first_m3"] = record.first_mesh_volume;
    v["mesh_last_m3"] = last.mesh_volume;
    v["mesh_drift"] = drift(record.first_mesh_volume, last.mesh_volume);
    v["triangles"] = last.triangles;
    return v;
}

const char* rest_name(RestMode mode)
{
    return mode == RestMode::none ? "none" : mode == RestMode::sleep ? "sleep" : "localized";
}

Json guards(const RunRecord& record, const FrameStats& stats)
{
    Json all;
    for (const auto& [name, count] : frame_guards) all[name] = stats[count];
    all["crowded"] = crowding_of(record).particles;
    return all;
}

Json physics(const Scene& scene, const RunRecord& record, const FrameStats& stats)
{
    static const FrameRow none;
    const FrameRow* last = &none;
    for (const FrameRow& row : record.rows)
        if (row.audited) last = &row;
    double active = 0;
    Depths between;
    for (const FrameRow& row : record.rows) {
        between.count = std::max(between.count, row.between.count);
        between.max = std::max(between.max, row.between.max);
        active += double(row.stats.active_blocks) / scene.setup.lattice.block_count();
    }
    const double particle_steps = double(record.particles) * double(stats.substeps);
    const Depths& left = record.left;
    return {
        {"simulated_s", last->simulated},
        {"time", {{"substeps_per_frame", substeps_per_frame(record)}}},
        {"particles", record.particles},
        {"active_block_share", record.rows.empty() ? 0 : active / double(record.rows.size())},
        {"bytes", record.bytes},
        {"mass",
         {{"first_kg", record.first.mass},
          {"last_kg", last->state.mass},
          {"exact", record.first.mass == last->state.mass}}},
        {"volume", volumes(record, *last)},
        {"momentum", momentum(scene, record, *last)},
        {"energy",
         {{"kinetic_J", last->state.kinetic},
          {"elastic_J", last->state.elastic},
          {"kinetic_first_J", record.first.kinetic},
          {"elastic_first_J", record.first.elastic}}},
        {"fastest_m_per_s", last->state.fastest},
        {"yielded_share", particle_steps > 0 ? double(stats[Count::yielded]) / particle_steps : 0},
        {"rest",
         {{"mode", rest_name(scene.setup.rest.mode)}, {"moved_share", moved_share(record)}}},
        {"penetration",
         {{"left_mean_mm", 1e3 * left.mean},
          {"left_p99_mm", 1e3 * left.p99},
          {"left_max_mm", 1e3 * left.max},
          {"left_count", left.count},
          {"between_max_mm", 1e3 * between.max},
          {"between_most", between.count}}},
        {"guards", guards(record, stats)},
        {"state_hash", hexadecimal(last->state.hash)}};
}

}  // namespace

std::string file_hash(const std::string& path)
{
    try {
        const std::string text = read_text(path, std::size_t(1) << 30);
        return hexadecimal(XXH64(text.data(), text.size(), 0));
    } catch (const InputError&) {
        return "";
    }
}

const char* end_name(End end)
{
    switch (end) {
        case End::complete:
            return "complete";
        case End::interrupted:
            return "interrupted";
        case End::time_limit:
            return "time limit";
        case End::substeps:
            return "substeps";
        case End::refused:
            return "command refused";
        case End::numerical_failure:
            return "numerical failure";
        case End::device:
            break;
    }
    return "device lost";
}

Spread spread(std::vector<double> values)
{
    Spread s;
    if (values.empty()) return s;
    std::sort(values.begin(), values.end());
    const double n = double(values.size());
    const auto rank = [&](double share) {
        return values[std::size_t(std::max(1.0, std::ceil(share * n - 1e-9))) - 1];
    };
    for (double v : values) s.mean += v / n;
    s.median = rank(0.5), s.p95 = rank(0.95), s.max = values.back();
    return s;
}

namespace {

// What was not computed: as known before the run, and as found in it.
std::vector<std::string> left_out_of(const RunRecord& record, const RunInfo& facts)
{
    std::vector<std::string> all = facts.left_out;
    if (record.pictures_missing > 0)
        all.push_back(fmt::format("pictures: {} could not be made; the first, {}",
                                  record.pictures_missing, record.no_picture));
    return all;
}

}  // namespace

std::vector<ObjectFacts> object_facts(const Document& document,
                                      const std::function<std::vector<int>(ObjectId)>& simulated,
                                      const std::vector<Particle<double>>& particles,
                                      const std::vector<Material<double>>& materials)
{
    std::vector<ObjectFacts> all;
    std::map<int, std::size_t> of_number;
    std::optional<std::size_t> paged;
    for (const auto& o : document.objects) {
        if (o->source.splats.depth > 0) paged = all.size();
        for (const int number : simulated(o->id)) of_number[number] = all.size();
        all.push_back({o->id, o->name, o->category});
    }
    for (const Particle<double>& p : particles) {
        const auto found = of_number.find(p.object);
        if (found == of_number.end() && !paged) continue;
        ObjectFacts& sum = all[found == of_number.end() ? *paged : found->second];
        const Material<double>& m = materials[std::size_t(p.object)];
        ++sum.particles;
        sum.mass += m.mass;
        sum.volume += m.volume * std::exp(log_volume_ratio(p, m));
        sum.box = {lesser(sum.box.low, p.x), greater(sum.box.high, p.x)};
    }
    return all;
}

namespace {

Json json_of(const ObjectFacts& o)
{
    const Vec3<double> low = o.box.low, high = o.box.high;
    return {
        {"id", o.id.value},
        {"name", o.name},
        {"category", o.category},
        {"particles", o.particles},
        {"mass_kg", o.mass},
        {"volume_m3", o.volume},
        {"box_m", o.particles ? Json{{low.x, low.y, low.z}, {high.x, high.y, high.z}} : Json()}};
}

}  // namespace

Json report(const Scene& scene, const RunRecord& record, const RunInfo& facts)
{
    Json stage_block = Json::object();
    for (const Stage& s : stages(record)) stage_block[s.name] = milliseconds(s.seconds);
    const FrameStats stats = stats_of(record);
    Json knead = physics(scene, record, stats);
    knead["end"] = end_name(record.end);
    if (!record.failure.empty()) knead["trouble"] = record.failure;
    if (!record.rows.empty() && record.rows.back().stats.cut) {
        const FrameRow& last = record.rows.back();
        knead["cut"] = {{"frame", last.frame},
                        {"reached_s", last.stats.reached},
                        {"substeps", last.stats.substeps}};
    }
    knead["frames"] = record.rows.size();
    knead["frames_wanted"] = record.frames_wanted;
    knead["clock"] = scene.clock == ClockMode::paper ? "paper" : "wall";
    knead["frame_s"] = record.duration;
    knead["wall_s"] = record.wall;
    knead["frame"] = milliseconds(frame_seconds(record));
    knead["stages"] = stage_block;
    if (const Json softened = softened_facts(scene); !softened.empty())
        knead["softened"] = softened;
    knead["document"]["objects"] = Json::array();
    for (const ObjectFacts& o : facts.objects) knead["document"]["objects"].push_back(json_of(o));
    if (facts.history)
        knead["history"] = {{"steps", facts.history->steps},
                            {"bytes", facts.history->bytes},
                            {"current", facts.history->current}};
    knead["left_out"] = left_out_of(record, facts);
    knead["outputs"] = facts.outputs;
    if (facts.splats > 0)
        knead["splats"] = {{"count", facts.splats},
                           {"inside", facts.inside},
                           {"split", total(record, &FrameRow::splats_split)},
                           {"added", total(record, &FrameRow::splats_added)},
                           {"waiting_most", largest(record, &FrameRow::splats_waiting)}};
    if (facts.local)
        knead["local"] = {{"cubes_most", largest(record, &FrameRow::cubes)},
                          {"taken", total(record, &FrameRow::cubes_activated)},
                          {"given_back", total(record, &FrameRow::cubes_frozen)}};
    if (facts.hand_rate > 0) {
        long with = 0;
        for (const FrameRow& row : record.rows) with += row.hands;
        knead["hands"] = {{"frames_active", with},
                          {"rate_per_s", facts.hand_rate},
                          {"tracker_latency_ms", 1e3 * facts.hand_latency},
                          {"filter_lag_ms", 1e3 * lag(scene.hands.filter, facts.hand_rate)}};
    }
    add_statistics(knead, stats);
    return {{"schema", "knead.report/1"},
            {"context", context(scene, facts)},
            {"runs", runs(scene, record, facts)},
            {"knead", knead}};
}

namespace {

template <class T>
std::string csv_text(const T& value, double scale)
{
    if constexpr (std::is_floating_point_v<T>) return fmt::format("{:.6g}", scale * value);
    if constexpr (std::is_integral_v<T>) return fmt::format("{:d}", value);
    return "";  // an array: has no column
}

// The statistics' columns of frames.csv, each with a comma behind it. `text(row)`: of a column.
template <class Text>
std::string statistic_columns_of(Text&& text)
{
    std::string columns[statistic_columns + 1];
    each_statistic([&](const auto& row) {
        if (row.column > 0) columns[row.column] = text(row) + ",";
    });
    std::string all;
    for (const std::string& column : columns) all += column;
    return all;
}

}  // namespace

std::string frames_csv(const RunRecord& record)
{
    std::string out = "frame,simulated_s,hand_s,hands,solver_ms,surface_ms,";
    out += statistic_columns_of([](const auto& row) { return std::string(row.name); });
    out +=
        "kinetic_J,elastic_J,volume_m3,fastest_m_per_s,left_mean_mm,left_p99_mm,left_max_mm,"
        "mesh_m3,triangles,hash\n";
    for (const FrameRow& r : record.rows) {
        out += fmt::format("{},{:.9g},{:.9g},{:d},{:.6g},{:.6g},", r.frame, r.simulated,
                           r.hand_time, r.hands, 1e3 * r.wall, 1e3 * r.surface_wall);
        out += statistic_columns_of(
            [&](const auto& row) { return csv_text(r.stats[row.member], row.scale); });
        if (r.audited)
            out += fmt::format("{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g},{:.6g},", r.state.kinetic,
                               r.state.elastic, r.state.volume, r.state.fastest, 1e3 * r.left.mean,
                               1e3 * r.left.p99, 1e3 * r.left.max);
        else
            out += ",,,,,,,";
        out += r.meshed ? fmt::format("{:.9g},{},", r.mesh_volume, r.triangles) : ",,";
        out += (r.audited ? hexadecimal(r.state.hash) : "") + "\n";
    }
    return out;
}

}  // namespace knead
