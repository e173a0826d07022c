// Splats as PLY: a table with opacities as logits, half axes as logarithms, and the harmonics above
// degree 0 stored channel by channel.  [Kerbl 2023]
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "host/base/errors.h"
#include "host/files/splat_gather.h"

namespace knead {
namespace {

// Column of a property in a row; -1 if absent.
struct Column {
    int at = -1;
    bool half = false;  // 16-bit integers that hold the bits of half-precision floats

    double of(const double* row) const
    {
        return half ? half_number(std::uint16_t(row[at])) : row[at];
    }
};

struct Columns {
    std::array<Column, 3> centre, scale, dc;
    std::array<Column, 4> rotation;
    Column opacity;
    std::vector<Column> rest;
    int degree = 0;
};

class Header {
  public:
    Header(const PlyFile& header, const std::string& file)
        : vertex(header.find("vertex")), path(file)
    {
        if (!vertex) fail("the element \"vertex\"", "none");
    }

    Columns columns() const
    {
        Columns c;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string number = std::to_string(k);
            c.centre[k] = required(std::string(1, "xyz"[k]));
            // Flat discs lack the third half axis.
            c.scale[k] = k < 2 ? required("scale_" + number) : found("scale_2");
            c.dc[k] =
                k == 0 || c.dc[0].at < 0 ? found("f_dc_" + number) : required("f_dc_" + number);
        }
        for (std::size_t k = 0; k < 4; ++k) c.rotation[k] = required("rot_" + std::to_string(k));
        c.opacity = required("opacity");
        std::size_t rest = 0;
        for (const PlyProperty& p : vertex->properties) rest += p.name.starts_with("f_rest_");
        const auto above = [&] { return 3 * std::size_t(harmonics(c.degree) - 1); };
        while (above() < rest) ++c.degree;
        if (above() != rest || c.degree > 4)
            fail("0, 9, 24, 45 or 72 properties f_rest_0, f_rest_1, ...", std::to_string(rest));
        for (std::size_t k = 0; k < rest; ++k)
            c.rest.push_back(required("f_rest_" + std::to_string(k)));
        return c;
    }

    const PlyElement* vertex;

  private:
    [[noreturn]] void fail(const std::string& expected, const std::string& instead) const
    {
        throw InputError(
            fmt::format("{}: PLY header: expected {}, found {}", path, expected, instead));
    }

    Column found(const std::string& name) const
    {
        for (std::size_t k = 0; k < vertex->properties.size(); ++k) {
            const PlyProperty& p = vertex->properties[k];
            if (p.name != name) continue;
            const bool real = p.type >= PlyType::f16, half = p.type == PlyType::u16;
            if (p.list || (!real && !half))
                fail("a float, double or half for \"" + name + "\"",
                     p.list ? "a list" : "whole numbers");
            return {int(k), half};
        }
        return {};
    }

    Column required(const std::string& name) const
    {
        const Column column = found(name);
        if (column.at < 0) fail("the property \"" + name + "\"", "none");
        return column;
    }

    const std::string& path;
};

bool says_antialiased(const PlyFile& header)
{
    for (const std::string& comment : header.comments)
        if (comment == "SplatRenderMode: mip" || comment == "antialiased 1") return true;
    return false;
}

template <std::size_t n>
std::array<double, n> taken(const std::array<Column, n>& columns, const double* row)
{
    std::array<double, n> values{};
    for (std::size_t k = 0; k < n; ++k)
        if (columns[k].at >= 0) values[k] = columns[k].of(row);
    return values;
}

RawSplat raw_splat(const Columns& c, const double* row)
{
    const auto x = taken(c.centre, row), s = taken(c.scale, row);
    const auto q = taken(c.rotation, row);
    const double third = c.scale[2].at < 0 ? 0 : std::exp(s[2]);
    return {{x[0], x[1], x[2]},
            {std::exp(s[0]), std::exp(s[1]), third},
            {q[0], q[1], q[2], q[3]},
            1 / (1 + std::exp(-c.opacity.of(row)))};
}

// Finite limit of logarithms and logits that floats read back as exactly 0 (or 1 for an opacity):
// other readers fail on infinities.
constexpr double beyond = 104;

float logarithm(float s) { return float(std::max(std::log(double(s)), -beyond)); }

float logit(float opacity)
{
    const double a = opacity;
    return float(std::clamp(std::log(a / (1 - a)), -beyond, beyond));
}

std::string header_for(const SplatCloud& cloud)
{
    std::string out = "ply\nformat binary_little_endian 1.0\n";
    if (cloud.antialiased) out += "comment SplatRenderMode: mip\n";
    out += fmt::format("element vertex {}\n", cloud.count());
    const auto property = [&](const std::string& name) { out += "property float " + name + "\n"; };
    const auto numbered = [&](const char* name, int n) {
        for (int k = 0; k < n; ++k) property(name + std::to_string(k));
    };
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) property(name);
    numbered("f_dc_", 3);
    numbered("f_rest_", 3 * (harmonics(cloud.degree) - 1));
    property("opacity");
    numbered("scale_", 3);
    numbered("rot_", 4);
    return out + "end_header\n";
}

}  // namespace

bool holds_splats(const PlyFile& ply)
{
    const PlyElement* vertex = ply.find("vertex");
    return vertex && vertex->find("scale_0") && vertex->find("rot_0") && vertex->find("opacity");
}

SplatFile parse_splat_ply(const std::string& bytes, const std::string& path)
{
    const PlyFile ply = parse_ply_header(bytes, path);
    const Header header(ply, path);
    const Columns c = header.columns();
    const std::size_t of_channel = c.rest.size() / 3;
    SplatGather gather("ply", c.degree);
    gather.file.cloud.antialiased = says_antialiased(ply);
    parse_ply_rows(bytes, path, "vertex", [&](std::size_t i, const double* row) {
        // Reserved only now, when the file is known to be long enough.
        if (i == 0) gather.reserve(header.vertex->rows);
        gather.add(raw_splat(c, row), [&](int k) -> Vec3<double> {
            if (k == 0) {
                const auto dc = taken(c.dc, row);
                return {dc[0], dc[1], dc[2]};
            }
            const std::size_t at = std::size_t(k - 1);
            return {c.rest[at].of(row), c.rest[of_channel + at].of(row),
                    c.rest[2 * of_channel + at].of(row)};
        });
    });
    return gather.gathered(path);
}

std::string splat_ply_bytes(const SplatCloud& cloud)
{
    std::string out = header_for(cloud);
    const std::size_t stride = std::size_t(harmonics(cloud.degree));
    std::vector<float> row;
    out.reserve(out.size() + cloud.count() * (17 - 3 + 3 * stride) * sizeof(float));
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> x = cloud.centre[i], s = cloud.scale[i];
        const Quat<float> q = cloud.rotation[i];
        const Vec3<float>* sh = cloud.sh.data() + i * stride;
        row = {x.x, x.y, x.z, 0, 0, 0, sh[0].x, sh[0].y, sh[0].z};
        for (float Vec3<float>::*channel : {&Vec3<float>::x, &Vec3<float>::y, &Vec3<float>::z})
            for (std::size_t k = 1; k < stride; ++k) row.push_back(sh[k].*channel);
        row.insert(row.end(), {logit(cloud.opacity[i]), logarithm(s.x), logarithm(s.y),
                               logarithm(s.z), q.w, q.x, q.y, q.z});
        out.append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(float));
    }
    return out;
}

}  // namespace knead
