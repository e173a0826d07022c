// Binary glTF 2.0, as far as triangles need it: one buffer, inside the file; no transforms.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "host/base/json_reader.h"
#include "host/files/mesh_reader.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is read as it lies");
constexpr std::uint32_t magic = 0x46546c67, chunk_json = 0x4e4f534a, chunk_binary = 0x004e4942;
enum Component : int { byte_index = 5121, short_index = 5123, long_index = 5125, real = 5126 };

std::uint32_t word(const std::string& bytes, std::size_t at)
{
    std::uint32_t w;
    std::memcpy(&w, bytes.data() + at, 4);
    return w;
}

class Glb {
  public:
    Glb(const std::string& all, const std::string& file) : bytes(all), path(file) { split(); }

    std::vector<Mesh> meshes()
    {
        std::vector<Mesh> all;
        const Json& nodes = list(root, "nodes");
        for (std::size_t i = 0; i < nodes.size(); ++i)
            for (const char* key : {"matrix", "translation", "rotation", "scale"})
                if (nodes[i].contains(key))
                    fail(fmt::format("/nodes/{}/{}", i, key), "no transform (apply it first)",
                         "one");
        const Json& given = list(root, "meshes");
        for (std::size_t m = 0; m < given.size(); ++m) {
            const std::string at = fmt::format("/meshes/{}", m);
            const Json& primitives = list(given[m], "primitives");
            for (std::size_t p = 0; p < primitives.size(); ++p)
                all.push_back(mesh(primitives[p], at + fmt::format("/primitives/{}", p), given[m]));
        }
        if (all.empty()) fail("/meshes", "at least one", "none");
        return all;
    }

  private:
    [[noreturn]] void fail(const std::string& where, const std::string& expected,
                           const std::string& found) const
    {
        throw InputError(
            fmt::format("{}: {}: expected {}, found {}", path, where, expected, found));
    }

    // Header and two chunks.
    void split()
    {
        if (bytes.size() < 20 || word(bytes, 0) != magic)
            fail("byte 0", "a GLB file", "something else");
        if (word(bytes, 4) != 2) fail("byte 4", "version 2", std::to_string(word(bytes, 4)));
        if (word(bytes, 8) != bytes.size())
            fail("byte 8", fmt::format("the file's {} bytes", bytes.size()),
                 std::to_string(word(bytes, 8)));
        const std::size_t size = word(bytes, 12);
        if (word(bytes, 16) != chunk_json || size > bytes.size() - 20 || size > (64u << 20))
            fail("byte 12", "a JSON chunk inside the file", fmt::format("{} bytes", size));
        root = parse_json(bytes.substr(20, size), path);
        if (!root.is_object()) fail("/", "an object", described(root));
        const std::size_t at = 20 + size;
        if (bytes.size() - at < 8) return;
        if (word(bytes, at + 4) != chunk_binary || word(bytes, at) > bytes.size() - at - 8)
            fail(fmt::format("byte {}", at), "a binary chunk inside the file", "something else");
        begin = at + 8, length = word(bytes, at);
    }

    static const Json& list(const Json& from, const char* key)
    {
        static const Json none = Json::array();
        const auto at = from.is_object() ? from.find(key) : from.end();
        return from.is_object() && at != from.end() && at->is_array() ? *at : none;
    }

    // A whole number below 2^32; `fallback` where absent, if that is not negative.
    std::size_t number(const Json& from, const char* key, const std::string& where,
                       long fallback) const
    {
        if (from.is_object() && !from.contains(key) && fallback >= 0) return std::size_t(fallback);
        if (!from.is_object() || !from.contains(key)) fail(where + "/" + key, "a number", "none");
        const Json& n = from[key];
        if (!n.is_number_unsigned() || n.get<std::uint64_t>() > 0xffffffffu)
            fail(where + "/" + key, "a whole number below 2^32", described(n));
        return n.get<std::size_t>();
    }

    const Json& entry(const char* of, std::size_t index) const
    {
        const Json& all = list(root, of);
        if (index >= all.size())
            fail(std::string("/") + of, fmt::format("entry {}", index),
                 fmt::format("{} of them", all.size()));
        return all[index];
    }

    // Calls visit(i, where element i lies) for every element of `width` bytes of an accessor.
    template <class Visit>
    std::size_t each(std::size_t index, std::size_t width, Visit&& visit) const
    {
        const std::string where = fmt::format("/accessors/{}", index);
        const Json& a = entry("accessors", index);
        if (a.contains("sparse")) fail(where + "/sparse", "a plain accessor", "a sparse one");
        const std::size_t view_index = number(a, "bufferView", where, -1);
        const Json& view = entry("bufferViews", view_index);
        const std::string there = fmt::format("/bufferViews/{}", view_index);
        if (number(view, "buffer", there, -1) != 0) fail(there + "/buffer", "0", "another buffer");
        const std::size_t count = number(a, "count", where, -1);
        const std::size_t stride = number(view, "byteStride", there, long(width));
        const std::size_t from =
            number(view, "byteOffset", there, 0) + number(a, "byteOffset", where, 0);
        const std::size_t needed = count ? from + (count - 1) * stride + width : from;
        if (stride < width || stride > 252 || count > 0x7fffffff || needed > length)
            fail(where, fmt::format("at most the {} bytes of the file's buffer", length),
                 fmt::format("{} elements that end at {}", count, needed));
        for (std::size_t i = 0; i < count; ++i) visit(i, bytes.data() + begin + from + i * stride);
        return count;
    }

    Mesh mesh(const Json& primitive, const std::string& where, const Json& of) const
    {
        Mesh m;
        if (number(primitive, "mode", where, 4) != 4)
            fail(where + "/mode", "triangles (4)", "another");
        const Json attributes = primitive.value("attributes", Json::object());
        const std::size_t positions = number(attributes, "POSITION", where + "/attributes", -1);
        if (number(entry("accessors", positions), "componentType", "/accessors", -1) != real)
            fail(where, "positions of 32-bit reals", "others");
        each(positions, 12, [&](std::size_t, const char* at) {
            Vec3<float> v;
            std::memcpy(&v, at, 12);
            m.vertices.push_back(v);
        });
        const std::vector<int> corners = indices(primitive, where, m.vertices.size());
        if (corners.size() % 3 != 0)
            fail(where, "three corners a triangle", std::to_string(corners.size()));
        for (std::size_t i = 0; i < corners.size(); i += 3)
            m.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        const std::string name =
            of.contains("name") && of["name"].is_string() ? of["name"].get<std::string>() : "";
        for (int c = 0; c < 256; ++c)
            if (name == fmt::format("category {}", c)) m.category = c;
        finish_mesh(m, path);
        return m;
    }

    std::vector<int> indices(const Json& primitive, const std::string& where,
                             std::size_t count) const
    {
        std::vector<int> all;
        if (!primitive.contains("indices")) {
            for (std::size_t i = 0; i < count; ++i) all.push_back(int(i));
            return all;
        }
        const std::size_t index = number(primitive, "indices", where, -1);
        const std::size_t type =
            number(entry("accessors", index), "componentType", "/accessors", -1);
        const std::size_t width = type == byte_index ? 1 : type == short_index ? 2 : 4;
        if (width == 4 && type != long_index) fail(where, "indices of whole numbers", "others");
        each(index, width, [&](std::size_t, const char* at) {
            std::uint32_t v = 0;
            std::memcpy(&v, at, width);
            all.push_back(v < count ? int(v) : -1);
        });
        return all;
    }

    const std::string& bytes;
    const std::string& path;
    Json root;
    std::size_t begin = 0, length = 0;  // of the binary chunk
};

}  // namespace

std::vector<Mesh> parse_glb(const std::string& bytes, const std::string& path)
{
    return Glb(bytes, path).meshes();
}

}  // namespace knead
