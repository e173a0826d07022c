#include "host/files/glb.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <utility>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/gltf_guard.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

void append(std::string& bytes, std::uint32_t word)
{
    bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

std::uint32_t word_at(const std::string& bytes, std::size_t at)
{
    std::uint32_t word;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

}  // namespace

std::size_t glb_json_size(const std::string& head, std::size_t file_size, const std::string& path)
{
    const auto fail = [&](std::size_t at, const std::string& expected, const std::string& found) {
        refuse_gltf(path, fmt::format("byte {}", at), expected, found);
    };
    if (head.size() < 20 || word_at(head, 0) != glb_magic) fail(0, "a GLB file", "something else");
    if (word_at(head, 4) != 2) fail(4, "version 2", std::to_string(word_at(head, 4)));
    if (word_at(head, 8) != file_size)
        fail(8, fmt::format("the file's {} bytes", file_size), std::to_string(word_at(head, 8)));
    const std::size_t size = word_at(head, 12);
    if (word_at(head, 16) != glb_json || 20 + size > file_size || size > max_json_bytes)
        fail(12, "a JSON chunk of at most 16 MiB inside the file", fmt::format("{} bytes", size));
    return size;
}

std::size_t glb_binary_size(const std::string& header, std::size_t at, std::size_t file_size,
                            const std::string& path)
{
    if (file_size - at < 8 || word_at(header, 4) != glb_binary ||
        word_at(header, 0) > file_size - at - 8)
        refuse_gltf(path, fmt::format("byte {}", at), "a binary chunk inside the file",
                    "something else");
    return word_at(header, 0);
}

int describe_accessor(nlohmann::json& gltf, std::size_t offset, std::size_t size, int component,
                      const char* type, std::size_t count, int target)
{
    gltf["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}, {"target", target}});
    gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size() - 1},
                                 {"componentType", component},
                                 {"count", count},
                                 {"type", type}});
    return int(gltf["accessors"].size()) - 1;
}

std::string glb_head(nlohmann::json gltf, std::size_t binary, const std::string& path,
                     const std::string& otherwise)
{
    if (binary > 0) gltf["buffers"].push_back({{"byteLength", binary}});
    std::string text = gltf.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t size = 12 + 8 + text.size() + (binary > 0 ? 8 + binary : 0);
    if (size > UINT32_MAX) throw OutputError(path + ": a GLB holds at most 4 GiB; " + otherwise);
    std::string bytes;
    for (const std::uint32_t word :
         {glb_magic, 2u, std::uint32_t(size), std::uint32_t(text.size()), glb_json})
        append(bytes, word);
    bytes += text;
    if (binary == 0) return bytes;
    append(bytes, std::uint32_t(binary));
    append(bytes, glb_binary);
    return bytes;
}

std::string glb_bytes(Glb glb, const std::string& path, const std::string& otherwise)
{
    std::string bytes = glb_head(std::move(glb.gltf), glb.binary.size(), path, otherwise);
    return bytes += glb.binary;
}

}  // namespace knead
