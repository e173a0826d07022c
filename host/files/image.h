// A picture, and its file.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace knead {

struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // 3 * width * height, sRGB, top row first
};

// Writes a PNG, whole or not at all; throws OutputError with path and reason.
void write_png(const std::string& path, const Image& image);

}  // namespace knead
