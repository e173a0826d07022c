// WebP images of 8-bit RGBA, through libwebp where the build has it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace knead {

bool webp_available();

struct RgbaImage {
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels;  // RGBA, rows from the top
};

// Throws InputError with `what`, the file and place, for no WebP image, a damaged one, and one of
// more than `most` pixels, which is known before anything is allocated; ResourceError without
// libwebp.
RgbaImage read_webp(const std::string& bytes, const std::string& what, std::size_t most);

// Lossless, transparent pixels included. Throws as std::bad_alloc where libwebp fails,
// ResourceError without libwebp.
std::string webp_bytes(const RgbaImage& image);

}  // namespace knead
