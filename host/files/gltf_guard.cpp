// Sanitises a .glb before tinygltf parses it: checks its container and its document.
#include "host/files/gltf_guard.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/files/glb.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is read as it lies");
constexpr std::size_t json_start = 20;
constexpr std::size_t max_parts = 1 << 16;

// Keys that are read. All others, including images, extensions and extras but for a mesh's
// category, are removed before tinygltf parses the document; for the remaining keys it would treat
// a value of another type as absent, and its errors give no place.
enum class Kind {
    index,
    size,
    text,
    flag,
    numbers,
    indices,
    part_list,
    attributes,
    extras,
    sparse,
    sparse_part
};
struct Key {
    const char *section, *name;
    Kind kind;
    bool required = false;
};
constexpr Key keys[] = {{"asset", "version", Kind::text, true},
                        {"buffers", "byteLength", Kind::size, true},
                        {"buffers", "uri", Kind::text},
                        {"bufferViews", "buffer", Kind::index, true},
                        {"bufferViews", "byteOffset", Kind::size},
                        {"bufferViews", "byteLength", Kind::size, true},
                        {"bufferViews", "byteStride", Kind::size},
                        {"accessors", "bufferView", Kind::index},
                        {"accessors", "byteOffset", Kind::size},
                        {"accessors", "componentType", Kind::size, true},
                        {"accessors", "count", Kind::size, true},
                        {"accessors", "type", Kind::text, true},
                        {"accessors", "normalized", Kind::flag},
                        {"accessors", "sparse", Kind::sparse},
                        {"sparse", "count", Kind::size, true},
                        {"sparse", "indices", Kind::sparse_part, true},
                        {"sparse", "values", Kind::sparse_part, true},
                        {"sparse part", "bufferView", Kind::index, true},
                        {"sparse part", "byteOffset", Kind::size},
                        {"sparse part", "componentType", Kind::size},
                        {"meshes", "name", Kind::text},
                        {"meshes", "primitives", Kind::part_list, true},
                        {"meshes", "extras", Kind::extras},
                        {"primitives", "attributes", Kind::attributes, true},
                        {"primitives", "indices", Kind::index},
                        {"primitives", "mode", Kind::index},
                        {"nodes", "name", Kind::text},
                        {"nodes", "mesh", Kind::index},
                        {"nodes", "skin", Kind::index},
                        {"nodes", "children", Kind::indices},
                        {"scenes", "nodes", Kind::indices},
                        {"nodes", "matrix", Kind::numbers},
                        {"nodes", "translation", Kind::numbers},
                        {"nodes", "rotation", Kind::numbers},
                        {"nodes", "scale", Kind::numbers},
                        {"skins", "joints", Kind::indices, true},
                        {"skins", "inverseBindMatrices", Kind::index, true}};

std::uint32_t word(const std::string& bytes, std::size_t at)
{
    std::uint32_t w;
    std::memcpy(&w, bytes.data() + at, 4);
    return w;
}

void put(std::string& bytes, std::size_t at, std::uint32_t w)
{
    std::memcpy(bytes.data() + at, &w, 4);
}

class Guard {
  public:
    explicit Guard(const std::string& file) : path(file) {}

    // Size of the JSON chunk. Checks that both chunks lie inside the file: tinygltf 2.7 accepts a
    // second chunk that ends 8 bytes after it.
    std::size_t json_size(const std::string& bytes) const
    {
        const auto fail = [&](std::size_t byte, const std::string& expected,
                              const std::string& found) {
            refuse_gltf(path, fmt::format("byte {}", byte), expected, found);
        };
        if (bytes.size() < json_start || word(bytes, 0) != glb_magic)
            fail(0, "a GLB file", "something else");
        if (word(bytes, 4) != 2) fail(4, "version 2", std::to_string(word(bytes, 4)));
        if (word(bytes, 8) != bytes.size())
            fail(8, fmt::format("the file's {} bytes", bytes.size()),
                 std::to_string(word(bytes, 8)));
        const std::size_t size = word(bytes, 12), end = json_start + size;
        if (word(bytes, 16) != glb_json || end > bytes.size() || size > max_json_bytes)
            fail(12, "a JSON chunk of at most 16 MiB inside the file",
                 fmt::format("{} bytes", size));
        if (bytes.size() == end) return size;
        if (bytes.size() - end < 8 || word(bytes, end + 4) != glb_binary ||
            word(bytes, end) > bytes.size() - end - 8)
            fail(end, "a binary chunk inside the file", "something else");
        return size;
    }

    // The document reduced to the keys that are read.
    Json needed(const Json& all, GltfSkins skins) const
    {
        need(all.is_object(), "/", "an object", all);
        Json out = Json::object();
        if (!all.contains("asset")) refuse_gltf(path, "/asset", "an object", "nothing");
        out["asset"] = object(all["asset"], "asset", "/asset");
        check_extensions(all);
        for (const char* section :
             {"buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes"})
            add_list(out, all, section);
        if (all.contains("scene")) out["scene"] = value(all["scene"], Kind::index, "/scene");
        if (skins == GltfSkins::read) add_list(out, all, "skins");
        // tinygltf copies the whole chunk for each buffer.
        const Json buffers = out.value("buffers", Json::array());
        need(buffers.size() <= 1, "/buffers", "at most one", buffers);
        check_parts(out.value("meshes", Json::array()));
        if (!buffers.empty() && buffers[0].contains("uri"))
            need(false, "/buffers/0/uri", "none: the buffer inside the file", buffers[0]["uri"]);
        return out;
    }

  private:
    // What a file requires must be understood to show it as it is meant. Of the materials' it is
    // only the look.
    void check_extensions(const Json& all) const
    {
        const auto at = all.find("extensionsRequired");
        if (at == all.end()) return;
        need(at->is_array(), "/extensionsRequired", "an array", *at);
        for (std::size_t i = 0; i < at->size(); ++i) {
            const std::string where = fmt::format("/extensionsRequired/{}", i);
            need((*at)[i].is_string(), where, "a text", (*at)[i]);
            const std::string name = (*at)[i].get<std::string>();
            if (name == "KHR_mesh_quantization" || name == "EXT_mesh_gpu_instancing" ||
                name == "KHR_lights_punctual" || name.starts_with("KHR_materials_"))
                continue;
            std::string expected = "no extension that is not known here";
            if (name == "KHR_draco_mesh_compression" || name.ends_with("_meshopt_compression"))
                expected =
                    "plain data (decompress it: `gltf-transform copy IN OUT`, or import and export "
                    "it with Blender)";
            refuse_gltf(path, where, expected, name.substr(0, 60));
        }
    }

    void need(bool holds, const std::string& where, const std::string& expected,
              const Json& found) const
    {
        if (!holds) refuse_gltf(path, where, expected, described(found));
    }

    // Limits the number of primitives: each takes time and memory, however few vertices it has.
    void check_parts(const Json& meshes) const
    {
        std::size_t parts = 0;
        for (const Json& mesh : meshes) parts += mesh["primitives"].size();
        if (parts > max_parts)
            refuse_gltf(path, "/meshes", fmt::format("at most {} primitives in all", max_parts),
                        std::to_string(parts));
    }

    void add_list(Json& out, const Json& all, const char* section) const
    {
        const auto at = all.find(section);
        if (at != all.end()) out[section] = list(*at, section, fmt::format("/{}", section));
    }

    Json list(const Json& all, const char* section, const std::string& where) const
    {
        need(all.is_array(), where, "an array", all);
        Json out = Json::array();
        for (std::size_t i = 0; i < all.size(); ++i)
            out.push_back(object(all[i], section, fmt::format("{}/{}", where, i)));
        return out;
    }

    Json object(const Json& one, const std::string& section, const std::string& where) const
    {
        need(one.is_object(), where, "an object", one);
        Json out = Json::object();
        for (const Key& key : keys) {
            if (section != key.section) continue;
            const std::string at = where + "/" + key.name;
            if (one.contains(key.name))
                out[key.name] = value(one[key.name], key.kind, at);
            else if (key.required)
                refuse_gltf(path, at, "it", "nothing");
        }
        return out;
    }

    Json value(const Json& v, Kind kind, const std::string& where) const
    {
        const auto whole = [&](std::uint64_t max) {
            return v.is_number_unsigned() && v.get<std::uint64_t>() <= max;
        };
        if (kind == Kind::index) need(whole(0x7fffffff), where, "a whole number below 2^31", v);
        if (kind == Kind::size) need(whole(0xffffffff), where, "a whole number below 2^32", v);
        if (kind == Kind::text) need(v.is_string(), where, "a text", v);
        if (kind == Kind::flag) need(v.is_boolean(), where, "true or false", v);
        if (kind == Kind::part_list) return list(v, "primitives", where);
        if (kind == Kind::extras) return category_in(v);
        if (kind == Kind::sparse) return object(v, "sparse", where);
        if (kind == Kind::sparse_part) return object(v, "sparse part", where);
        if (kind == Kind::attributes) {
            need(v.is_object(), where, "an object", v);
            for (const auto& [name, index] : v.items())
                value(index, Kind::index, where + "/" + name);
        }
        if (kind == Kind::numbers || kind == Kind::indices) {
            need(v.is_array(), where, "an array", v);
            for (std::size_t i = 0; i < v.size(); ++i) {
                const std::string at = fmt::format("{}/{}", where, i);
                need(v[i].is_number(), at, "a number", v[i]);
                if (kind == Kind::indices) value(v[i], Kind::index, at);
            }
        }
        return v;
    }

    // Other programs may write anything there: what is no category is removed, not refused.
    static Json category_in(const Json& extras)
    {
        Json out = Json::object();
        if (!extras.is_object()) return out;
        const auto at = extras.find("category");
        if (at != extras.end() && at->is_number_unsigned() && at->get<std::uint64_t>() < 256)
            out["category"] = *at;
        return out;
    }

    const std::string& path;
};

}  // namespace

void refuse_gltf(const std::string& path, const std::string& where, const std::string& expected,
                 const std::string& found)
{
    throw InputError(fmt::format("{}: {}: expected {}, found {}", path, where, expected, found));
}

GuardedGlb guarded_glb(std::string bytes, const std::string& path, GltfSkins skins)
{
    const Guard guard(path);
    const std::size_t size = guard.json_size(bytes);
    Json document = parse_json(bytes.substr(json_start, size), path);
    std::string text = guard.needed(document, skins).dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    bytes.replace(json_start, size, text);
    if (bytes.size() > 0xffffffffu) refuse_gltf(path, "byte 8", "at most 4 GiB", "more");
    put(bytes, 8, std::uint32_t(bytes.size()));
    put(bytes, 12, std::uint32_t(text.size()));
    return {std::move(bytes), std::move(document)};
}

}  // namespace knead
