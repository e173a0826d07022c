#include "host/files/glb.h"

#include <bit>

#include "host/base/errors.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

void append(std::string& bytes, std::uint32_t word)
{
    bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

}  // namespace

std::string glb_bytes(Glb glb, const std::string& path, const std::string& otherwise)
{
    const bool holds = !glb.binary.empty();
    if (holds) glb.gltf["buffers"].push_back({{"byteLength", glb.binary.size()}});
    std::string text = glb.gltf.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t size = 12 + 8 + text.size() + (holds ? 8 + glb.binary.size() : 0);
    if (size > UINT32_MAX) throw OutputError(path + ": a GLB holds at most 4 GiB; " + otherwise);
    std::string bytes;
    bytes.reserve(size);
    for (const std::uint32_t word :
         {glb_magic, 2u, std::uint32_t(size), std::uint32_t(text.size()), glb_json})
        append(bytes, word);
    bytes += text;
    if (!holds) return bytes;
    append(bytes, std::uint32_t(glb.binary.size()));
    append(bytes, glb_binary);
    return bytes += glb.binary;
}

}  // namespace knead
