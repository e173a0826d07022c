// knead convert: meshes, recordings and particles from one format to another.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/files/file_kind.h"
#include "host/files/mesh_file.h"
#include "host/files/mesh_reader.h"
#include "host/files/particle_file.h"
#include "host/hands/recording.h"
#include "host/scene/scene.h"

namespace knead {
namespace {

void check_ending(const std::string& out, const std::vector<std::string>& allowed, const char* of)
{
    const std::string ending = std::filesystem::path(out).extension().string();
    std::string all;
    for (const std::string& a : allowed) {
        if (a == ending) return;
        all += (all.empty() ? "" : ", ") + a;
    }
    throw UsageError(fmt::format("{}: {} can be written as {}", out, of, all));
}

}  // namespace

int convert_verb(const ConvertOptions& o)
{
    const FileKind kind = file_kind(o.in);
    if (kind == FileKind::recording) {
        check_ending(o.out, {".hands", ".jsonl"}, "a recording");
        const Recording recording = read_recording(o.in);
        prepare_file(o.out, o.overwrite);
        write_recording(o.out, recording);
    } else if (kind == FileKind::mesh) {
        check_ending(o.out, {".glb", ".obj", ".ply"}, "a mesh");
        const std::vector<Mesh> meshes = read_mesh(o.in);
        prepare_file(o.out, o.overwrite);
        write_mesh(o.out, meshes);
    } else if (kind == FileKind::particles) {
        check_ending(o.out, {".ply", ".csv"}, "particles");
        const std::vector<Particle<double>> particles = read_particles(o.in);
        prepare_file(o.out, o.overwrite);
        write_particles(o.out, particles);
    } else {
        throw InputError(o.in + ": expected a mesh, a recording or particles");
    }
    if (!o.quiet) std::printf("%s\n", o.out.c_str());
    return exit_ok;
}

}  // namespace knead
