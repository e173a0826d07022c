#include "host/files/particle_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/base/text_number.h"
#include "host/scene/scene.h"

namespace knead {
namespace {

// Properties in struct order: a row of the file has the bytes of a particle.
constexpr const char* real_names[] = {"x",   "y",   "z",   "vx",  "vy",  "vz",  "cxx", "cyx",
                                      "czx", "cxy", "cyy", "czy", "cxz", "cyz", "czz", "exx",
                                      "eyy", "ezz", "exy", "exz", "eyz", "k"};
constexpr std::size_t reals = std::size(real_names);
static_assert(sizeof(Particle<double>) == reals * sizeof(double) + 8);

double* row(Particle<double>& q) { return reinterpret_cast<double*>(&q); }
const double* row(const Particle<double>& q) { return reinterpret_cast<const double*>(&q); }

std::string ply_bytes(const std::vector<Particle<double>>& particles)
{
    std::string out = "ply\nformat binary_little_endian 1.0\ncomment knead.particles/1\n";
    out += fmt::format("element vertex {}\n", particles.size());
    for (const char* name : real_names) out += fmt::format("property double {}\n", name);
    out += "property int object\nproperty uint sides\nend_header\n";
    out.append(reinterpret_cast<const char*>(particles.data()),
               particles.size() * sizeof(Particle<double>));
    return out;
}

std::string csv_bytes(const std::vector<Particle<double>>& particles)
{
    std::string out;
    for (const char* name : real_names) out += std::string(name) + ",";
    out += "object,sides\n";
    for (const Particle<double>& q : particles) {
        for (std::size_t i = 0; i < reals; ++i) out += fmt::format("{},", row(q)[i]);
        out += fmt::format("{},{}\n", q.object, q.sides);
    }
    return out;
}

constexpr std::size_t max_csv = std::size_t(4) << 30;  // [bytes]
constexpr std::size_t max_columns = 256;

std::string_view trimmed(std::string_view word)
{
    const std::size_t from = word.find_first_not_of(" \t\r");
    if (from == std::string_view::npos) return {};
    return word.substr(from, word.find_last_not_of(" \t\r") + 1 - from);
}

// Calls visit() for every comma-separated field of a line.
template <class Visit>
void each_word(std::string_view line, Visit&& visit)
{
    for (std::size_t at = 0; at <= line.size();) {
        const std::size_t end = std::min(line.find(',', at), line.size());
        visit(trimmed(line.substr(at, end - at)));
        at = end + 1;
    }
}

void take_heading(PlyElement& points, std::string_view line, const std::string& place)
{
    if (std::size_t(std::count(line.begin(), line.end(), ',')) >= max_columns)
        throw InputError(fmt::format("{}: expected at most {} columns", place, max_columns));
    each_word(line, [&](std::string_view word) {
        if (word.size() > 1 && word.front() == '"' && word.back() == '"')
            word = word.substr(1, word.size() - 2);
        const std::string name(word);
        if (points.find(name))
            throw InputError(fmt::format("{}: expected a name once, found \"{}\" again", place,
                                         name.substr(0, 60)));
        points.properties.push_back({name, false, PlyType::f64, {}, {}});
    });
}

void take_row(PlyElement& points, std::string_view line, const std::string& place)
{
    std::size_t column = 0;
    each_word(line, [&](std::string_view word) {
        const TextNumber found = text_number(word);
        if (!found.fault.empty() || column == points.properties.size())
            throw InputError(fmt::format("{}: expected {} numbers, found \"{}\" as number {}{}",
                                         place, points.properties.size(), word.substr(0, 60),
                                         column + 1, in_brackets(found.fault)));
        points.properties[column++].values.push_back(found.value);
    });
    if (column != points.properties.size())
        throw InputError(fmt::format("{}: expected {} numbers, found {}", place,
                                     points.properties.size(), column));
    ++points.rows;
}

}  // namespace

void write_particles(const std::string& path, const std::vector<Particle<double>>& particles)
{
    const std::string form = ending(path);
    if (form == ".ply") return write_whole(path, ply_bytes(particles));
    if (form == ".csv") return write_whole(path, csv_bytes(particles));
    throw InputError(path + ": expected .ply or .csv for particles, found \"" + form + "\"");
}

bool holds_particles(const PlyFile& ply)
{
    for (const char* name : {"face", "tristrips"})
        if (const PlyElement* of = ply.find(name); of && of->rows > 0) return false;
    return ply.find("vertex") != nullptr;
}

std::vector<Particle<double>> to_particles(const PlyFile& ply, const std::string& path)
{
    const PlyElement* points = ply.find("vertex");
    if (!points || points->rows == 0)
        throw InputError(path + ": expected particles (element \"vertex\"), found none");
    const auto column = [&](const char* name) -> const PlyProperty* {
        const PlyProperty* p = points->find(name);
        return p && !p->list ? p : nullptr;
    };
    std::vector<Particle<double>> particles(points->rows);
    for (std::size_t k = 0; k < reals; ++k) {
        const PlyProperty* p = column(real_names[k]);
        if (!p && k < 3)
            throw InputError(
                fmt::format("{}: expected the property \"{}\", found none", path, real_names[k]));
        for (std::size_t i = 0; p && i < particles.size(); ++i) {
            if (!std::isfinite(p->values[i]))
                throw InputError(fmt::format("{}: particle {}: expected a finite {}, found {}",
                                             path, i, real_names[k], p->values[i]));
            row(particles[i])[k] = p->values[i];
        }
    }
    const auto whole = [&](const char* name, double max_value, auto&& put) {
        const PlyProperty* p = column(name);
        for (std::size_t i = 0; p && i < particles.size(); ++i) {
            const double n = p->values[i];
            if (!(n >= 0 && n <= max_value && n == std::floor(n)))
                throw InputError(fmt::format("{}: particle {}: expected {} from 0 to {}, found {}",
                                             path, i, name, max_value, n));
            put(particles[i], n);
        }
    };
    whole("object", 1e6, [](Particle<double>& q, double n) { q.object = int(n); });
    whole("sides", 0xffffffffu, [](Particle<double>& q, double n) { q.sides = std::uint32_t(n); });
    return particles;
}

std::vector<Particle<double>> parse_csv(const std::string& text, const std::string& path)
{
    PlyFile table;  // one element, as in a PLY file
    table.elements.resize(1);
    PlyElement& points = table.elements[0];
    points.name = "vertex";
    std::size_t number = 0;
    for (std::size_t at = text_begin(text, path); at < text.size();) {
        const std::string_view line = trimmed(next_line(text, at));
        ++number;
        if (line.empty()) continue;
        const std::string place = fmt::format("{}: line {}", path, number);
        if (points.properties.empty())
            take_heading(points, line, place);
        else
            take_row(points, line, place);
    }
    return to_particles(table, path);
}

std::vector<Particle<double>> read_particles(const std::string& path)
{
    if (ending(path) == ".csv") return parse_csv(read_text(path, max_csv), path);
    return to_particles(read_ply(path), path);
}

}  // namespace knead
