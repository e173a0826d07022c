// Splat files, photographed objects as 3D Gaussians: PLY as in [Kerbl 2023] and its dialects,
// .splat, SPZ, glTF. Layouts: docs/reference/formats.md.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/files/ply.h"
#include "host/splats/cloud.h"

namespace knead {

// Repairs on reading; all 0 for a valid file.
struct SplatRepairs {
    std::size_t not_finite = 0;   // dropped: a required number is not finite
    std::size_t no_rotation = 0;  // dropped: a quaternion of length 0
    std::size_t mirrored = 0;     // negative half axes, of which the sign is dropped
    int degree_left_out = 0;      // the file's degree if above max_sh_degree

    std::size_t dropped() const { return not_finite + no_rotation; }
};
struct SplatFile {
    SplatCloud cloud;
    SplatRepairs repairs;
    std::string format;  // "ply", "splat", "spz"
    // What the file has beyond splats as they are kept here, and how it was understood: a line
    // each.
    std::vector<std::string> notes;
};

// What the user should know about the reading, a line each: splats dropped and repaired, then the
// notes. The same for all commands; empty for a plain, valid file.
std::vector<std::string> remarks(const SplatFile& file);

// The format is detected from the content; .splat, which has no magic number, from the extension.
// Throws InputError with path, place and reason, also if there is no drawable splat. A count that
// the file cannot hold is rejected before allocation.
SplatFile read_splats(const std::string& path);
SplatFile parse_splats(const std::string& bytes, const std::string& path);

// Writes the format of the extension: .ply, .splat, .spz, or .glb, which is write-only. Throws
// InputError for another extension and for what the format cannot represent, OutputError if writing
// fails.
void write_splats(const std::string& path, const SplatCloud& cloud);

// The individual formats.
bool holds_splats(const PlyFile& ply);  // the header suffices
SplatFile parse_splat_ply(const std::string& bytes, const std::string& path);
std::string splat_ply_bytes(const SplatCloud& cloud);

SplatFile parse_splat(const std::string& bytes, const std::string& path);
std::string splat_bytes(const SplatCloud& cloud);

bool begins_spz(const std::string& start);  // `start`: the first bytes of a file
SplatFile parse_spz(const std::string& bytes, const std::string& path);
// Version 2 or 3. `path` is used in messages only.
std::string spz_bytes(const SplatCloud& cloud, const std::string& path, int version = 3);

// KHR_gaussian_splatting; axes right, up, back. `path` is used in messages only.
std::string splat_glb_bytes(const SplatCloud& cloud, const std::string& path);

}  // namespace knead
