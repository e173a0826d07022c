// A picture, and its file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace knead {

struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // 3 * width * height, sRGB, top row first
};

constexpr std::size_t max_picture_pixels = std::size_t(1) << 26;  // of one that is read

// Reads a PNG of any kind as 8 bits a colour; throws InputError with path and reason.
Image read_png(const std::string& path);
// Writes a PNG, whole or not at all; throws OutputError with path and reason. `stop` is asked
// between its rows: true gives the picture up, nothing is then written, and the answer is false.
bool write_png(const std::string& path, const Image& image, const std::function<bool()>& stop = {});

}  // namespace knead
