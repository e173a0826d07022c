// Particles: PLY, CSV. Splats: PLY in all its dialects, .splat, SPZ.
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/cli/compare.h"
#include "host/files/gzip.h"
#include "host/files/particle_file.h"
#include "host/files/splat_file.h"
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
    must_pass("as .splat", [&] { parse_splat(splat_bytes(cloud), "again"); });
    std::string spz;
    try {
        spz = spz_bytes(cloud, "again");
        splat_glb_bytes(cloud, "again");
    } catch (const InputError&) {
        return;  // too far away for its numbers
    }
    must_pass("as SPZ", [&] { parse_spz(spz, "again"); });
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
            splat_ply_bytes(drawn(5, 0, 1)),
            splat_ply_bytes(drawn(5, 3, 2))};
}
void read_splat_ply(const std::string& bytes) { use(parse_splat_ply(bytes, "splats.ply")); }

std::vector<std::string> splat_seeds() { return {splat_bytes(drawn(6, 0, 3))}; }
void read_splat(const std::string& bytes) { use(parse_splat(bytes, "splats.splat")); }

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
            {"splats-spz", spz_seeds, read_spz}};
}

}  // namespace knead
