// Splats as PLY: a table with opacities as logits, half axes as logarithms, and the harmonics above
// degree 0 stored channel by channel.  [Kerbl 2023]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/files/splat_gather.h"
#include "host/files/splat_ply_dialect.h"

namespace knead {
namespace {

// Column of a property in a row; -1 if absent.
struct Column {
    int at = -1;
    bool half = false;  // 16-bit integers that hold the bits of half-precision floats

    bool there() const { return at >= 0; }

    double of(const double* row) const
    {
        return half ? half_number(std::uint16_t(row[at])) : row[at];
    }
};

struct Columns {
    std::array<Column, 3> centre, scale, dc;
    std::array<Column, 4> rotation;
    Column opacity;
    std::array<Column, 3> rgb;  // instead of dc
    double rgb_unit = 1;        // value of full intensity; floats may turn out to be 0 to 255
    Column filter;              // Mip-Splatting: standard deviation of the screen filter [m]
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
        c.filter = found("filter_3D");
        if (!c.dc[0].there()) find_rgb(c);
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

    // Colours of degree 0 as bytes or floats, from exporters that leave out the harmonics.
    void find_rgb(Columns& c) const
    {
        constexpr const char* names[2][3] = {{"red", "green", "blue"}, {"r", "g", "b"}};
        for (const auto& of : names) {
            if (!vertex->find(of[0])) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const PlyProperty* p = vertex->find(of[k]);
                if (!p || p->list) fail(fmt::format("the property \"{}\"", of[k]), "none");
                if (k > 0 && p->type != vertex->find(of[0])->type)
                    fail("colours of one type", "several");
                c.rgb[k].at = int(p - vertex->properties.data());
                c.rgb_unit = p->type == PlyType::u8 ? 255 : p->type == PlyType::u16 ? 65535 : 1;
                if (p->type < PlyType::f16 && c.rgb_unit == 1)
                    fail("uchar, ushort or floats for colours", "other whole numbers");
            }
            return;
        }
    }

    Column required(const std::string& name) const
    {
        const Column column = found(name);
        if (column.at < 0) fail("the property \"" + name + "\"", "none");
        return column;
    }

    const std::string& path;
};

template <std::size_t n>
std::array<double, n> taken(const std::array<Column, n>& columns, const double* row)
{
    std::array<double, n> values{};
    for (std::size_t k = 0; k < n; ++k)
        if (columns[k].at >= 0) values[k] = columns[k].of(row);
    return values;
}

// Mip-Splatting stores the filter of its training apart: each half axis grows to sqrt(s^2 + f^2),
// and the opacity shrinks by the ratio of the volumes.  [Yu 2024]
void apply_filter(RawSplat& raw, double f, bool flat)
{
    double ratio = 1;
    const auto grow = [&](double& s) {
        const double grown = std::hypot(s, f);
        if (grown > 0) ratio *= s / grown;
        s = grown;
    };
    grow(raw.scale.x), grow(raw.scale.y);
    if (!flat) grow(raw.scale.z);
    raw.opacity *= ratio;
}

RawSplat raw_splat(const Columns& c, const double* row)
{
    const auto x = taken(c.centre, row), s = taken(c.scale, row);
    const auto q = taken(c.rotation, row);
    const bool flat = !c.scale[2].there();
    RawSplat raw{{x[0], x[1], x[2]},
                 {std::exp(s[0]), std::exp(s[1]), flat ? 0 : std::exp(s[2])},
                 {q[0], q[1], q[2], q[3]},
                 1 / (1 + std::exp(-c.opacity.of(row)))};
    if (c.filter.there()) apply_filter(raw, c.filter.of(row), flat);
    return raw;
}

// Coefficient of degree 0.
Vec3<double> colour_of(const Columns& c, const double* row)
{
    if (!c.rgb[0].there()) {
        const auto dc = taken(c.dc, row);
        return {dc[0], dc[1], dc[2]};
    }
    const auto rgb = taken(c.rgb, row);
    const auto dc = [&](std::size_t k) { return (rgb[k] / c.rgb_unit - 0.5) / sh_constant; };
    return {dc(0), dc(1), dc(2)};
}

// What the stored numbers of all splats together say about their meaning.
class Ranges {
  public:
    void add(const Columns& c, const double* row)
    {
        ++count;
        const double a = c.opacity.of(row);
        least_opacity = std::min(least_opacity, a), most_opacity = std::max(most_opacity, a);
        for (const Column& s : c.scale)
            if (s.there()) least_scale = std::min(least_scale, s.of(row));
        if (c.rgb[0].there())
            for (const double v : taken(c.rgb, row)) most_colour = std::max(most_colour, v);
    }

    // Activated values that were stored without the logarithm and the logit. As logits, opacities
    // that all lie in 0 to 1 would show as 0.5 to 0.73, which no trained scene has; as logarithms,
    // scales that all are positive would show larger than the scene. A scene in millimetres is not
    // among them.
    std::vector<std::string> linear(const SplatCloud& cloud) const
    {
        std::vector<std::string> notes;
        if (count < least_for_hints) return notes;
        if (least_opacity >= 0 && most_opacity <= 1)
            notes.push_back(
                "every opacity lies in 0 to 1: are they stored linearly? Here they are read as "
                "logits");
        if (least_scale >= 0 && looks_linear(cloud))
            notes.push_back(
                "every scale is positive and most reach through the scene: are they stored "
                "linearly? Here they are read as logarithms");
        return notes;
    }

    double most_colour = 0;

  private:
    static constexpr std::size_t least_for_hints = 100;

    static bool looks_linear(const SplatCloud& cloud)
    {
        std::vector<float> longest;
        Vec3<float> low = cloud.centre.at(0), high = low;
        for (std::size_t i = 0; i < cloud.count(); ++i) {
            const Vec3<float> s = cloud.scale[i], x = cloud.centre[i];
            longest.push_back(max(s.x, max(s.y, s.z)));
            low = {min(low.x, x.x), min(low.y, x.y), min(low.z, x.z)};
            high = {max(high.x, x.x), max(high.y, x.y), max(high.z, x.z)};
        }
        const auto middle = longest.begin() + std::ptrdiff_t(longest.size() / 2);
        std::nth_element(longest.begin(), middle, longest.end());
        const double tenth = 0.1 * length(cast<double>(high) - cast<double>(low));
        return *middle > tenth && std::log(double(*middle)) < tenth;
    }

    std::size_t count = 0;
    double least_opacity = std::numeric_limits<double>::infinity(), most_opacity = -least_opacity,
           least_scale = least_opacity;
};

// Notes of a whole file; float colours beyond 1 turn out to be 0 to 255.
void add_notes(SplatFile& file, const Columns& c, const Ranges& ranges, const PlyElement& vertex)
{
    const auto note = [&](const std::string& text) { file.notes.push_back(text); };
    if (c.rgb[0].there()) {
        note(fmt::format("colours are read from {}",
                         vertex.properties[std::size_t(c.rgb[0].at)].name == "r"
                             ? "r, g, b"
                             : "red, green, blue"));
        if (c.rgb_unit == 1 && ranges.most_colour > 1.5) {
            const auto stride = std::size_t(harmonics(file.cloud.degree));
            const auto rescaled = [](float dc) {
                return float(((double(dc) * sh_constant + 0.5) / 255 - 0.5) / sh_constant);
            };
            for (std::size_t i = 0; i < file.cloud.count(); ++i) {
                Vec3<float>& dc = file.cloud.sh[i * stride];
                dc = {rescaled(dc.x), rescaled(dc.y), rescaled(dc.z)};
            }
            note("colours reach above 1: they are read as 0 to 255");
        }
    } else if (!c.dc[0].there()) {
        note("no colours: splats are grey");
    }
    if (!c.scale[2].there()) note("no third half axis: splats are flat discs");
    if (c.filter.there())
        note("filter_3D is applied to half axes and opacities; splats are marked as antialiased");
    for (const std::string& text : ranges.linear(file.cloud)) note(text);
    const std::vector<std::string> unknown = unknown_properties(vertex);
    if (unknown.empty()) return;
    constexpr std::size_t most_named = 12;
    std::string names;
    for (std::size_t k = 0; k < std::min(unknown.size(), most_named); ++k)
        names += (k > 0 ? ", " : "") + unknown[k].substr(0, 40);
    if (unknown.size() > most_named)
        names += fmt::format(" and {} more", unknown.size() - most_named);
    note("properties that are not understood and left out: " + names);
}

// Finite limit of logarithms and logits that floats read back as exactly 0 (or 1 for an opacity):
// other readers fail on infinities.
constexpr double beyond = 104;
// The logarithm of the largest float, less a step: its exponential is a float again.
constexpr double largest_logarithm = 88.7228;

float logarithm(float s)
{
    return float(std::clamp(std::log(double(s)), -beyond, largest_logarithm));
}

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
    return holds_compressed_splats(ply) || ply.find("codebook_centers") ||
           (vertex && vertex->find("scale_0") && vertex->find("rot_0") && vertex->find("opacity"));
}

namespace {

// What is done with each row of a file, and with all of them at the end.
class RowReader {
  public:
    RowReader(const PlyFile& ply, const std::string& file)
        : path(file), header(ply, file), columns(header.columns()), gather("ply", columns.degree)
    {
        gather.file.cloud.antialiased = says_antialiased(ply) || columns.filter.there();
    }

    void add(std::size_t i, const double* row)
    {
        // Reserved only now, when the file is known to be long enough.
        if (i == 0) gather.reserve(header.vertex->rows);
        ranges.add(columns, row);
        const std::size_t of_channel = columns.rest.size() / 3;
        gather.add(raw_splat(columns, row), [&](int k) -> Vec3<double> {
            if (k == 0) return colour_of(columns, row);
            const std::size_t at = std::size_t(k - 1);
            return {columns.rest[at].of(row), columns.rest[of_channel + at].of(row),
                    columns.rest[2 * of_channel + at].of(row)};
        });
    }

    // `others`: the values of the other elements.
    SplatFile read(const PlyFile& others)
    {
        SplatFile file = gather.gathered(path);
        add_notes(file, columns, ranges, *header.vertex);
        for (const std::string& text : dialect_notes(others)) file.notes.push_back(text);
        return file;
    }

  private:
    const std::string& path;
    const Header header;
    const Columns columns;
    SplatGather gather;
    Ranges ranges;
};

// Size of a row of the only element, of plain numbers, of a little-endian file; 0 for others.
std::size_t row_of_plain_file(const PlyFile& ply)
{
    if (!ply.little_endian || ply.elements.size() != 1 || ply.elements[0].name != "vertex" ||
        holds_compressed_splats(ply))
        return 0;
    std::size_t size = 0;
    for (const PlyProperty& p : ply.elements[0].properties) {
        if (p.list) return 0;
        size += size_of(p.type);
    }
    return size;
}

}  // namespace

SplatFile parse_splat_ply(const std::string& bytes, const std::string& path)
{
    const PlyFile ply = parse_ply_header(bytes, path);
    if (holds_compressed_splats(ply)) return parse_compressed_ply(bytes, path);
    refuse_other_kernels(ply, path);
    RowReader rows(ply, path);
    return rows.read(parse_ply_rows(bytes, path, "vertex",
                                    [&](std::size_t i, const double* row) { rows.add(i, row); }));
}

std::optional<SplatFile> read_plain_splat_ply(const std::string& path)
{
    constexpr std::size_t longest_header = 1 << 20, part_bytes = 4 << 20;
    std::error_code none;
    const std::uintmax_t file_size = std::filesystem::file_size(path, none);
    if (is_standard(path) || none || file_size > max_file_bytes) return {};
    const std::string start = read_start(path, longest_header);
    if (!start.starts_with("ply") || start.find("end_header") == std::string::npos) return {};
    const PlyFile ply = parse_ply_header(start, path);
    const std::size_t row = row_of_plain_file(ply);
    // What is malformed is refused with its place by the reader of whole files.
    if (row == 0 || ply.elements[0].rows == 0 || file_size != ply.body + ply.elements[0].rows * row)
        return {};
    refuse_other_kernels(ply, path);
    RowReader rows(ply, path);
    const OpenFile file(path);
    const std::size_t rows_a_part = std::max<std::size_t>(1, part_bytes / row);
    std::string part;
    std::vector<double> values(ply.elements[0].properties.size());
    for (std::size_t i = 0; i < ply.elements[0].rows; ++i) {
        const std::size_t in_part = i % rows_a_part;
        if (in_part == 0) {
            part.resize(row * std::min(rows_a_part, ply.elements[0].rows - i));
            file.read(ply.body + i * row, part.size(), part.data());
        }
        const char* at = part.data() + in_part * row;
        for (std::size_t k = 0; k < values.size(); ++k) {
            const PlyType type = ply.elements[0].properties[k].type;
            values[k] = number_of(type, at);
            at += size_of(type);
        }
        rows.add(i, values.data());
    }
    return rows.read(ply);
}

void write_splat_ply(const SplatCloud& cloud, const AddBytes& add)
{
    constexpr std::size_t part_bytes = 4 << 20;
    std::string part = header_for(cloud);
    const std::size_t stride = std::size_t(harmonics(cloud.degree));
    std::vector<float> row;
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float> x = cloud.centre[i], s = cloud.scale[i];
        const Quat<float> q = cloud.rotation[i];
        const Vec3<float>* sh = cloud.sh.data() + i * stride;
        row = {x.x, x.y, x.z, 0, 0, 0, sh[0].x, sh[0].y, sh[0].z};
        for (float Vec3<float>::*channel : {&Vec3<float>::x, &Vec3<float>::y, &Vec3<float>::z})
            for (std::size_t k = 1; k < stride; ++k) row.push_back(sh[k].*channel);
        row.insert(row.end(), {logit(cloud.opacity[i]), logarithm(s.x), logarithm(s.y),
                               logarithm(s.z), q.w, q.x, q.y, q.z});
        part.append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(float));
        if (part.size() < part_bytes) continue;
        add(part);
        part.clear();
    }
    add(part);
}

std::string splat_ply_bytes(const SplatCloud& cloud)
{
    std::string all;
    all.reserve(2048 +
                cloud.count() * sizeof(float) * (14 + 3 * std::size_t(harmonics(cloud.degree))));
    write_splat_ply(cloud, [&](const std::string& part) { all += part; });
    return all;
}

}  // namespace knead
