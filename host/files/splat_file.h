// Splat files, photographed objects as 3D Gaussians: PLY as in [Kerbl 2023] and its dialects,
// .splat, SPZ, glTF. Layouts: docs/reference/formats.md.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/base/outputs.h"
#include "host/files/byte_window.h"
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
    std::string format;  // "ply", "compressed ply", "splat", "spz", "ksplat", "sog", "glb"
    // What the file has beyond splats as they are kept here, and how it was understood: a line
    // each.
    std::vector<std::string> notes;
};

// What the user should know about the reading, a line each: splats dropped and repaired, then the
// notes. The same for all commands; empty for a plain, valid file.
std::vector<std::string> remarks(const SplatFile& file);

// The format is detected from the content; .splat, .ksplat and .sog from the ending. `path` may be
// a folder of SOG.
// Throws InputError with path, place and reason, also if there is no drawable splat. A count that
// the file cannot hold is rejected before allocation.
SplatFile read_splats(const std::string& path);
SplatFile parse_splats(std::string bytes, const std::string& path);

// Throws InputError for formats of splats that are known but not read, with what to do: .splatv,
// .lcc. `start`: the first bytes of the file.
void refuse_unread_splats(const std::string& path, const std::string& start);

// Writes the format of the ending: .ply, .compressed.ply, .splat, .spz, .sog or .glb. Throws
// InputError for another one and for what the format cannot represent, OutputError if writing
// fails.
void write_splats(const std::string& path, const SplatCloud& cloud, int spz_version = 3);

// What the format of this ending cannot hold of the cloud, a line each, beyond the rounding of
// numbers: harmonics, values out of its range, the mark of antialiased training.
std::vector<std::string> losses(const SplatCloud& cloud, const std::string& path);

// The individual formats.
bool holds_splats(const PlyFile& ply);  // the header suffices
SplatFile parse_splat_ply(const std::string& bytes, const std::string& path);
// The same of a file, row by row, so that it need not fit into memory beside its splats; nothing
// for files that are not little-endian rows of plain numbers.
std::optional<SplatFile> read_plain_splat_ply(const std::string& path);
std::string splat_ply_bytes(const SplatCloud& cloud);
// The same, a part of a few MiB at a time.
void write_splat_ply(const SplatCloud& cloud, const AddBytes& add);

// The compressed PLY of SuperSplat, which parse_splat_ply() reads, too. Writing sorts the splats
// along a Morton curve; throws InputError for no splats.
bool holds_compressed_splats(const PlyFile& ply);
SplatFile parse_compressed_ply(const std::string& bytes, const std::string& path);
std::string compressed_ply_bytes(const SplatCloud& cloud, const std::string& path);

SplatFile parse_splat(const std::string& bytes, const std::string& path);
SplatFile parse_splat(const ByteWindow& bytes, const std::string& path);
std::string splat_bytes(const SplatCloud& cloud);
void write_dot_splat(const SplatCloud& cloud, const AddBytes& add);

// GaussianSplats3D; read only.
SplatFile parse_ksplat(const std::string& bytes, const std::string& path);
SplatFile parse_ksplat(const ByteWindow& bytes, const std::string& path);

// SOG, versions 1 and 2: a ZIP, or a folder with meta.json, given by either's path. Throws
// ResourceError in builds without libwebp.
SplatFile parse_sog(const std::string& bytes, const std::string& path);
bool is_sog_folder(const std::string& path);
SplatFile read_sog_folder(const std::string& path);
// A ZIP of version 2. Writing sorts the splats along a Morton curve, and groups the harmonics of
// more than 65536 splats.
std::string sog_bytes(const SplatCloud& cloud, const std::string& path);

bool begins_spz(const std::string& start);  // `start`: the first bytes of a file
// `bytes` is released once it is unpacked.
SplatFile parse_spz(std::string bytes, const std::string& path);
// Version 2, 3 or 4. `path` is used in messages only.
std::string spz_bytes(const SplatCloud& cloud, const std::string& path, int version = 3);
void write_spz(const SplatCloud& cloud, const std::string& path, int version, const AddBytes& add);

// KHR_gaussian_splatting, the splats of the default scene. Splats compressed as SPZ are refused.
bool begins_splat_glb(const std::string& start);  // `start`: at least to the end of the document
SplatFile parse_splat_glb(const std::string& bytes, const std::string& path);
SplatFile parse_splat_glb(const ByteWindow& bytes, const std::string& path);
// KHR_gaussian_splatting; axes right, up, back. `path` is used in messages only.
std::string splat_glb_bytes(const SplatCloud& cloud, const std::string& path);
void write_splat_glb(const SplatCloud& cloud, const std::string& path, const AddBytes& add);

}  // namespace knead
