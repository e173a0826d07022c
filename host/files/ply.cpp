#include "host/files/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "host/base/json_reader.h"
#include "host/base/text_number.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY is read as it lies");

using Type = PlyType;
constexpr std::size_t bytes_of[] = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8, 0};

Type type_named(std::string_view name)
{
    constexpr std::pair<std::string_view, Type> names[] = {
        {"char", Type::i8},     {"uchar", Type::u8},   {"short", Type::i16},
        {"ushort", Type::u16},  {"int", Type::i32},    {"uint", Type::u32},
        {"float", Type::f32},   {"double", Type::f64}, {"int8", Type::i8},
        {"uint8", Type::u8},    {"int16", Type::i16},  {"uint16", Type::u16},
        {"int32", Type::i32},   {"uint32", Type::u32}, {"float32", Type::f32},
        {"float64", Type::f64}, {"half", Type::f16},   {"float16", Type::f16},
        {"int64", Type::i64},   {"uint64", Type::u64}};
    for (const auto& [n, t] : names)
        if (n == name) return t;
    return Type::none;
}

template <class T>
double loaded(const char* at)
{
    T value;
    std::memcpy(&value, at, sizeof value);
    return double(value);
}

double load(Type type, const char* at)
{
    switch (type) {
        case Type::i8:
            return loaded<std::int8_t>(at);
        case Type::u8:
            return loaded<std::uint8_t>(at);
        case Type::i16:
            return loaded<std::int16_t>(at);
        case Type::u16:
            return loaded<std::uint16_t>(at);
        case Type::i32:
            return loaded<std::int32_t>(at);
        case Type::u32:
            return loaded<std::uint32_t>(at);
        case Type::i64:
            return loaded<std::int64_t>(at);
        case Type::u64:
            return loaded<std::uint64_t>(at);
        case Type::f16:
            return half_number(std::uint16_t(loaded<std::uint16_t>(at)));
        case Type::f32:
            return loaded<float>(at);
        case Type::f64:
            return loaded<double>(at);
        case Type::none:
            break;
    }
    return std::nan("");
}

struct Types {
    Type count = Type::none, value = Type::none;
};

class Parser {
  public:
    Parser(const std::string& all, const std::string& file) : bytes(all), path(file) {}

    PlyFile parse_header()
    {
        header();
        return std::move(ply);
    }

    PlyFile parse()
    {
        header();
        for (std::size_t e = 0; e < ply.elements.size(); ++e) body(ply.elements[e], types[e]);
        return std::move(ply);
    }

    PlyFile parse_rows(const std::string& element, const PlyVisit& visit)
    {
        header();
        const PlyElement* visited = ply.find(element);
        for (std::size_t e = 0; e < ply.elements.size(); ++e)
            if (&ply.elements[e] == visited)
                show(ply.elements[e], types[e], visit);
            else
                body(ply.elements[e], types[e]);
        if (ascii) at = std::min(bytes.find_first_not_of(" \t\r\n", at), bytes.size());
        if (at != bytes.size())
            fail("the end of the file", fmt::format("{} bytes more", bytes.size() - at));
        return std::move(ply);
    }

  private:
    [[noreturn]] void fail(const std::string& expected, const std::string& found) const
    {
        throw InputError(
            fmt::format("{}: byte {}: expected {}, found {}", path, at, expected, found));
    }

    // Lines end as the first one does: what follows the last may be binary, and begin with LF.
    std::string_view line()
    {
        const std::size_t end = bytes.find(line_end, at);
        if (end == std::string::npos || end - at > 4096) fail("a line of the PLY header", "none");
        std::string_view text(bytes.data() + at, end - at);
        if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
        next = end + 1;
        return text;
    }

    static std::vector<std::string_view> words(std::string_view text)
    {
        std::vector<std::string_view> all;
        for (std::size_t i = 0; i < text.size();) {
            const std::size_t from = text.find_first_not_of(" \t", i);
            if (from == std::string_view::npos) break;
            i = std::min(text.find_first_of(" \t", from), text.size());
            all.push_back(text.substr(from, i - from));
        }
        return all;
    }

    void header()
    {
        at = text_begin(bytes, path);
        const std::size_t end = std::min(bytes.find_first_of("\r\n", at), bytes.size());
        if (bytes.compare(end, 1, "\r") == 0 && bytes.compare(end, 2, "\r\n") != 0) line_end = '\r';
        if (line() != "ply") fail("a PLY file, which begins with \"ply\"", "something else");
        bool format = false;
        for (at = next;; at = next) {
            const std::string_view text = line();
            const std::vector<std::string_view> w = words(text);
            if (w.empty()) continue;
            if (w[0] == "end_header") break;
            if (w[0] == "comment" || w[0] == "obj_info")
                ply.comments.emplace_back(text.substr(std::min(text.size(), w[0].size() + 1)));
            else if (w[0] == "format")
                format = true, read_format(w);
            else if (w[0] == "element")
                read_element(w);
            else if (w[0] == "property")
                read_property(w);
            else
                fail("a PLY header line", "\"" + std::string(text.substr(0, 60)) + "\"");
        }
        if (!format) fail("a \"format\" line before \"end_header\"", "none");
        at = next;
        ply.little_endian = !ascii && !swapped;
        ply.body = at;
    }

    void read_format(const std::vector<std::string_view>& w)
    {
        ascii = w.size() > 1 && w[1] == "ascii";
        swapped = w.size() > 1 && w[1] == "binary_big_endian";
        if (!ascii && !swapped && (w.size() < 2 || w[1] != "binary_little_endian"))
            fail("format ascii, binary_little_endian or binary_big_endian",
                 w.size() > 1 ? std::string(w[1].substr(0, 40)) : "nothing");
    }

    void read_element(const std::vector<std::string_view>& w)
    {
        std::size_t rows = 0;
        const bool good =
            w.size() == 3 &&
            std::from_chars(w[2].data(), w[2].data() + w[2].size(), rows).ec == std::errc();
        if (!good || rows > max_file_bytes || ply.elements.size() >= 64)
            fail("\"element NAME ROWS\"", "something else");
        ply.elements.push_back({std::string(w[1]), rows, {}});
        types.emplace_back();
    }

    void read_property(const std::vector<std::string_view>& w)
    {
        const bool list = w.size() == 5 && w[1] == "list";
        if (ply.elements.empty() || (!list && w.size() != 3) ||
            ply.elements.back().properties.size() >= 1024)
            fail("\"property TYPE NAME\" after an element", "something else");
        Types t;
        if (list) t.count = type_named(w[2]);
        t.value = type_named(w[list ? 3 : 1]);
        if (t.value == Type::none || (list && (t.count == Type::none || t.count >= Type::f16)))
            fail("a PLY number type", "\"" + std::string(w[1].substr(0, 40)) + "\"");
        PlyElement& element = ply.elements.back();
        const std::string name(w.back());
        if (element.find(name)) fail("each property once", "\"" + name + "\" twice");
        element.properties.push_back({name, list, t.value, {}, {}});
        types.back().push_back(t);
    }

    double number(Type type)
    {
        if (!ascii) {
            const std::size_t size = bytes_of[int(type)];
            if (bytes.size() - at < size) fail("more bytes", "the end of the file");
            char value[8];
            std::memcpy(value, bytes.data() + at, size);
            if (swapped) std::reverse(value, value + size);
            at += size;
            return load(type, value);
        }
        at = std::min(bytes.find_first_not_of(" \t\r\n", at), bytes.size());
        if (at == bytes.size()) fail("a number", "the end of the file");
        const std::size_t end = std::min(bytes.find_first_of(" \t\r\n", at), bytes.size());
        const std::string_view word(bytes.data() + at, end - at);
        const TextNumber found = text_number(word);
        if (!found.fault.empty())
            fail("a number", fmt::format("\"{}\"{}", word.substr(0, 60), in_brackets(found.fault)));
        at = end;
        return found.value;
    }

    // Rejects more rows than the file can hold.
    void check_rows(const PlyElement& element, const std::vector<Types>& of) const
    {
        std::size_t min_row = 0;
        for (const Types& t : of)
            min_row += ascii ? 2 : bytes_of[int(t.count == Type::none ? t.value : t.count)];
        if (element.rows > 0 &&
            element.rows > (bytes.size() - at + 1) / std::max<std::size_t>(1, min_row))
            fail(fmt::format("{} rows of \"{}\", at least {} bytes each", element.rows,
                             element.name, min_row),
                 fmt::format("{} bytes left", bytes.size() - at));
    }

    void body(PlyElement& element, const std::vector<Types>& of)
    {
        check_rows(element, of);
        for (PlyProperty& p : element.properties) {
            if (p.list) p.start.reserve(element.rows + 1), p.start.push_back(0);
            p.values.reserve(element.rows);
        }
        for (std::size_t row = 0; row < element.rows && !of.empty(); ++row)
            for (std::size_t k = 0; k < of.size(); ++k) read_value(element.properties[k], of[k]);
    }

    void show(const PlyElement& element, const std::vector<Types>& of, const PlyVisit& visit)
    {
        check_rows(element, of);
        for (const PlyProperty& p : element.properties)
            if (p.list) fail("a single number for \"" + p.name + "\"", "a list");
        std::vector<double> row(of.size());
        for (std::size_t i = 0; i < element.rows; ++i) {
            for (std::size_t k = 0; k < of.size(); ++k) row[k] = number(of[k].value);
            visit(i, row.data());
        }
    }

    void read_value(PlyProperty& p, const Types& t)
    {
        if (!p.list) return p.values.push_back(number(t.value));
        const double count = number(t.count);
        const double room =
            double(bytes.size() - at + 1) / double(ascii ? 2 : bytes_of[int(t.value)]);
        if (!(count >= 0 && count <= room))
            fail("a list that the file can hold", short_number(count));
        for (int i = 0; i < int(count); ++i) p.values.push_back(number(t.value));
        p.start.push_back(p.values.size());
    }

    const std::string& bytes;
    const std::string& path;
    std::size_t at = 0, next = 0;
    char line_end = '\n';
    bool ascii = false, swapped = false;  // swapped: binary, big-endian
    PlyFile ply;
    std::vector<std::vector<Types>> types;  // per element and property
};

}  // namespace

const PlyProperty* PlyElement::find(const std::string& property) const
{
    for (const PlyProperty& p : properties)
        if (p.name == property) return &p;
    return nullptr;
}

const PlyElement* PlyFile::find(const std::string& element) const
{
    for (const PlyElement& e : elements)
        if (e.name == element) return &e;
    return nullptr;
}

std::size_t size_of(PlyType type) { return bytes_of[int(type)]; }

double number_of(PlyType type, const char* little_endian) { return load(type, little_endian); }

PlyFile parse_ply(const std::string& bytes, const std::string& path)
{
    return Parser(bytes, path).parse();
}

PlyFile parse_ply_header(const std::string& bytes, const std::string& path)
{
    return Parser(bytes, path).parse_header();
}

PlyFile parse_ply_rows(const std::string& bytes, const std::string& path,
                       const std::string& element, const PlyVisit& visit)
{
    return Parser(bytes, path).parse_rows(element, visit);
}

double half_number(std::uint16_t bits)
{
    const int exponent = bits >> 10 & 31, fraction = bits & 1023;
    const double magnitude = exponent == 31  ? (fraction ? std::nan("") : HUGE_VAL)
                             : exponent == 0 ? std::ldexp(fraction, -24)
                                             : std::ldexp(1024 + fraction, exponent - 25);
    return bits >> 15 ? -magnitude : magnitude;
}

PlyFile read_ply(const std::string& path)
{
    return parse_ply(read_text(path, max_file_bytes), path);
}

}  // namespace knead
