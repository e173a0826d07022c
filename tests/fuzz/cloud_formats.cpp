// Particles: PLY, CSV. Splats: PLY in all its dialects, compressed PLY, .splat, .ksplat, SPZ, SOG,
// glTF.
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/cli/compare.h"
#include "host/files/gzip.h"
#include "host/files/particle_file.h"
#include "host/files/splat_file.h"
#include "host/files/webp.h"
#include "host/files/zip.h"
#include "tests/files/splat_cases.h"
#include "tests/folder.h"
#include "tests/fuzz/formats.h"

namespace knead {
namespace {

std::vector<Particle<double>> few_particles()
{
    std::vector<Particle<double>> all(7);
    double number = 0.1;
    for (Particle<double>& q : all) {
        for (Vec3<double>* v : {&q.x, &q.v, &q.C.a, &q.C.b, &q.C.c})
            *v = {number, -number, 1e-7 * number}, number += 0.37;
        q.e.xx = number, q.k = -number;
        q.object = int(number), q.sides = 0xffffffffu;
    }
    return all;
}

std::string written(const std::string& ending)
{
    const Folder folder;
    write_particles(folder / ("seed" + ending), few_particles());
    return read_text(folder / ("seed" + ending), 1 << 20);
}

void use(const std::vector<Particle<double>>& particles)
{
    if (particles.empty()) throw std::logic_error("no particles, and no refusal");
    text_of(compared(particles, few_particles(), {}));
}

std::vector<std::string> particle_ply_seeds()
{
    return {written(".ply"),
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty float y\n"
            "property float z\nproperty int object\nend_header\n0 0 0 1\n1 2 3 0\n"};
}
void read_particle_ply(const std::string& bytes) { use(to_particles(parse_ply(bytes, "p"), "p")); }

std::vector<std::string> particle_csv_seeds()
{
    return {written(".csv"), "\"x\", \"y\", \"z\", \"more\"\r\n\r\n1e-3, 2, 3, 4\r\n0,0,0,0"};
}
void read_particle_csv(const std::string& bytes) { use(parse_csv(bytes, "p.csv")); }

// A cloud that was read is written in every format, and that is read.
void use(const SplatFile& file)
{
    const SplatCloud& cloud = file.cloud;
    if (cloud.count() == 0) throw std::logic_error("no splats, and no refusal");
    must_pass("as PLY", [&] { parse_splat_ply(splat_ply_bytes(cloud), "again"); });
    must_pass("as compressed PLY",
              [&] { parse_splat_ply(compressed_ply_bytes(cloud, "again"), "again"); });
    losses(cloud, "again.spz");
    must_pass("as .splat", [&] { parse_splat(splat_bytes(cloud), "again"); });
    std::string spz;
    try {
        spz = spz_bytes(cloud, "again");
    } catch (const InputError&) {
        return;  // too far away for its numbers
    }
    must_pass("as SPZ", [&] { parse_spz(spz, "again"); });
    must_pass("as SPZ 4", [&] { parse_spz(spz_bytes(cloud, "again", 4), "again"); });
    must_pass("as glTF", [&] { parse_splat_glb(splat_glb_bytes(cloud, "again"), "again"); });
}

// Bytes as colours, a filter, no third half axis, and a property that nobody knows.
std::string dialect_row()
{
    const Names floats{"x",     "y",     "z",     "opacity", "scale_0", "scale_1",
                       "rot_0", "rot_1", "rot_2", "rot_3",   "unknown", "filter_3D"};
    return "ply\nformat binary_little_endian 1.0\ncomment Vertical Axis: z\nelement vertex 1\n" +
           properties(floats) + properties({"red", "green", "blue"}, "uchar") + "end_header\n" +
           bytes_of(std::vector<float>{1, 2, 3, 0, -1, -2, 1, 0, 0, 0, 7, 0.1f}) + "abc";
}

std::vector<std::string> splat_ply_seeds()
{
    const std::vector<float> floats(one_row.begin(), one_row.end());
    std::string text = header("ascii", 1, plain, "float32", "comment by hand\n");
    for (double v : one_row) text += std::to_string(v) + " ";
    const std::vector<std::uint16_t> halves(plain.size(), 0x3c00);
    return {little(one_row),
            header("binary_big_endian", 1, plain) + swapped(floats),
            header("binary_little_endian", 1, plain, "double") + bytes_of(one_row),
            header("binary_little_endian", 1, plain, "half") + bytes_of(halves),
            header("binary_little_endian", 1, plain, "ushort") + bytes_of(halves),
            text + "\n",
            dialect_row(),
            splat_ply_bytes(drawn(5, 0, 1)),
            splat_ply_bytes(drawn(5, 3, 2))};
}
void read_splat_ply(const std::string& bytes) { use(parse_splat_ply(bytes, "splats.ply")); }

std::vector<std::string> splat_seeds() { return {splat_bytes(drawn(6, 0, 3))}; }
void read_splat(const std::string& bytes) { use(parse_splat(bytes, "splats.splat")); }

std::vector<std::string> compressed_ply_seeds()
{
    return {compressed_ply_bytes(drawn(5, 0, 6), "seed"),
            compressed_ply_bytes(drawn(260, 1, 7), "seed")};
}

std::vector<std::string> ksplat_seeds()
{
    std::vector<std::string> all;
    for (const int level : {0, 1, 2}) all.push_back(ksplat_of_level(level));
    return all;
}
void read_ksplat(const std::string& bytes) { use(parse_ksplat(bytes, "splats.ksplat")); }

std::vector<std::string> splat_glb_seeds()
{
    return {splat_glb_bytes(drawn(3, 0, 8), "seed"), splat_glb_bytes(drawn(2, 2, 9), "seed")};
}
void read_splat_glb(const std::string& bytes)
{
    begins_splat_glb(bytes);
    use(parse_splat_glb(bytes, "splats.glb"));
}

// With the checksums of its entries set right: no change would come past them.
std::string mended_zip(const std::string& bytes)
{
    const std::string path = "mended";
    std::vector<std::pair<std::string, std::string>> entries;
    std::size_t at = 0;
    constexpr std::size_t header = 30;
    while (bytes.size() - at > header && bytes.compare(at, 4, "PK\3\4") == 0) {
        const auto number = [&](std::size_t from, std::size_t size) {
            std::size_t value = 0;
            for (std::size_t k = size; k-- > 0;)
                value = value << 8 | std::uint8_t(bytes[at + from + k]);
            return value;
        };
        const std::size_t size = number(18, 4), name = number(26, 2);
        if (bytes.size() - at - header < name + size) break;
        entries.emplace_back(bytes.substr(at + header, name),
                             bytes.substr(at + header + name, size));
        at += header + name + size;
    }
    return zip_bytes(entries, path);
}
std::vector<std::string> sog_seeds()
{
    if (!webp_available()) return {zip_bytes({{"meta.json", "{}"}}, "seed")};
    return {sog_bytes(drawn(6, 0, 10), "seed"), sog_bytes(drawn(4, 1, 11), "seed")};
}
void read_sog(const std::string& bytes)
{
    try {
        use(parse_sog(bytes, "splats.sog"));
    } catch (const InputError&) {
        use(parse_sog(mended_zip(bytes), "splats.sog"));
    } catch (const ResourceError&) {  // built without libwebp
        throw InputError("no libwebp");
    }
}

// Out of their gzip: no change would come past its checksum.
std::vector<std::string> spz_seeds()
{
    SpzByHand old{2};
    SpzByHand extended{3};
    extended.flags = 2, extended.behind = std::string("\1\0\0\0\2\0\0\0ab", 10);
    std::vector<std::string> all{SpzByHand().bytes(), old.bytes(), extended.bytes()};
    for (int degree : {0, 3})
        all.push_back(gunzipped(spz_bytes(drawn(4, degree, 4), "seed"), "seed", 1 << 20));
    all.push_back(spz_bytes(drawn(4, 1, 5), "seed"));
    for (int degree : {0, 1}) all.push_back(spz_bytes(drawn(3, degree, 6), "seed", 4));
    return all;
}
void read_spz(const std::string& bytes)
{
    try {
        use(parse_splats(bytes, "splats.spz"));
    } catch (const InputError&) {
        use(parse_spz(gzipped(bytes), "splats.spz"));
    }
}

}  // namespace

std::vector<FuzzFormat> cloud_formats()
{
    return {{"particles-ply", particle_ply_seeds, read_particle_ply},
            {"particles-csv", particle_csv_seeds, read_particle_csv},
            {"splats-ply", splat_ply_seeds, read_splat_ply},
            {"splats-splat", splat_seeds, read_splat},
            {"splats-spz", spz_seeds, read_spz},
            {"splats-compressed-ply", compressed_ply_seeds, read_splat_ply},
            {"splats-ksplat", ksplat_seeds, read_ksplat},
            {"splats-sog", sog_seeds, read_sog},
            {"splats-glb", splat_glb_seeds, read_splat_glb}};
}

}  // namespace knead
