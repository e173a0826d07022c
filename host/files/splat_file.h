// Splats, photographed objects as 3D Gaussians, to files and back: PLY as [Kerbl 2023] writes it
// and in the dialects of others, .splat, SPZ, glTF. docs/reference/formats.md lays them out.
#pragma once
#include <cstddef>
#include <string>

#include "host/files/ply.h"
#include "host/splats/cloud.h"

namespace knead {

// What reading changed; all 0 for a sound file.
struct SplatRepairs {
    std::size_t not_finite = 0;   // dropped: a number that is not finite, where it must be
    std::size_t no_rotation = 0;  // dropped: a quaternion of length 0
    std::size_t mirrored = 0;     // a half axis below 0, taken without its sign
    int degree_left_out = 0;      // the file's degree, where it is above max_sh_degree

    std::size_t dropped() const { return not_finite + no_rotation; }
};
struct SplatFile {
    SplatCloud cloud;
    SplatRepairs repairs;
    std::string format;  // "ply", "splat", "spz"
};

// What the file is, its content says; .splat, which has no mark, its ending. Throws InputError with
// path, place and reason, also where there is no splat or none that can be drawn. A count that the
// file cannot hold is refused before memory is taken for it.
SplatFile read_splats(const std::string& path);
SplatFile parse_splats(const std::string& bytes, const std::string& path);

// By the ending of the path: .ply, .splat, .spz, .glb, which is only written. Throws InputError for
// another one and for what the format cannot hold, OutputError where the file cannot be written.
void write_splats(const std::string& path, const SplatCloud& cloud);

// The formats, each on its own.
bool holds_splats(const PlyFile& ply);  // its header is enough
SplatFile parse_splat_ply(const std::string& bytes, const std::string& path);
std::string splat_ply_bytes(const SplatCloud& cloud);

SplatFile parse_splat(const std::string& bytes, const std::string& path);
std::string splat_bytes(const SplatCloud& cloud);

bool begins_spz(const std::string& start);  // of the first bytes of a file
SplatFile parse_spz(const std::string& bytes, const std::string& path);
// Version 2 or 3. `path` is for messages.
std::string spz_bytes(const SplatCloud& cloud, const std::string& path, int version = 3);

// KHR_gaussian_splatting; axes right, up, back. `path` is for messages.
std::string splat_glb_bytes(const SplatCloud& cloud, const std::string& path);

}  // namespace knead
