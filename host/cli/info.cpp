// knead info: contents of a scene, recording, mesh, report, particle, splat or session file, or of
// a checkpoint.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cuda/math/box.h"
#include "cuda/mpm/material.h"
#include "host/assets/mesh_object.h"
#include "host/assets/splat_object.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"
#include "host/files/file_kind.h"
#include "host/files/mesh_reader.h"
#include "host/files/particle_file.h"
#include "host/files/splat_file.h"
#include "host/hands/filter.h"
#include "host/hands/gesture.h"
#include "host/hands/recording.h"
#include "host/run/checkpoint.h"
#include "host/run/estimate.h"
#include "host/run/report.h"
#include "host/run/run.h"
#include "host/scene/domain.h"
#include "host/scene/foresight.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/scene/soften.h"
#include "host/session/session_file.h"

namespace knead {
namespace {

Json triple(Vec3<double> v) { return {v.x, v.y, v.z}; }

// An estimated count as an integer if it fits, else as a number.
Json whole(double count)
{
    if (!(std::fabs(count) < 0x1p53)) return count;
    return std::llround(count);
}

Json scene_facts(const InfoOptions& o)
{
    Scene scene = read_scene(o.file, o.settings);
    load_meshes(scene);
    const std::vector<SplatObject> splats = load_splats(scene, available_memory());
    std::size_t gaussians = 0;  // Gaussians attached to clay from the start
    for (const SplatObject& s : splats) gaussians += s.local ? 0 : s.cloud.count();
    const Int3 n = scene.setup.lattice.size;
    Json objects = Json::array();
    for (const Object& one : scene.objects) {
        objects.push_back({{"name", one.name},
                           {"material", one.stated.name},
                           {"volume_m3", shape_volume(one)},
                           {"mass_kg", shape_volume(one) * one.material.density},
                           {"sound_m_per_s", sound_speed(one.material)}});
        if (one.softer > 1) objects.back()["softened"] = softened_text(scene, one);
    }
    const Foresight steps = foresee(scene);
    const FrameCost cost = frame_cost(scene, resolved({}), gaussians);
    Json all = {{"kind", "scene"},
                {"name", scene.name},
                {"nodes", {n.x, n.y, n.z}},
                {"spacing_m", scene.setup.lattice.dx},
                {"particles", whole(expected_particles(scene))},
                {"memory_MiB", expected_bytes(scene) / 0x1p20},
                {"clock", scene.clock == ClockMode::paper ? "paper" : "wall"},
                {"dt_s", steps.dt},
                {"substeps", whole(steps.substeps)},
                {"asked_by", steps.key},
                {"frame_wall_s", cost.still || !cost.known ? Json() : Json(cost.seconds)},
                {"objects", objects}};
    if (cost.per_thousand > 0)
        all["frame_wall_s_per_1000_local"] = cost.known ? Json(cost.per_thousand) : Json();
    for (const SplatObject& s : splats) {
        Json& one = all["objects"][std::size_t(s.object)];
        one["splats"] = s.surface, one["splats_inside"] = s.cloud.count() - s.surface;
        one["splats_left_out"] = s.dropped + s.report.clean.dropped() + s.beyond;
        if (!s.remarks.empty()) one["splats_remarks"] = s.remarks;
    }
    if (!scene.has_hands) return all;
    const Recording recording = hands_of(scene);
    const HandSource hands(recording, scene.hands);
    all["hands"] = {{"recording", scene.hands.recording},
                    {"zoom", scene.hands.zoom},
                    {"at_m", triple(scene.hands.at + scene.origin)},
                    {"seconds", hands.duration()},
                    {"frames", frames_wanted(scene, &hands, 0)},
                    {"filter_lag_ms", 1e3 * lag(scene.hands.filter, recording.rate)}};
    return all;
}

Json recording_facts(const std::string& path)
{
    const Recording r = read_recording(path);
    Json all = {{"kind", "recording"},       {"name", r.name},
                {"frames", r.frames.size()}, {"seconds", r.frames.back().time},
                {"rate_per_s", r.rate},      {"latency_ms", 1e3 * r.latency}};
    const char* names[] = {"left", "right"};
    for (Side side : {left, right}) {
        long tracked = 0;
        for (const HandFrame& f : r.frames) tracked += f.hand[side].tracked;
        all["tracked_share"][names[side]] = double(tracked) / double(r.frames.size());
    }
    return all;
}

Json mesh_facts(const std::string& path)
{
    const MeshFile file = read_mesh_file(path);
    Json all = {{"kind", "mesh"}, {"meshes", Json::array()}};
    for (const FileMesh& m : file.meshes) {
        Mesh topology;
        topology.vertices.resize(m.vertices.size()), topology.triangles = m.triangles;
        const Box3<double> box = box_of({m});
        all["meshes"].push_back({{"category", m.category},
                                 {"vertices", m.vertices.size()},
                                 {"triangles", m.triangles.size()},
                                 {"pieces", components(topology)},
                                 {"volume_m3", volume(m)},
                                 {"low_m", triple(box.low)},
                                 {"high_m", triple(box.high)},
                                 {"colours", !m.colours.empty()}});
    }
    if (!file.notes.empty()) all["notes"] = file.notes;
    return all;
}

Json particle_facts(const std::string& path)
{
    const std::vector<Particle<double>> all = read_particles(path);
    Box3<double> box{all[0].x, all[0].x};
    double fastest = 0;
    int objects = 0;
    for (const Particle<double>& q : all) {
        grow(box, q.x);
        fastest = max(fastest, length(q.v));
        objects = max(objects, q.object + 1);
    }
    return {{"kind", "particles"},      {"particles", all.size()},    {"objects", objects},
            {"low_m", triple(box.low)}, {"high_m", triple(box.high)}, {"fastest_m_per_s", fastest}};
}

Json checkpoint_facts(const std::string& path)
{
    const Checkpoint c = read_checkpoint(path);
    Json all = {{"kind", "checkpoint"},
                {"scene", c.command.value("scene", "")},
                {"settings", c.command.value("settings", Json::array())},
                {"device", c.command.value("device", "")},
                {"frames", c.record.rows.size()},
                {"frames_wanted", c.record.frames_wanted},
                {"simulated_s", c.record.rows.back().simulated},
                {"wall_s", c.record.wall},
                {"particles", c.stored.state.contents.particles.size()},
                {"splats", c.stored.splats.count()}};
    if (c.meta.session.empty()) return all;  // of an older version
    all["session"] = c.meta.session, all["program"] = c.meta.program, all["begun"] = c.meta.begun;
    all["simulator"] = c.meta.device, all["deterministic"] = c.meta.deterministic;
    return all;
}

Json session_facts(const std::string& path)
{
    if (is_checkpoint(path)) return checkpoint_facts(path);
    const SessionFile file(path);
    Json objects = Json::array();
    History past(std::size_t(1) << 40);
    file.read_history(past, file.current());
    Json steps = Json::array();
    for (const StepInfo& step : past.list())
        steps.push_back({{"step", step.id},
                         {"after", step.parent},
                         {"label", step.label},
                         {"current", step.current}});
    if (past.count() > 0)
        for (const auto& o : past.current().document->objects)
            objects.push_back({{"id", o->id.value}, {"name", o->name}});
    Json all = {{"kind", "session"},
                {"session", file.meta().session},
                {"program", file.meta().program},
                {"begun", file.meta().begun},
                {"device", file.meta().device},
                {"deterministic", file.meta().deterministic},
                {"real_time", !file.meta().stepped},
                {"scene", file.scene().path},
                {"settings", file.scene().settings},
                {"frames", file.frames()},
                {"hand_frames", file.hands().size()},
                {"states", file.states().size()},
                {"bytes", file.chunks().end()},
                {"objects", objects},
                {"steps", steps}};
    if (!file.read_only().empty()) all["read_only"] = file.read_only();
    if (!file.chunks().broken_by().empty()) all["cut"] = file.chunks().broken_by();
    return all;
}

Json percentiles(std::vector<float> values)
{
    const auto at = [&](double share) {
        const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
        std::nth_element(values.begin(), place, values.end());
        return *place;
    };
    return {{"p1", at(0.01)}, {"p50", at(0.5)}, {"p99", at(0.99)}, {"max", at(1)}};
}

Json splat_facts(const std::string& path)
{
    const SplatFile file = read_splats(path);
    const SplatCloud& cloud = file.cloud;
    Box3<float> box{cloud.centre[0], cloud.centre[0]};
    for (const Vec3<float>& x : cloud.centre) grow(box, x);
    std::vector<float> longest;
    for (const Vec3<float>& s : cloud.scale) longest.push_back(max(s.x, max(s.y, s.z)));
    const SplatRepairs& r = file.repairs;
    Json all = {{"kind", "splats"},
                {"format", file.format},
                {"splats", cloud.count()},
                {"degree", cloud.degree},
                {"antialiased", cloud.antialiased},
                {"low_m", triple(cast<double>(box.low))},
                {"high_m", triple(cast<double>(box.high))},
                {"scale_m", percentiles(longest)},
                {"opacity", percentiles(cloud.opacity)},
                {"dropped", {{"not_finite", r.not_finite}, {"no_rotation", r.no_rotation}}},
                {"mirrored", r.mirrored}};
    if (r.degree_left_out) all["degree_in_file"] = r.degree_left_out;
    if (const auto said = remarks(file); !said.empty()) all["remarks"] = said;
    return all;
}

std::string lines(const Json& value, const std::string& indent)
{
    std::string text;
    for (const auto& [key, entry] : value.items()) {
        const bool nested =
            entry.is_object() || (entry.is_array() && !entry.empty() && entry[0].is_object());
        const std::string said = entry.is_string()
                                     ? entry.get<std::string>()
                                     : entry.dump(-1, ' ', false, Json::error_handler_t::replace);
        text += indent + fmt::format("{:<16}", key) + (nested ? "" : " " + said) + "\n";
        if (nested) text += lines(entry, indent + "  ");
    }
    return text;
}

}  // namespace

int info_verb(const InfoOptions& given)
{
    InfoOptions o = given;
    o.file = with_form(o.file);
    const FileKind kind = file_kind(o.file);
    if (kind != FileKind::scene && (!o.settings.empty() || o.cells > 0))
        throw UsageError("--set and --cells: only for scenes");
    if (o.cells > 0) o.settings.push_back(cells_setting(read_json(o.file), o.cells));
    Json facts;
    if (kind == FileKind::report) {
        const Json root = read_json(o.file);
        if (!o.json) {
            check_report(root, o.file);
            print(summary(root));
            return exit_ok;
        }
        facts = root;
    }
    if (kind == FileKind::scene) facts = scene_facts(o);
    if (kind == FileKind::recording) facts = recording_facts(o.file);
    if (kind == FileKind::mesh) facts = mesh_facts(o.file);
    if (kind == FileKind::particles) facts = particle_facts(o.file);
    if (kind == FileKind::splats) facts = splat_facts(o.file);
    if (kind == FileKind::session) facts = session_facts(o.file);
    print(o.json ? facts.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"
                 : lines(facts, ""));
    return exit_ok;
}

}  // namespace knead
