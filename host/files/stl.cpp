#include "host/files/stl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <unordered_map>

#include "host/base/errors.h"
#include "host/base/text_number.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies");
constexpr std::size_t head_size = 80, facets_at = 84, facet_size = 50;

// Merges coincident corners into one vertex.
class Corners {
  public:
    explicit Corners(FileMesh& of) : mesh(of) {}
    int index(Vec3<double> x)
    {
        x = {x.x + 0.0, x.y + 0.0, x.z + 0.0};  // -0 equals 0
        const auto [at, is_new] = known.try_emplace(std::bit_cast<std::array<std::uint64_t, 3>>(x),
                                                    int(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back(x);
        return at->second;
    }

  private:
    struct Hash {
        std::size_t operator()(const std::array<std::uint64_t, 3>& key) const
        {
            std::uint64_t h = 0;
            for (const std::uint64_t word : key) {
                h = (h ^ word) * 0x9e3779b97f4a7c15u;
                h ^= h >> 29;
            }
            return std::size_t(h);
        }
    };
    FileMesh& mesh;
    std::unordered_map<std::array<std::uint64_t, 3>, int, Hash> known;
};

std::uint32_t promised(const std::string& bytes)
{
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + head_size, sizeof count);
    return count;
}

// Some binary files begin with "solid", too; they are identified by a size that matches their
// count.
bool is_binary(const std::string& bytes)
{
    return bytes.size() >= facets_at &&
           bytes.size() == facets_at + facet_size * std::size_t(promised(bytes));
}

FileMesh from_binary(const std::string& bytes)
{
    FileMesh mesh;
    Corners corners(mesh);
    for (std::size_t at = facets_at; at < bytes.size(); at += facet_size) {
        float numbers[12];  // the normal, which is recomputed, and three corners
        std::memcpy(numbers, bytes.data() + at, sizeof numbers);
        const auto corner = [&](int k) {
            return corners.index(
                {double(numbers[3 * k]), double(numbers[3 * k + 1]), double(numbers[3 * k + 2])});
        };
        const int a = corner(1), b = corner(2), c = corner(3);
        mesh.triangles.push_back({a, b, c});
    }
    return mesh;
}

// Whether a word is this one, in any case. `word`: in lower case.
bool is_word(std::string_view found, std::string_view word)
{
    return std::ranges::equal(found, word, [](char a, char b) {
        return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b;
    });
}

// The words of a text, with the line of each.
class Words {
  public:
    Words(const std::string& of, const std::string& from)
        : text(of), path(from), at(text_begin(of, from))
    {
    }
    std::string_view next()  // "" at the end
    {
        at = std::min(text.find_first_not_of(blank, at), text.size());
        const std::size_t from = at;
        at = std::min(text.find_first_of(blank, at), text.size());
        return std::string_view(text).substr(from, at - from);
    }
    void skip_line() { at = std::min(text.find_first_of("\r\n", at), text.size()); }
    void expect(const char* word)
    {
        const std::string_view found = next();
        if (!is_word(found, word)) refuse(fmt::format("\"{}\"", word), found);
    }
    double number()
    {
        const std::string_view word = next();
        const TextNumber found = finite_text_number(word);
        if (!found.fault.empty()) refuse("a finite number", word, found.fault);
        return found.value;
    }
    void skip_normal()  // which exporters of thin triangles write as "nan"
    {
        for (int k = 0; k < 3; ++k)
            if (const std::string_view word = next(); !text_number(word).fault.empty())
                refuse("a number", word, text_number(word).fault);
    }
    [[noreturn]] void refuse(const std::string& expected, std::string_view found,
                             std::string_view why = {}) const
    {
        const std::string said =
            found.empty() ? "the end of the file" : fmt::format("\"{}\"", found.substr(0, 60));
        throw InputError(fmt::format("{}: line {}: expected {}, found {}{}", path, line(), expected,
                                     said, in_brackets(why)));
    }

  private:
    static constexpr const char* blank = " \t\r\n";
    // Of the last word.
    std::size_t line() const
    {
        const std::string_view before = std::string_view(text).substr(0, at);
        std::size_t count = 0;
        for (std::size_t from = 0; from < before.size(); ++count) next_line(before, from);
        const bool next = before.ends_with('\n') || before.ends_with('\r');
        return std::max<std::size_t>(count + next, 1);
    }

    const std::string &text, &path;
    std::size_t at;
};

void take_facet(Words& words, Corners& corners, FileMesh& mesh)
{
    words.expect("normal");
    words.skip_normal();
    words.expect("outer"), words.expect("loop");
    int corner[3];
    for (int& one : corner) {
        words.expect("vertex");
        const double x = words.number(), y = words.number(), z = words.number();
        one = corners.index({x, y, z});
    }
    words.expect("endloop"), words.expect("endfacet");
    mesh.triangles.push_back({corner[0], corner[1], corner[2]});
}

FileMesh from_text(const std::string& text, const std::string& path)
{
    FileMesh mesh;
    Corners corners(mesh);
    Words words(text, path);
    bool inside = false;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        if (is_word(word, inside ? "endsolid" : "solid")) {
            words.skip_line();  // name of the solid
            inside = !inside;
        } else if (inside && is_word(word, "facet")) {
            take_facet(words, corners, mesh);
        } else {
            words.refuse(inside ? "\"facet\" or \"endsolid\"" : "\"solid\"", word);
        }
    }
    if (inside) words.refuse("\"endsolid\"", "");
    return mesh;
}

bool begins_text_stl(const std::string& bytes, const std::string& path)
{
    const std::size_t from = bytes.find_first_not_of(" \t\r\n", text_begin(bytes, path));
    return from != std::string::npos && is_word(std::string_view(bytes).substr(from, 5), "solid");
}

Vec3<float> facet_normal(Vec3<float> a, Vec3<float> b, Vec3<float> c)
{
    const Vec3<float> n = cross(b - a, c - a);
    const float size = length(n);
    return size > 0 && std::isfinite(size) ? (1 / size) * n : Vec3<float>{0, 0, 0};
}

}  // namespace

FileMesh parse_stl(const std::string& bytes, const std::string& path)
{
    FileMesh mesh;
    if (is_binary(bytes))
        mesh = from_binary(bytes);
    else if (begins_text_stl(bytes, path))
        mesh = from_text(bytes, path);
    else if (bytes.size() < facets_at)
        throw InputError(
            fmt::format("{}: expected an STL of {} bytes at least, or one that begins "
                        "with \"solid\", found {} bytes",
                        path, facets_at, bytes.size()));
    else
        throw InputError(
            fmt::format("{}: byte {}: expected as many triangles of {} bytes as fill "
                        "the file's {}, found a count of {}",
                        path, head_size, facet_size, bytes.size(), promised(bytes)));
    check_mesh(mesh, path);
    return mesh;
}

std::string stl_bytes(const std::vector<const Mesh*>& meshes, const std::string& path,
                      const std::string& unit)
{
    std::size_t count = 0;
    for (const Mesh* mesh : meshes) count += mesh->triangles.size();
    if (count > UINT32_MAX) throw OutputError(path + ": an STL holds at most 2^32 - 1 triangles");
    std::string bytes = "knead; " + unit;  // never "solid", which marks a text
    bytes.resize(head_size, ' ');
    bytes.reserve(facets_at + facet_size * count);
    const auto append = [&](const auto& value) {
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    append(std::uint32_t(count));
    for (const Mesh* mesh : meshes)
        for (const Int3 t : mesh->triangles) {
            const auto at = [&](int v) { return mesh->vertices[std::size_t(v)]; };
            const Vec3<float> a = at(t.x), b = at(t.y), c = at(t.z);
            append(facet_normal(a, b, c)), append(a), append(b), append(c);
            append(std::uint16_t(0));
        }
    return bytes;
}

}  // namespace knead
