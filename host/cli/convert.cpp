// knead convert: meshes, recordings, particles and splats from one format to another; hands and
// clay of sessions.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"
#include "host/document/export_plan.h"
#include "host/files/file_kind.h"
#include "host/files/mesh_file.h"
#include "host/files/mesh_reader.h"
#include "host/files/particle_file.h"
#include "host/files/splat_file.h"
#include "host/hands/recording.h"
#include "host/scene/scene.h"
#include "host/session/session_file.h"
#include "host/surface/mesh.h"

namespace knead {
namespace {

void check_ending(const std::string& out, const std::vector<std::string>& allowed, const char* of)
{
    const std::string form = ending(out);
    std::string all;
    for (const std::string& a : allowed) {
        if (a == form) return;
        all += (all.empty() ? "" : ", ") + a;
    }
    throw UsageError(fmt::format("{}: {} can be written as {}", out, of, all));
}

// Converts splats; reports what is lost.
void convert_splats(const ConvertOptions& o)
{
    check_ending(o.out, {".ply", ".splat", ".spz", ".sog", ".glb"}, "splats");
    const SplatFile file = read_splats(o.in);
    prepare_file(o.out, o.overwrite);
    write_splats(o.out, file.cloud, o.spz_version);
    if (o.quiet) return;
    for (const std::string& remark : remarks(file)) fmt::print(stderr, "{}: {}\n", o.in, remark);
    for (const std::string& loss : losses(file.cloud, o.out))
        fmt::print(stderr, "{}: {}\n", o.out, loss);
}

// Hands, or the clay at the end, in the frame of the scene's file.
void convert_session(const ConvertOptions& o)
{
    check_ending(o.out, {".hands", ".jsonl", ".glb", ".obj", ".ply", ".stl", ".csv"}, "a session");
    const SessionFile file(o.in);
    const std::string form = ending(o.out);
    if (form == ".hands" || form == ".jsonl") {
        const Recording recording = file.recording();
        prepare_file(o.out, o.overwrite);
        return write_recording(o.out, recording);
    }
    const Scene scene = parse_scene(file.scene().text, file.scene().path, file.scene().settings);
    SessionFile::Clay clay = file.clay();
    if (form == ".csv" || form == ".ply") {
        for (Particle<double>& q : clay.particles) q.x = q.x + scene.origin;
        prepare_file(o.out, o.overwrite);
        return write_particles(o.out, clay.particles);
    }
    std::vector<Mesh> meshes = surface(clay.particles, clay.materials, scene.surface);
    move_by(meshes, scene.origin);
    prepare_file(o.out, o.overwrite);
    write_mesh(o.out, meshes);
}

// Scales in double, and keeps colours. Says what the format has no room for.
void convert_mesh(const ConvertOptions& o)
{
    check_ending(o.out, {".glb", ".obj", ".ply", ".stl", ".3mf"}, "a mesh");
    MeshFile file = read_mesh_file(o.in);
    LengthUnit unit = ending(o.out) == ".3mf" ? LengthUnit::millimetre : LengthUnit::metre;
    for (const auto& [name, one] : length_units)
        if (name == o.unit) unit = one;
    const double scale = o.scale * per_metre(unit);
    MeshLabels labels{{}, plural(unit)};
    bool coloured = false;
    for (FileMesh& mesh : file.meshes) {
        for (Vec3<double>& v : mesh.vertices) v = scale * v;
        if (ending(o.out) == ".3mf")
            labels.names.push_back(mesh.name.empty() ? fmt::format("category {}", mesh.category)
                                                     : mesh.name);
        coloured = coloured || !mesh.colours.empty();
    }
    const Box3<double> box = box_of(file.meshes);
    const Vec3<double> far = greater(box.high, -1.0 * box.low);
    const double steps = std::max({far.x, far.y, far.z}) * 0x1p-24 / longest_edge(box);
    if (coloured && ending(o.out) == ".stl")
        file.notes.push_back("colours left out: .stl has none");
    if (steps > 1e-4)
        file.notes.push_back(
            fmt::format("written in single precision, far from the origin: places are rounded to "
                        "{:.2g} of its extent",
                        steps));
    const std::vector<Mesh> meshes = float_meshes(file, o.in);
    prepare_file(o.out, o.overwrite);
    write_mesh(o.out, meshes, labels);
    for (const std::string& note : file.notes)
        if (!o.quiet) fmt::print(stderr, "{}: {}\n", o.in, note);
}

}  // namespace

int convert_verb(const ConvertOptions& given)
{
    ConvertOptions o = given;
    o.in = with_form(o.in, o.from);
    if (o.out == "-") {
        if (o.to.empty()) throw UsageError("OUT: -: give its format by --to, e.g. --to ply");
        o.out += o.to.starts_with('.') ? o.to : "." + o.to;
    }
    const FileKind kind = file_kind(o.in);
    if (o.spz_version != 3 && (kind != FileKind::splats || ending(o.out) != ".spz"))
        throw UsageError("--spz-version: only for splats that are written as .spz");
    if (kind != FileKind::mesh && (o.scale != 1 || !o.unit.empty()))
        throw UsageError("--scale and --unit: only for meshes");
    if (kind == FileKind::recording) {
        check_ending(o.out, {".hands", ".jsonl"}, "a recording");
        const Recording recording = read_recording(o.in);
        prepare_file(o.out, o.overwrite);
        write_recording(o.out, recording);
    } else if (kind == FileKind::mesh) {
        convert_mesh(o);
    } else if (kind == FileKind::particles) {
        check_ending(o.out, {".ply", ".csv"}, "particles");
        const std::vector<Particle<double>> particles = read_particles(o.in);
        prepare_file(o.out, o.overwrite);
        write_particles(o.out, particles);
    } else if (kind == FileKind::session) {
        convert_session(o);
    } else if (kind == FileKind::splats) {
        convert_splats(o);
    } else {
        throw InputError(o.in + ": expected a mesh, a recording, particles, splats or a session");
    }
    if (!o.quiet && !is_standard(o.out)) print(o.out + "\n");
    return exit_ok;
}

}  // namespace knead
